//! `lab run --job clean` where the plan says what is to be cleaned.

use crate::common::Place;
use predicates::str::contains;

const ROOM: &str = "[start]\nx_m = 0.6\ny_m = 0.6\n\
    [[outline]]\npoints_m = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]\n";

/// Lower and upper corner of what the robot stays out of, metres.
const CARPET: [[f64; 2]; 2] = [[2.0, 1.2], [3.0, 2.0]];

fn rectangle(kind: &str, [[x0, y0], [x1, y1]]: [[f64; 2]; 2]) -> String {
    format!("[[{kind}]]\npoints_m = [[{x0}, {y0}], [{x1}, {y0}], [{x1}, {y1}], [{x0}, {y1}]]\n")
}

/// Positions of a file in the plan's frame, metres.
fn path(place: &Place, file: &str) -> Vec<[f64; 2]> {
    let position = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        [0.6 + numbers[1], 0.6 + numbers[2]]
    };
    place.get(file).lines().map(position).collect()
}

fn distance_m([[x0, y0], [x1, y1]]: [[f64; 2]; 2], [x, y]: [f64; 2]) -> f64 {
    (x0 - x).max(x - x1).max(0.0).hypot((y0 - y).max(y - y1).max(0.0))
}

#[test]
fn a_keep_out_area_is_gone_round_and_its_edge_is_swept() {
    let place = Place::new();
    place.put("home.toml", format!("{ROOM}{}", rectangle("keep_out", CARPET)));
    place.lab().args(["run", "--job", "clean", "--plan", "home.toml", "--out", "swept"]).assert().success();
    let nearest_m =
        |file| path(&place, file).into_iter().map(|at| distance_m(CARPET, at)).fold(f64::INFINITY, f64::min);
    // By its own pose the body, 17 cm in radius, never comes over the edge, and goes along it.
    let estimated_m = nearest_m("swept/trajectory.tum");
    assert!((0.18..0.25).contains(&estimated_m), "{estimated_m} m");
    let true_m = nearest_m("swept/truth.tum");
    assert!((0.17..0.25).contains(&true_m), "{true_m} m");
    let floor = place.summary("swept")["floor"].clone();
    let floor_m2 = floor["floor_m2"].as_f64().unwrap();
    // A room of 12 m^2 less a rim of 4.5 cm along its walls, and the carpet with such a rim.
    let expected_m2 = 3.91 * 2.91 - 1.09 * 0.89;
    assert!((floor_m2 - expected_m2).abs() < 0.3, "{floor_m2} m2, not {expected_m2}");
    assert!(floor["swept"].as_f64().unwrap() > 0.96, "{floor}");
    assert_eq!(place.get("swept/floor.csv").lines().next(), Some("t_s,swept,twice"));
    assert!(std::fs::read(place.path("swept/floor.pgm")).unwrap().starts_with(b"P5\n# corner_m 0 0 cell_m 0.025\n"));
}

#[test]
fn only_what_is_to_be_cleaned_is_cleaned() {
    let place = Place::new();
    let corner = [[0.0, 0.0], [2.0, 3.0]];
    place.put("home.toml", format!("{ROOM}{}", rectangle("clean", corner)));
    place.lab().args(["run", "--job", "clean", "--plan", "home.toml", "--out", "swept"]).assert().success();
    let floor = place.summary("swept")["floor"].clone();
    assert!((floor["floor_m2"].as_f64().unwrap() - 1.955 * 2.91).abs() < 0.2, "{floor}");
    assert!(floor["swept"].as_f64().unwrap() > 0.96, "{floor}");
    let path = path(&place, "swept/truth.tum");
    let beyond = path.iter().filter(|at| distance_m(corner, **at) > 0.3).count();
    // Once round the room, whose walls it does not know yet, is a third of its path.
    assert!(2 * beyond < path.len(), "{beyond} of {} samples were elsewhere", path.len());
}

