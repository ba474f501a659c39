//! `lab monitor` on recorded bytes.

use crate::common::Place;
use predicates::prelude::*;
use predicates::str::contains;
use wire::{BoardFaults, Estimate, Faults, Floor, Frame, Range, Sample, SlamFaults, encode};

/// What a robot that stands still says in two seconds, joined in the middle of a frame.
fn recorded(sensors: u16, range: impl Fn(u16, u16) -> Range) -> Vec<u8> {
    let mut bytes = vec![3, 1, 4, 0];
    for step in 1..=50_u64 {
        let time_us = step * 40_000;
        let ranges = (0..sensors).map(|i| range(step as u16, i)).collect();
        let sample = Sample { time_us, left_ticks: 7, right_ticks: -7, ranges, ..Sample::default() };
        let estimate = Estimate { time_us, pose: [1.25, -0.5, 0.1], ..Estimate::default() };
        let board = BoardFaults { contact_stops: 2, ..BoardFaults::default() };
        let faults = Faults { slam: SlamFaults::default(), board };
        let floor = Floor { state: 1, swept_m2: 6.0, left_m2: 2.0, seconds: 125 };
        for frame in [Frame::Sample(sample), Frame::Estimate(estimate), Frame::Faults(faults), Frame::Floor(floor)] {
            bytes.extend(encode(&frame).unwrap());
        }
    }
    bytes
}

#[test]
fn it_shows_the_robot_and_records_a_log_that_replays() {
    let place = Place::new();
    let counts = |step, i| Range::Counts(900 + (step % 3) * 5 + i);
    std::fs::write(place.path("line"), recorded(8, counts)).unwrap();
    place
        .lab()
        .args(["monitor", "--port", "line", "--out", "seen", "--mcap", "seen.mcap", "--serve", "127.0.0.1:0"])
        .assert()
        .success()
        .stdout(contains("x 1.250 m   y -0.500 m").and(contains("contact stops 2")).and(contains("1 damaged")))
        .stdout(contains("floor     lanes; 6.0 m2 swept, 75 % of what was seen, after 2 min 5 s"));
    assert_eq!(place.get("seen/log.csv").lines().count(), 51);
    assert!(std::fs::read(place.path("seen.mcap")).unwrap().ends_with(b"\x89MCAP0\r\n"));
    place.lab().args(["replay", "seen/log.csv", "--rig", "seen/rig.toml", "--out", "replayed"]).assert().success();
    assert_eq!(place.summary("replayed")["rows"], 50);
}

#[test]
fn metres_are_recorded_as_metres_and_are_not_taken_for_counts() {
    let place = Place::new();
    let metres = |step, i| if i == 2 { Range::Missing } else { Range::Metres(0.5 + 0.01 * f32::from(step % 3 + i)) };
    std::fs::write(place.path("line"), recorded(4, metres)).unwrap();
    let monitor = |rig: &[&str]| place.lab().args(["monitor", "--port", "line", "--out", "seen"]).args(rig).assert();
    monitor(&[]).failure().stderr(contains("metres of range sensor 0").and(contains("--rig")));
    monitor(&["--rig", "time-of-flight"]).success().stdout(contains("0.52 m"));
    let log = place.get("seen/log.csv");
    assert!(log.starts_with("t_s,left_ticks,right_ticks,range_0_m,range_1_m,range_2_m,range_3_m,"), "{log}");
    assert!(log.lines().nth(1).unwrap().starts_with("0.04,7,-7,0.51,0.52,,0.54,"), "{log}");
    place.lab().args(["replay", "seen/log.csv", "--rig", "seen/rig.toml", "--out", "replayed"]).assert().success();
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let place = Place::new();
    place
        .lab()
        .args(["monitor", "--port", "/dev/no-such-port"])
        .assert()
        .failure()
        .stderr(contains("/dev/no-such-port"));
}

#[test]
fn a_line_of_another_rate_is_told_apart_from_a_silent_one() {
    let place = Place::new();
    place.put("garbage", [0x55; 3000]);
    place.put("silence", "");
    let garbage = contains("garbage: 3000 bytes arrive and no whole frame").and(contains("115200 baud"));
    let monitor = |line: &str| place.lab().args(["monitor", "--port", line, "--out", "seen"]).assert().failure();
    monitor("garbage").stderr(garbage);
    monitor("silence").stderr(contains("silence: nothing arrives"));
    let doctor = |line: &str| place.lab().args(["doctor", "--port", line]).assert().failure();
    doctor("garbage").stderr(contains("3000 bytes arrive and no whole frame"));
    doctor("silence").stderr(contains("nothing arrives"));
}

#[test]
fn what_was_recorded_before_stays_until_a_robot_of_the_rig_speaks() {
    let place = Place::new();
    std::fs::write(place.path("line"), recorded(8, |step, i| Range::Counts(900 + step + i))).unwrap();
    std::fs::write(place.path("other"), recorded(8, |_, _| Range::Metres(0.5))).unwrap();
    place.put("silence", "");
    let monitor =
        |line: &str| place.lab().args(["monitor", "--port", line, "--out", "seen", "--mcap", "seen.mcap"]).assert();
    monitor("line").success();
    let files = || ["seen/log.csv", "seen.mcap"].map(|file| std::fs::read(place.path(file)).unwrap());
    let before = files();
    for line in ["silence", "other"] {
        monitor(line).failure();
        assert!(files() == before, "{line}");
    }
}
