//! Every missing or impossible value of a rig file is an error that names file, line, key and what is allowed.

use std::path::Path;

use crate::common::{ODOMETRY_RIG, Place, SHARP_RIG, WHEELED_RIG};
use lab::input::rig_file::Robot;
use slam_core::{DriveModel, RangeModel};

fn error_of(text: &str) -> String {
    match Robot::parse(Path::new("rig.toml"), text) {
        Ok(robot) => panic!("accepted:\n{text}\nas {robot:?}"),
        Err(error) => error.to_string(),
    }
}

fn assert_error(text: &str, parts: &[&str]) {
    let error = error_of(text);
    for part in parts {
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
}

#[test]
fn good_files_are_read() {
    let robot = Robot::parse(Path::new("rig.toml"), WHEELED_RIG).expect("good");
    assert_eq!(robot.names, ["left", "front"]);
    assert!(matches!(robot.rig.drive, DriveModel::Wheels { track_sigma: 0.0, .. }), "track_sigma is optional");
    assert!((robot.rig.sensors[0].mount.bearing_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    let robot = Robot::parse(Path::new("rig.toml"), SHARP_RIG).expect("good");
    assert!(matches!(robot.rig.sensors[0].model, RangeModel::Sharp { .. }));
    let robot = Robot::parse(Path::new("rig.toml"), ODOMETRY_RIG).expect("good");
    assert!(matches!(robot.rig.drive, DriveModel::Odometry { .. }));
}

#[test]
fn a_written_rig_reads_back_as_the_same_robot() {
    let handing_over = format!("hand_overs = true\n{ODOMETRY_RIG}");
    for text in [WHEELED_RIG, SHARP_RIG, ODOMETRY_RIG, &handing_over] {
        let robot = Robot::parse(Path::new("rig.toml"), text).expect("good");
        assert_eq!(Robot::parse(Path::new("again.toml"), &robot.to_toml()).expect("good"), robot);
    }
    let (robot, text) = lab::input::built_in_robot().expect("good");
    assert_eq!(Robot::parse(Path::new("again.toml"), &text).expect("good"), robot);
}

#[test]
fn every_key_of_every_table_is_needed() {
    let optional = ["track_sigma", "max_incidence_deg"];
    for rig in [WHEELED_RIG, SHARP_RIG, ODOMETRY_RIG] {
        for (i, line) in rig.lines().enumerate().filter(|(_, line)| line.contains(" = ")) {
            let key = line.split(" = ").next().expect("a key");
            let without: Vec<&str> = rig.lines().enumerate().filter(|(j, _)| *j != i).map(|(_, line)| line).collect();
            if !optional.contains(&key) {
                assert_error(&without.join("\n"), &["rig.toml:", key, "is missing"]);
            }
        }
    }
}

#[test]
fn impossible_numbers_name_key_and_what_is_allowed() {
    let cases = [
        ("track_m = 0.2", "track_m = 0", "rig.toml:2: wheels.track_m: is 0; it must be a number above 0"),
        ("track_m = 0.2", "track_m = -0.2", "rig.toml:2: wheels.track_m: is -0.2; it must be a number above 0"),
        ("track_m = 0.2", "track_m = nan", "rig.toml:2: wheels.track_m: is nan; it must be a number above 0"),
        ("track_m = 0.2", "track_m = inf", "rig.toml:2: wheels.track_m: is inf; it must be a number above 0"),
        ("track_m = 0.2", "track_m = 1e300", "rig.toml:2: wheels.track_m: is 1e300; it must be a number above 0"),
        ("track_m = 0.2", "track_m = 1e-60", "rig.toml:2: wheels.track_m: is 1e-60; it must be a number above 0"),
        ("track_m = 0.2", "track_m = 235", "rig.toml:2: wheels.track_m: is 235; it must be"),
        ("track_m = 0.2", "track_m = \"wide\"", "rig.toml:2: wheels.track_m: is a text; it must be a number above 0"),
        ("track_m = 0.2", "track_m = true", "rig.toml:2: wheels.track_m: is a true-or-false value"),
        (
            "scale_sigma = 0.005",
            "scale_sigma = -0.1",
            "wheels.scale_sigma: is -0.1; it must be a ratio of at least 0 and less than 0.5",
        ),
        (
            "noise_m2_per_m = 1e-5",
            "noise_m2_per_m = -1",
            "wheels.noise_m2_per_m: is -1; it must be a number, 0 or more",
        ),
        ("scale_sigma = 0.005", "scale_sigma = 0.5", "wheels.scale_sigma: is 0.5; it must be a ratio"),
        ("x_m = 0.0", "x_m = nan", "range_sensor[0].x_m: is nan; it must be a finite number"),
        ("x_m = 0.0", "x_m = 60", "range_sensor[0].x_m: is 60; it must be"),
        ("bearing_deg = 90.0", "bearing_deg = 900", "range_sensor[0].bearing_deg: is 900; it must be an angle"),
        ("min_m = 0.05", "min_m = -1", "range_sensor[0].min_m: is -1; it must be a number, 0 or more"),
        ("max_m = 2.0", "max_m = 0.04", "range_sensor[0].max_m: is 0.04; it must be above min_m"),
        ("max_m = 2.0", "max_m = 2.0\nmax_incidence_deg = 91", "range_sensor[0].max_incidence_deg: is 91"),
        ("gain_sigma = 0.01", "gain_sigma = -0.01", "range_sensor[0].gain_sigma: is -0.01; it must be a ratio"),
        ("noise_m = 0.01", "noise_m = -0.01", "range_sensor[0].noise_m: is -0.01; it must be a number, 0 or more"),
        ("noise_rel = 0.0\n", "noise_rel = -1\n", "range_sensor[1].noise_rel: is -1; it must be a number, 0 or more"),
    ];
    for (from, to, expected) in cases {
        let text = WHEELED_RIG.replacen(from, to, 1);
        assert_ne!(text, WHEELED_RIG);
        assert_error(&text, &[expected]);
    }
    let exact = WHEELED_RIG.replace("noise_m = 0.01\nnoise_rel = 0.0\n", "noise_m = 0\nnoise_rel = 0\n");
    assert_error(&exact, &["range_sensor[1].noise_m", "no sensor is exact"]);
}

#[test]
fn analogue_sensors_need_a_converter_and_possible_values() {
    let cases = [
        ("[adc]\nbits = 12\nvref_v = 3.3\n", "", "adc: is missing; left is an analogue sensor"),
        ("bits = 12", "bits = 0", "rig.toml:8: adc.bits: is 0; it must be a whole number from 1 to 16"),
        ("bits = 12", "bits = 17", "adc.bits: is 17"),
        ("bits = 12", "bits = 99999999999999999999", "adc.bits: is 1e20; it must be a whole number from 1 to 16"),
        ("bits = 12", "bits = 12.5", "adc.bits: is 12.5; it must be a whole number"),
        ("vref_v = 3.3", "vref_v = 0.0", "adc.vref_v: is 0.0; it must be a number above 0"),
        ("vref_v = 3.3", "vref_v = 3300", "rig.toml:9: adc.vref_v: is 3300; it must be a number from 0.1 to 50"),
        ("exponent = -1.16", "exponent = 1.16", "range_sensor[0].exponent: is 1.16; it must be"),
        ("exponent = -1.16", "exponent = -5", "range_sensor[0].exponent: is -5; it must be a number from -4"),
        ("exponent = -1.16", "exponent = 0", "range_sensor[0].exponent: is 0; it must be"),
        ("noise_v = 0.012", "noise_v = 0", "range_sensor[0].noise_v: is 0; it must be a number above 0"),
        ("noise_v = 0.012", "noise_v = 0.012\nnoise_m = 0.1", "range_sensor[0].noise_m: is there beside scale_m"),
        ("scale_m = 0.60374\nexponent = -1.16\nnoise_v = 0.012", "", "a sensor has scale_m, exponent and noise_v"),
    ];
    for (from, to, expected) in cases {
        let text = SHARP_RIG.replacen(from, to, 1);
        assert_ne!(text, SHARP_RIG);
        assert_error(&text, &[expected]);
    }
}

#[test]
fn unknown_keys_and_wrong_shapes_are_errors() {
    let cases = [
        ("track_m = 0.2", "track_m = 0.2\ntrack_cm = 20", "rig.toml:3: wheels.track_cm: is not known here"),
        ("[wheels]", "[wheel]", "rig.toml:1: wheel: is not known here; known are hand_overs, wheels, odometry, adc"),
        ("name = \"front\"", "name = \"left\"", "range_sensor[1].name: is \"left\" again"),
        ("name = \"front\"", "name = \"\"", "range_sensor[1].name: is \"\"; it must be a text"),
        ("name = \"front\"", "name = 7", "range_sensor[1].name: is 7; it must be a text"),
        ("name = \"front\"", "name = \"a,b\"", "range_sensor[1].name: holds a comma"),
        ("track_m = 0.2", "track_m = ", "rig.toml:2: is not valid TOML"),
    ];
    for (from, to, expected) in cases {
        assert_error(&WHEELED_RIG.replacen(from, to, 1), &[expected]);
    }
    assert_error(&format!("{ODOMETRY_RIG}\n[extra]\n"), &["extra: is not known here"]);
    assert_error(&format!("wheels = 4\n{ODOMETRY_RIG}"), &["rig.toml:1: wheels: must be a table, not a number"]);
    let (wheels, sensors) = WHEELED_RIG.split_once("\n[[").expect("sensors");
    assert_error(&format!("{ODOMETRY_RIG}\n{wheels}"), &["rig.toml:1: odometry: is there beside [wheels]"]);
    assert_error(WHEELED_RIG.trim_end_matches(&format!("[[{sensors}")), &["range_sensor", "there are 0"]);
    let many: String = (0..17)
        .map(|i| SHARP_RIG.split_once("[[").expect("sensor").1.replace("left", &format!("s{i}")))
        .map(|s| format!("[[{s}"))
        .collect();
    let head = SHARP_RIG.split_once("[[").expect("sensor").0;
    assert_error(&format!("{head}{many}"), &["there are 17; there must be 1 to 16"]);
    assert_error("", &["rig.toml:1: wheels: is missing"]);
}

#[test]
fn whatever_the_rig_file_allows_the_estimator_takes() {
    let limits = [
        ("min_m = 0.05", "min_m = 0"),
        ("max_m = 2.0", "max_m = 2.0\nmax_incidence_deg = 90"),
        ("gain_sigma = 0.01", "gain_sigma = 0.499999"),
        ("scale_sigma = 0.005", "scale_sigma = 0"),
        ("noise_m2_per_m = 1e-5", "noise_m2_per_m = 0"),
        ("bearing_deg = 90.0", "bearing_deg = -360"),
        ("bearing_deg = 90.0", "bearing_deg = 0x10"),
        ("track_m = 0.2", "track_m = 1_0.5e-1\ntrack_sigma = 0.4"),
    ];
    for (from, to) in limits {
        let text = WHEELED_RIG.replacen(from, to, 1);
        let robot = Robot::parse(Path::new("rig.toml"), &text).unwrap_or_else(|error| panic!("{error}"));
        assert!(lab::run::Session::new(&robot, slam_core::Config::default(), "limits").is_ok(), "{to}");
    }
}

#[test]
fn the_program_says_so_and_fails() {
    let place = Place::new();
    place.put("log.csv", crate::common::wheeled_log(5));
    place.put("rig.toml", WHEELED_RIG.replace("track_m = 0.2", "track_m = -1"));
    let failure = place.replay("log.csv").assert().failure();
    let stderr = String::from_utf8_lossy(&failure.get_output().stderr).into_owned();
    assert_eq!(stderr, "error: rig.toml:2: wheels.track_m: is -1; it must be a number above 0\n");
    assert!(!place.path("out").exists(), "nothing is written before the inputs are known to be good");
    place
        .lab()
        .args(["replay", "log.csv", "--rig", "none.toml", "--out", "out"])
        .assert()
        .failure()
        .stderr(predicates::str::contains("error: none.toml: cannot read"));
}
