//! `lab map` with a robot's answers recorded in a file.

use crate::common::Place;
use predicates::prelude::*;
use predicates::str::contains;
use wire::{Frame, MapAnswer, MapRefusal, PIECE_BYTES, Sample, encode};

/// A robot's telemetry with these answers between.
fn line(answers: impl Iterator<Item = MapAnswer>) -> Vec<u8> {
    let sample = || Frame::Sample(Sample::default());
    answers.flat_map(|answer| [sample(), Frame::MapAnswer(answer)]).flat_map(|frame| encode(&frame).unwrap()).collect()
}

#[test]
fn a_map_is_fetched_whole_and_a_refusal_says_why() {
    let place = Place::new();
    place.lab().args(["run", "--plan", "room", "--minutes", "0.5", "--out", "run"]).assert().success();
    let map = std::fs::read(place.path("run/map.bin")).unwrap();
    let parts = map.chunks(PIECE_BYTES).enumerate().map(|(index, piece)| MapAnswer::Part {
        offset: (index * PIECE_BYTES) as u32,
        of: map.len() as u32,
        bytes: piece.iter().copied().collect(),
    });
    std::fs::write(place.path("line"), line(parts)).unwrap();
    let get = ["map", "get", "--port", "line", "--out", "fetched.bin"];
    place.lab().args(get).assert().success().stdout(contains(format!("fetched.bin: {} bytes", map.len())));
    assert_eq!(std::fs::read(place.path("fetched.bin")).unwrap(), map);

    std::fs::write(place.path("refuses"), line([MapAnswer::Refused(MapRefusal::Driving)].into_iter())).unwrap();
    let put = ["map", "put", "run/map.bin", "--port", "refuses"];
    place.lab().args(put).assert().failure().stderr(contains("the robot is driving").and(contains("stop it first")));
    std::fs::write(place.path("silent"), line(std::iter::empty())).unwrap();
    place.lab().args(["map", "forget", "--port", "silent"]).assert().failure().stderr(contains("nothing arrives"));
}

#[test]
fn what_is_no_map_is_refused_before_a_robot_is_looked_for() {
    let place = Place::new();
    std::fs::write(place.path("no-map.bin"), "walls").unwrap();
    let put = |file: &str| place.lab().args(["map", "put", file, "--port", "no-port"]).assert().failure();
    put("no-map.bin").stderr(contains("no-map.bin: is no kept map"));
    put("not-there.bin").stderr(contains("not-there.bin"));
}

#[test]
fn a_fetched_map_takes_no_other_files_place() {
    let place = Place::new();
    let get = |file: &str| place.lab().args(["map", "get", "--port", "no-port", "--out", file]).assert().failure();
    place.put("letter.txt", "wall by wall");
    get("letter.txt").stderr(contains("letter.txt: is no kept map and would be overwritten"));
    assert_eq!(place.get("letter.txt"), "wall by wall");
    std::fs::create_dir(place.path("folder")).unwrap();
    get("folder").stderr(contains("folder: "));
    for free in ["empty", "map.bin"] {
        place.put(free, if free == "empty" { "" } else { "wallmap\0 of old" });
        get(free).stderr(contains("no-port: "));
    }
}