#[test]
fn an_area_that_is_walled_in_is_said_not_to_be_reached() {
    let place = Place::new();
    let wall = "[[box]]\nmin_m = [2.9, 0.0]\nmax_m = [3.0, 3.0]\n";
    let areas = [[[0.5, 0.5], [1.5, 1.5]], [[3.2, 0.5], [3.8, 2.5]]].map(|area| rectangle("clean", area)).concat();
    place.put("home.toml", format!("{ROOM}{wall}{areas}"));
    let said = place.lab().args(["run", "--job", "clean", "--plan", "home.toml", "--out", "swept"]).assert().success();
    let note = "nothing of clean[1] was swept: the robot found no way there";
    said.stderr(contains(format!("note: home.toml: {note}\n")));
    assert_eq!(place.summary("swept")["notes"], serde_json::json!([note]));
    assert!(place.summary("swept")["floor"]["swept"].as_f64().unwrap() > 0.9);
}

#[test]
fn a_robot_that_begins_in_its_kept_map_finds_itself_sweeps_and_comes_back() {
    let place = Place::new();
    let run = |out: &str, more: &[&str]| {
        place.lab().args(["run", "--job", "clean", "--plan", "room", "--out", out]).args(more).assert().success();
    };
    run("first", &[]);
    run("second", &["--map", "first/map.bin", "--seed", "101"]);
    let estimate = place.get("second/estimate.csv");
    let located: Vec<bool> = estimate.lines().skip(1).map(|line| line.ends_with(",1")).collect();
    assert!(!located[0] && located[located.len() - 1]);
    let floor = place.summary("second")["floor"].clone();
    assert!(floor["swept"].as_f64().unwrap() > 0.96 && floor["home_m"].as_f64().unwrap() < 0.2, "{floor}");
}

/// With sensors that report metres a floor job takes over what look backs find, and the drive's own rig file says so.
#[test]
fn a_floor_job_of_a_robot_that_reports_metres_replays_to_the_same_bits() {
    let place = Place::new();
    let job =
        ["run", "--job", "clean", "--plan", "room", "--rig", "time-of-flight", "--minutes", "2", "--out", "swept"];
    place.lab().args(job).assert().success();
    assert!(place.get("swept/rig.toml").starts_with("hand_overs = true\n"));
    let taken = place.summary("swept")["hand_overs"].as_array().expect("a list").len();
    assert!(taken > 0, "none was taken over");
    let replay = ["replay", "swept/log.csv", "--rig", "swept/rig.toml", "--out", "again"];
    place.lab().args(replay).assert().success();
    assert_eq!(place.get("swept/estimate.csv"), place.get("again/estimate.csv"));
    let without = [&replay[..3], &["swept/rig.toml", "--hand-overs", "false", "--out", "without"]].concat();
    place.lab().args(without).assert().success();
    assert_ne!(place.get("swept/estimate.csv"), place.get("without/estimate.csv"));
    // What the default is need not be said.
    place.lab().args([&job[..9], &["--out", "told", "--hand-overs", "false"]].concat()).assert().success();
    assert!(!place.get("told/rig.toml").contains("hand_overs"));
    assert_eq!(place.summary("told")["hand_overs"], serde_json::json!([]));
    let explore = ["run", "--plan", "room", "--rig", "time-of-flight", "--minutes", "0.2", "--out", "explored"];
    place.lab().args(explore).assert().success();
    assert!(!place.get("explored/rig.toml").contains("hand_overs"));
}

