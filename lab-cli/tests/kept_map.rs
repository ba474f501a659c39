//! `map.bin`, `--map` and `--start` as a user calls them.

use std::fs;

use crate::common::{Place, SHARP_RIG};
use predicates::str::contains;

/// A place with a map of the flat.
fn with_map() -> Place {
    with_map_of("1")
}

/// The same of a drive with this seed.
fn with_map_of(seed: &str) -> Place {
    let place = Place::new();
    place.lab().args(["run", "--minutes", "5", "--seed", seed, "--out", "first"]).assert().success();
    place
}

/// The columns `located`, x and y.
fn poses(place: &Place, file: &str, columns: [&str; 3]) -> Vec<[f64; 3]> {
    let text = place.get(file);
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let places = columns.map(|column| header.iter().position(|name| *name == column).expect("the column"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        places.map(|place| cells[place].parse().expect("a number"))
    };
    lines.map(row).collect()
}

#[test]
fn a_robot_that_starts_anywhere_finds_itself_in_the_map() {
    let place = with_map();
    let run = ["run", "--map", "first/map.bin", "--start", "6.0,4.5,130", "--seed", "3", "--minutes", "2"];
    place.lab().args(run).args(["--out", "second"]).assert().success();
    let estimate = poses(&place, "second/estimate.csv", ["located", "x_m", "y_m"]);
    let truth = poses(&place, "second/log.csv", ["lifted", "true_x_m", "true_y_m"]);
    assert_eq!((estimate[0][0], estimate.last().expect("rows")[0]), (0.0, 1.0));
    for ([located, x_m, y_m], [_, true_x_m, true_y_m]) in estimate.iter().zip(&truth) {
        let off_m = (x_m - true_x_m).hypot(y_m - true_y_m);
        assert!(*located == 0.0 || off_m < 0.15, "{off_m}");
    }
    let summary = place.summary("second");
    assert!(summary["start_m"].as_f64().expect("a score") < 0.1, "{summary}");
    // A replay of its log is the same drive, bit for bit.
    let replay = ["replay", "second/log.csv", "--rig", "second/rig.toml", "--map", "first/map.bin", "--out", "third"];
    place.lab().args(replay).assert().success();
    assert_eq!(place.get("second/estimate.csv"), place.get("third/estimate.csv"));
    assert!(
        fs::read(place.path("second/map.bin")).expect("a map") != fs::read(place.path("first/map.bin")).expect("a map")
    );
}

#[test]
fn a_save_leaves_the_map_before_it_until_it_is_whole() {
    let place = with_map();
    let first = fs::read(place.path("first/map.bin")).expect("a map");
    // Into the folder that the map is in: both are there, and the newer one counts.
    let again = ["run", "--map", "first/map.bin", "--seed", "2", "--minutes", "2", "--out", "first"];
    place.lab().args(again).assert().success();
    let both = fs::read(place.path("first/map.bin")).expect("a map");
    assert!(both.starts_with(&first) && both.len() > 512 * 1024);
    let walls = |name: &str, map: &[u8]| {
        place.put("one.bin", map);
        place.lab().args(["run", "--map", "one.bin", "--minutes", "0.1", "--out", name]).assert().success();
        // A robot that finds nothing keeps what it had, alone.
        fs::read(place.path(&format!("{name}/map.bin"))).expect("a map")
    };
    let content = |map: &[u8]| map[24..map.len() - 4].to_vec();
    let (older, newer) = (walls("older", &first), walls("newer", &both));
    assert_eq!(content(&older), content(&first));
    assert_ne!(content(&newer), content(&first));
    // Cut anywhere in the newer one, the older one counts.
    for share in [1, 7, 9] {
        let cut = 512 * 1024 + share * (both.len() - 512 * 1024) / 10;
        assert_eq!(content(&walls("cut", &both[..cut])), content(&first));
    }
}

#[test]
fn a_lifted_robot_finds_its_map_again() {
    let place = Place::new();
    let plan = hal_sim::plan_file::BUILT_IN.iter().find(|(name, _)| *name == "flat").expect("the flat").1;
    place.put("lifted.toml", format!("{plan}\n[[kidnap]]\nat_s = 200.0\nto_m = [6.0, 4.5]\n"));
    place.lab().args(["run", "--plan", "lifted.toml", "--minutes", "6", "--out", "run"]).assert().success();
    let estimate = poses(&place, "run/estimate.csv", ["located", "x_m", "y_m"]);
    let located = |index: usize| estimate[index][0] == 1.0;
    // In the air for half a second: lifted.
    assert!(located(0) && located(5010) && !located(5020) && !located(5130) && located(9000));
    assert!(place.summary("run")["start_m"].as_f64().expect("a score") < 0.1);
    place.lab().args(["replay", "run/log.csv", "--rig", "run/rig.toml", "--out", "again"]).assert().success();
    assert_eq!(place.get("run/estimate.csv"), place.get("again/estimate.csv"));
}

#[test]
fn what_is_no_map_of_this_robot_is_refused_with_the_reason() {
    let place = with_map();
    let good = fs::read(place.path("first/map.bin")).expect("a map");
    let mut damaged = good.clone();
    damaged[500] ^= 1;
    let mut older = good.clone();
    older[8] = 0;
    place.put("damaged.bin", damaged);
    place.put("short.bin", &good[..good.len() / 2]);
    place.put("older.bin", older);
    place.put("rig.toml", SHARP_RIG);
    let refused = |arguments: &[&str], reason: &str| {
        place
            .lab()
            .args(["run", "--minutes", "0.1", "--out", "out"])
            .args(arguments)
            .assert()
            .failure()
            .stderr(contains(reason));
    };
    refused(&["--map", "first/walls.csv"], "first/walls.csv: is no kept map");
    refused(&["--map", "damaged.bin"], "damaged.bin: is a damaged kept map");
    refused(&["--map", "short.bin"], "short.bin: is a damaged kept map");
    refused(&["--map", "older.bin"], "older.bin: is a kept map of version 0; this program reads versions 1 to 2");
    refused(&["--map", "first/map.bin", "--rig", "rig.toml"], "first/map.bin: is the map of a robot with another rig");
    refused(&["--map", "first/map.bin", "--no-calibration"], "first/map.bin: was made with other settings");
    refused(
        &["--map", "first/map.bin", "--walls", "free"],
        "first/map.bin: was made with other settings for its walls",
    );
    refused(&["--map", "first/map.bin", "--walls", "snapped"], "the same --walls is needed");
    refused(&["--map", "none.bin"], "none.bin");
    refused(&["--start", "1,2"], "it must be three numbers");
    refused(&["--start", "0.1,0.1,0"], "the robot's radius is");
    let outside = "flat: the place of --start is outside the outline or in a box";
    refused(&["--start", "100,100,0"], outside);
    refused(&["--start=-1,1,0"], outside);
    refused(&["--map", "first/map.bin", "--start", "100,100,0"], outside);
}

#[test]
fn a_robot_that_was_switched_off_finds_itself_sooner_where_it_was() {
    // In the maps of the seeds 2 to 6 it does; in that of 1 it has to see as much with the record of where it was as without.
    let place = with_map_of("2");
    let log = place.get("first/log.csv");
    let (header, last) = (log.lines().next().expect("a header"), log.lines().last().expect("rows"));
    let [x_m, y_m, theta_rad] = ["true_x_m", "true_y_m", "true_theta_rad"].map(|name| {
        let column = header.split(',').position(|cell| cell == name).expect("the column");
        last.split(',').nth(column).and_then(|cell| cell.parse().ok()).expect("a number")
    });
    let flat = hal_sim::plan_file::load("flat").expect("the flat");
    let at = flat.start.compose(&hal_sim::Pose2::new(x_m, y_m, theta_rad));
    let start = format!("{},{},{}", at.x_m, at.y_m, at.theta_rad.to_degrees());
    place.put("alone/map.bin", fs::read(place.path("first/map.bin")).expect("a map"));
    place.put("other/map.bin", fs::read(place.path("first/map.bin")).expect("a map"));
    let mut pose = fs::read(place.path("first/pose.bin")).expect("a pose");
    pose[13] ^= 1;
    place.put("other/pose.bin", pose);
    let rows = ["first", "alone", "other"].map(|from| {
        let (map, out) = (format!("{from}/map.bin"), format!("from-{from}"));
        let run = ["run", "--map", &map, "--start", &start, "--seed", "3", "--minutes", "3", "--out", &out];
        place.lab().args(run).assert().success();
        let located = poses(&place, &format!("{out}/estimate.csv"), ["located", "x_m", "y_m"]);
        located.iter().position(|row| row[0] == 1.0).expect("it finds itself")
    });
    assert!(rows[0] < rows[1], "{rows:?}");
    assert_eq!(rows[1], rows[2], "a damaged record says nothing");
    // Into the folder that it began in: the pose of before goes.
    let lost = ["run", "--map", "alone/map.bin", "--minutes", "0.1", "--out", "from-first"];
    place.lab().args(lost).assert().success();
    assert!(!place.path("from-first/pose.bin").exists(), "it does not know where it is");
}

#[test]
fn a_robot_that_never_found_itself_leaves_the_map_as_it_was() {
    let place = with_map();
    let map = || fs::read(place.path("first/map.bin")).expect("a map");
    let before = map();
    place.lab().args(["run", "--seed", "2", "--minutes", "0.1", "--out", "short"]).assert().success();
    // A job in the map counts as long as the map has its check sum.
    let replay = ["replay", "short/log.csv", "--rig", "short/rig.toml", "--map", "first/map.bin", "--out", "first"];
    place.lab().args(replay).assert().success().stderr(contains("map.bin is as it was"));
    assert!(map() == before);
}
