//! `lab run` as a user calls it.

use crate::common::{Place, SHARP_RIG};
use predicates::prelude::*;
use predicates::str::contains;

const OUTPUTS: [&str; 9] = [
    "trajectory.tum",
    "truth.tum",
    "estimate.csv",
    "walls.csv",
    "calibration.csv",
    "summary.json",
    "report.html",
    "log.csv",
    "rig.toml",
];

#[test]
fn without_arguments_it_simulates_into_out_run() {
    let place = Place::new();
    place
        .lab()
        .args(["--minutes", "0.2"])
        .assert()
        .success()
        .stdout(contains("flat:").and(contains("dead reckoning")).and(contains("results in out/run")));
    for name in OUTPUTS {
        assert!(place.path("out/run").join(name).exists(), "{name}");
    }
    let summary = place.summary("out/run");
    assert_eq!(summary["seed"], 1);
    assert_eq!(summary["rows"], 301);
    assert_eq!(summary["configuration"]["arguments"]["plan"], "flat");
    for key in ["ate_m", "start_m", "heading_deg", "mean_nis", "path_m", "duration_s"] {
        assert!(summary[key].is_number(), "{key}: {summary}");
    }
    assert!(summary["odometry"]["ate_m"].is_number());
    assert!(summary["map"]["missed"].is_number());
}

#[test]
fn a_replay_of_the_runs_log_gives_the_same_estimate_bit_for_bit() {
    let place = Place::new();
    place.lab().args(["run", "--plan", "room", "--minutes", "1", "--seed", "7", "--out", "one"]).assert().success();
    place.lab().args(["replay", "one/log.csv", "--rig", "one/rig.toml", "--out", "two"]).assert().success();
    for name in ["estimate.csv", "trajectory.tum", "truth.tum", "walls.csv", "calibration.csv"] {
        assert_eq!(place.get(&format!("one/{name}")), place.get(&format!("two/{name}")), "{name}");
    }
    for key in ["ate_m", "start_m", "heading_deg", "nees", "mean_nis", "odometry", "counters"] {
        assert_eq!(place.summary("one")[key], place.summary("two")[key], "{key}");
    }
    // The replay may go into the run's own folder, whose log and rig stay.
    let log = place.get("one/log.csv");
    place.lab().args(["replay", "one/log.csv", "--rig", "one/rig.toml", "--out", "one"]).assert().success();
    assert_eq!(place.get("one/log.csv"), log);
    place.lab().args(["run", "--plan", "room", "--minutes", "0.1", "--out", "one"]).assert().success();
}

#[test]
fn a_seed_is_a_drive() {
    let place = Place::new();
    for (seed, out) in [("3", "a"), ("3", "b"), ("4", "c")] {
        place.lab().args(["--plan", "l-shape", "--minutes", "0.5", "--seed", seed, "--out", out]).assert().success();
    }
    for name in ["log.csv", "estimate.csv", "walls.csv"] {
        assert_eq!(place.get(&format!("a/{name}")), place.get(&format!("b/{name}")), "{name}");
        assert_ne!(place.get(&format!("a/{name}")), place.get(&format!("c/{name}")), "{name}");
    }
}

#[test]
fn a_rig_file_changes_the_robot() {
    let place = Place::new();
    let rig = place.put("one-eyed.toml", SHARP_RIG);
    place.lab().args(["--minutes", "0.1", "--rig"]).arg(rig).assert().success();
    let header = place.get("out/run/log.csv");
    assert!(header.starts_with("t_s,left_ticks,right_ticks,adc_0,lifted,docked,true_x_m,true_y_m,true_theta_rad\n"));
    assert_eq!(place.get("out/run/rig.toml"), SHARP_RIG);
}

#[test]
fn a_plan_file_is_a_plan_and_its_text_is_kept() {
    let place = Place::new();
    let (name, text) = hal_sim::plan_file::BUILT_IN[0];
    place.put("mine.toml", text);
    place.lab().args(["--plan", "mine.toml", "--minutes", "0.2", "--out", "file"]).assert().success();
    place.lab().args(["--plan", name, "--minutes", "0.2", "--out", "built-in"]).assert().success();
    assert_eq!(place.get("file/estimate.csv"), place.get("built-in/estimate.csv"));
    assert_eq!(place.summary("file")["configuration"]["arguments"]["plan_toml"], text);
}

#[test]
fn wrong_requests_get_one_clear_error() {
    let place = Place::new();
    place.put("bad-plan.toml", "[start]\nx_m = 1\n");
    let cases: [(&[&str], &str); 9] = [
        (&["--plan", "castle"], "castle"),
        (&["--plan", "bad-plan.toml"], "bad-plan.toml"),
        (&["--minutes", "0"], "above 0"),
        (&["--minutes", "nan"], "above 0"),
        (&["--seed", "-1"], "seed"),
        (&["--rig", "none.toml"], "none.toml: cannot read"),
        (&["--rig", "nope"], "no such built-in robot; built in are sharp, time-of-flight and odometry"),
        (&["--seed", "-1"], "it must be a whole number from 0 to 18446744073709551615"),
        (&["fly"], "fly"),
    ];
    for (arguments, expected) in cases {
        place.lab().args(arguments).assert().failure().stderr(contains(expected));
    }
    assert!(!place.path("out").exists(), "nothing was run");
}