#[test]
fn after_a_power_cut_it_goes_on_with_the_floor_that_was_left() {
    let place = Place::new();
    let run = |out: &str, more: &[&str]| {
        let clean = ["run", "--job", "clean", "--plan", "l-shape", "--out", out];
        place.lab().args(clean).args(more).assert().success()
    };
    let swept = |out: &str| {
        let floor = place.summary(out)["floor"].clone();
        assert!(floor["home_m"].as_f64().unwrap() < 0.2, "{floor}");
        floor["swept"].as_f64().unwrap()
    };
    // One drive comes by a quarter to two fifths of what was swept before.
    let mut again = 0.0;
    for (seed, out) in [("3", "third/"), ("2", "second/"), ("1", "")] {
        let [first, on] = ["first", "on"].map(|name| format!("{out}{name}"));
        run(&first, &["--minutes", "5", "--seed", seed]);
        run(&on, &["--map", &format!("{first}/map.bin"), "--seed", &format!("10{seed}")]);
        let left = 1.0 - place.summary(&first)["floor"]["swept"].as_f64().unwrap();
        assert!((0.2..0.6).contains(&left), "{left} left");
        let on_swept = swept(&on);
        assert!(left - 0.05 < on_swept, "{on_swept} swept of {left} left");
        again += (on_swept - left) / 3.0;
        assert!(!place.path(&format!("{on}/job.bin")).exists(), "nothing is left");
    }
    // What was left, and what they came by on the way.
    assert!(again < 0.35, "{again} swept again");

    // The same without what was saved, and with the job of another map.
    place.put("none/map.bin", std::fs::read(place.path("first/map.bin")).unwrap());
    run("anew", &["--map", "none/map.bin", "--seed", "101"]);
    assert!(swept("anew") > 0.96);
    place.put("other/map.bin", std::fs::read(place.path("on/map.bin")).unwrap());
    place.put("other/job.bin", std::fs::read(place.path("first/job.bin")).unwrap());
    let said = run("dropped", &["--map", "other/map.bin", "--minutes", "0.1"]);
    said.stderr(contains("note: job.bin: the saved floor job is of another kept map; all of the floor is swept"));
}

#[test]
fn a_robot_whose_battery_is_empty_charges_in_its_dock_and_goes_on() {
    let place = Place::new();
    // In its dock at the western wall.
    let home = ROOM.replace("x_m = 0.6\ny_m = 0.6\n", "x_m = 0.185\ny_m = 1.5\nheading_deg = 180\ndock = true\n");
    let battery = "[battery]\nlasts_min = 5.0\ncharges_min = 3.0\n";
    place.put("home.toml", format!("{home}{battery}"));
    place.lab().args(["run", "--job", "clean", "--plan", "home.toml", "--out", "swept"]).assert().success();
    let log = place.get("swept/log.csv");
    let column = log.lines().next().and_then(|header| header.split(',').position(|name| name == "docked"));
    let docked: Vec<bool> =
        log.lines().skip(1).map(|row| row.split(',').nth(column.expect("the column")) == Some("1")).collect();
    let left = docked.iter().position(|docked| !docked).expect("it leaves its dock");
    let charges = docked.iter().skip(left).filter(|docked| **docked).count();
    assert!(docked[0] && charges > 25 * 60, "{charges} samples in its dock");
    let floor = place.summary("swept")["floor"].clone();
    assert!(floor["swept"].as_f64().unwrap() > 0.96 && floor["home_m"].as_f64().unwrap() < 0.05, "{floor}");
    place.put("bad.toml", format!("{home}[battery]\nlasts_min = -5.0\ncharges_min = 3.0\n"));
    let refused = place.lab().args(["run", "--plan", "bad.toml", "--out", "bad"]).assert().failure();
    refused.stderr(contains("bad.toml:9: battery.lasts_min: is -5.0; it must be minutes above 0 and up to 100000"));
}

#[test]
fn a_robot_that_starts_where_it_must_not_go_is_refused() {
    let place = Place::new();
    place.put("home.toml", format!("{ROOM}{}", rectangle("keep_out", [[0.0, 0.0], [0.5, 3.0]])));
    let refused =
        place.lab().args(["run", "--job", "clean", "--plan", "home.toml", "--out", "swept"]).assert().failure();
    refused.stderr(contains("home.toml:1: start: is in a keep_out or less than 0.17 m beside it"));
}