#[test]
fn foreign_files_are_not_overwritten() {
    let place = Place::new();
    place.put("mine/log.csv", "my only copy");
    let refusal = "mine/log.csv: is not a result of";
    place.lab().args(["--minutes", "0.1", "--out", "mine"]).assert().failure().stderr(contains(refusal));
    assert_eq!(place.get("mine/log.csv"), "my only copy");
    assert!(!place.path("mine/summary.json").exists());
    place.put("other/summary.json", "{\"program\": \"another\", \"files\": [\"summary.json\"]}");
    place.lab().args(["--minutes", "0.1", "--out", "other"]).assert().failure().stderr(contains("summary.json"));
    place.put("good/notes.txt", "keep me");
    for _ in 0..2 {
        place.lab().args(["--minutes", "0.1", "--out", "good"]).assert().success();
    }
    assert_eq!(place.get("good/notes.txt"), "keep me");
    place.put("file", "not a folder");
    place.lab().args(["--minutes", "0.1", "--out", "file"]).assert().failure().stderr(contains("file: "));
}

#[test]
fn a_folder_that_another_run_writes_is_left_alone() {
    use lab::show::output::folder::Folder;
    let place = Place::new();
    let run = || place.lab().args(["--plan", "room", "--minutes", "0.1", "--out", "out"]).assert();
    let held = Folder::prepare(&place.path("out"), &["log.csv"]).expect("an empty folder");
    run().failure().stderr(predicates::str::contains("summary.json: is being written by another run; wait"));
    drop(held);
    run().success();
}

#[test]
fn every_built_in_robot_maps_and_its_log_replays_to_the_same_bits() {
    for robot in ["time-of-flight", "odometry"] {
        let place = Place::new();
        place
            .lab()
            .args(["run", "--plan", "room", "--minutes", "1", "--rig", robot, "--out", "run"])
            .assert()
            .success();
        let summary = place.summary("run");
        assert!(summary["ate_m"].as_f64().unwrap() < 0.05, "{robot}: {}", summary["ate_m"]);
        assert_eq!(summary["map"]["missed"], 0, "{robot}");
        let replay = ["replay", "run/log.csv", "--rig", "run/rig.toml", "--out", "again"];
        place.lab().args(replay).assert().success();
        assert!(place.get("run/estimate.csv") == place.get("again/estimate.csv"), "{robot}: other bits");
    }
}

#[test]
fn a_robot_that_cannot_get_away_is_said_to_be_stuck() {
    let place = Place::new();
    place.put(
        "closet.toml",
        "[start]\nx_m = 0.25\ny_m = 0.25\n[[outline]]\npoints_m = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]\n",
    );
    place.lab().args(["--plan", "closet.toml", "--minutes", "4"]).assert().stdout(contains("pilot stuck from"));
    let stuck_from_s = place.summary("out/run")["stuck_from_s"].as_f64().expect("a time");
    assert!(stuck_from_s < 150.0, "{stuck_from_s} s");
    place.lab().args(["--plan", "room", "--minutes", "1"]).assert().success();
    assert!(place.summary("out/run")["stuck_from_s"].is_null());
}

#[test]
fn another_system_replays_a_log_into_the_same_outputs() {
    let place = Place::new();
    place.lab().args(["run", "--plan", "room", "--minutes", "1", "--out", "one"]).assert().success();
    let replay = |with: &str, out: &str| {
        place.lab().args(["replay", "one/log.csv", "--rig", "one/rig.toml", "--out", out, "--with", with]).assert()
    };
    replay("dead-reckoning", "odometry").success();
    let summary = place.summary("odometry");
    let [own, odometry] = [&summary["ate_m"], &summary["odometry"]["ate_m"]].map(|ate| ate.as_f64().expect("a score"));
    assert!((own - odometry).abs() < 1e-6, "{own} {odometry}");
    replay("choi-2008", "choi").success();
    let summary = place.summary("choi");
    assert!(summary["walls"].as_u64().is_some_and(|walls| walls >= 3), "{summary}");
    assert!(summary["consistency"]["entropy_nats"].is_number());
    assert!(place.path("choi/report.html").exists());
    // Ranges of a robot in the air do not count: it maps no wall.
    let log = place.get("one/log.csv");
    let column = log.lines().next().and_then(|header| header.split(',').position(|name| name == "lifted"));
    let lift = |(i, line): (usize, &str)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[column.expect("the column")] = if i == 0 { "lifted" } else { "1" };
        cells.join(",") + "\n"
    };
    let lifted: String = log.lines().enumerate().map(lift).collect();
    place.put("one/lifted.csv", lifted);
    place.put("one/empty.csv", format!("{}\n", log.lines().next().expect("a header")));
    let of = |log: &str, more: &[&str]| {
        let replay = ["replay", log, "--rig", "one/rig.toml", "--out", "of", "--with", "choi-2008"];
        place.lab().args(replay).args(more).assert()
    };
    of("one/lifted.csv", &[]).success();
    assert_eq!(place.summary("of")["walls"], 0);
    of("one/empty.csv", &[]).failure().code(1).stderr(contains("one/empty.csv: has a header but no rows"));
    of("one/log.csv", &["--without", "grid"]).failure().stderr(contains("cannot be used with"));
    of("one/log.csv", &["--hand-overs", "true"]).failure().stderr(contains("cannot be used with"));
    let slow = log.lines().enumerate().filter(|(i, _)| *i == 0 || i % 50 == 1).map(|(_, line)| format!("{line}\n"));
    place.put("one/slow.csv", slow.collect::<String>());
    of("one/slow.csv", &[]).success().stderr(contains("rows a second; three are needed"));
    assert_eq!(place.summary("of")["notes"].as_array().map(Vec::len), Some(1));
    replay("nobody", "none").failure().stderr(contains("it must be one of dead-reckoning, abrate"));
}

#[test]
fn a_run_and_its_replay_are_written_for_foxglove() {
    let place = Place::new();
    place
        .lab()
        .args(["run", "--plan", "room", "--minutes", "0.1", "--out", "run", "--mcap", "run.mcap"])
        .assert()
        .success();
    let replay = ["replay", "run/log.csv", "--rig", "run/rig.toml", "--out", "again", "--mcap", "again.mcap"];
    place.lab().args(replay).assert().success();
    for name in ["run.mcap", "again.mcap"] {
        let bytes = std::fs::read(place.path(name)).unwrap();
        // The format begins and ends with these eight bytes.
        assert!(
            bytes.starts_with(b"\x89MCAP0\r\n") && bytes.ends_with(b"\x89MCAP0\r\n") && bytes.len() > 10_000,
            "{name}"
        );
    }
    // Its own file it writes again; another one it leaves alone, and says so before it drives.
    place.lab().args(replay).assert().success();
    for (out, file) in [("again", "run/log.csv"), ("again", "run/rig.toml"), ("run", "run/estimate.csv")] {
        let before = place.get(file);
        let replay = ["replay", "run/log.csv", "--rig", "run/rig.toml", "--out", out, "--mcap", file];
        let reason = format!("{file}: is no MCAP file that lab wrote");
        place.lab().args(replay).assert().failure().stderr(contains(reason));
        assert_eq!(place.get(file), before, "{file}");
    }
    // Its folder is made, or is said before the drive to be impossible.
    let to = |file| place.lab().args(["run", "--minutes", "0.1", "--out", "other", "--mcap", file]).assert();
    to("run.mcap/in/a/file.mcap").failure().stderr(contains("run.mcap/in/a: cannot create"));
    assert!(!place.path("other").exists());
    to("new/folder/run.mcap").success();
    assert!(place.path("new/folder/run.mcap").exists());
}

#[test]
fn the_rig_file_of_a_run_says_what_is_taken_over_where_that_is_not_the_default() {
    let place = Place::new();
    let run = ["run", "--plan", "room", "--minutes", "1", "--hand-overs"];
    place.lab().args(run).args(["false", "--out", "run"]).assert().success();
    assert!(place.get("run/rig.toml").starts_with("hand_overs = false\n\n["));
    place.lab().args(["replay", "run/log.csv", "--rig", "run/rig.toml", "--out", "again"]).assert().success();
    assert_eq!(place.summary("again")["configuration"]["estimator"]["hand_overs"], false);
    assert_eq!(place.get("again/estimate.csv"), place.get("run/estimate.csv"));
    place.lab().args(run).args(["true", "--rig", "run/rig.toml", "--out", "other"]).assert().success();
    let rig = place.get("other/rig.toml");
    assert!(rig.starts_with("hand_overs = true\n\n[") && rig.matches("hand_overs").count() == 1, "{rig}");
}

#[test]
fn a_fault_of_a_sensor_that_is_not_there_is_the_plans() {
    let place = Place::new();
    let plan = hal_sim::plan_file::BUILT_IN.iter().find(|(name, _)| *name == "room").expect("the room").1;
    place.put("plan.toml", format!("{plan}\n[[fault]]\npart = \"sensor\"\nsensor = 8\n"));
    let run = place.lab().args(["run", "--plan", "plan.toml", "--minutes", "0.1", "--out", "run"]).assert();
    run.failure().stderr(contains("plan.toml: fault[0].sensor is 8; the rig has 8 range sensors, counted from 0"));
}
