//! `lab replay` of CARMEN logs.

use std::io::Write;

use crate::common::{ODOMETRY_RIG, Place, WHEELED_RIG};
use flate2::write::GzEncoder;
use lab::input::rig_file::Robot;
use predicates::str::contains;
use slam_core::{Motion, RangeInput};

/// A scan of `n` beams, beam i reading 1 + i / 100 metres, at an odometry pose.
fn scan(n: usize, odometry: [f64; 3], time: &str) -> String {
    let ranges: String = (0..n).map(|i| format!(" {:.2}", 1.0 + i as f64 / 100.0)).collect();
    let [x, y, theta] = odometry;
    // The first pose is some corrected one, which must not be used.
    format!("FLASER {n}{ranges} 90 91 0.5 {x} {y} {theta} 77.7 robot {time}\n")
}

fn log() -> String {
    let mut text = String::from("# a comment\nPARAM robot_width 0.5\n");
    for i in 0..30 {
        let t = f64::from(i) * 0.2;
        text += &format!("ODOM {} 0 0 0 0 0 {t} robot {t}\n", 0.05 * f64::from(i));
        text += &scan(180, [3.0 + 0.05 * f64::from(i), -2.0, 0.0], &format!("{:.2}", t + 0.1));
    }
    text
}

fn rows(place: &Place, rig: &str, log: &str) -> Result<Vec<lab::input::log::Row>, String> {
    let log = place.put("carmen.log", log);
    let mut robot = Robot::parse(&place.path("rig.toml"), rig).expect("good rig");
    lab::input::log::open(&log, &mut robot)
        .map_err(|error| error.to_string())?
        .map(|row| row.map_err(|error| error.to_string()))
        .collect()
}

fn rig_with_bearing(bearing_deg: f64) -> String {
    ODOMETRY_RIG.replace("bearing_deg = 90.0", &format!("bearing_deg = {bearing_deg}"))
}

#[test]
fn plain_and_gzipped_logs_give_the_same_estimate() {
    let place = Place::new();
    place.put("rig.toml", ODOMETRY_RIG);
    place.put("plain.log", log());
    place.replay("plain.log").assert().success().stdout(contains("30 rows"));
    let plain = place.get("out/estimate.csv");
    assert!(plain.lines().nth(1).is_some_and(|line| line.starts_with("0.10,0,0,0,")), "{plain}");
    assert!(plain.lines().last().is_some_and(|line| line.starts_with("5.90,")));
    let mut gzip = GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(log().as_bytes()).expect("in memory");
    let packed = gzip.finish().expect("in memory");
    place.put("packed.log.gz", &packed);
    place.replay("packed.log.gz").assert().success();
    assert_eq!(place.get("out/estimate.csv"), plain);
    place.put("torn.log.gz", &packed[..packed.len() - 20]);
    place.replay("torn.log.gz").assert().failure().stderr(contains("cannot read on"));
}

#[test]
fn sensors_pick_the_nearest_beam() {
    let place = Place::new();
    // 180 beams: one degree apart from -90. 360 beams: half a degree.
    for (bearing_deg, beams, beam) in [
        (-90.0, 180, 0),
        (0.0, 180, 90),
        (0.4, 180, 90),
        (0.6, 180, 91),
        (90.0, 180, 179),
        (0.4, 360, 181),
        (270.0, 180, 0),
    ] {
        let rows = rows(&place, &rig_with_bearing(bearing_deg), &scan(beams, [0.0; 3], "1")).expect("a good log");
        let expected = 1.0 + beam as f32 / 100.0;
        let RangeInput::Metres(found) = rows[0].sample.ranges[0] else { panic!("no range") };
        assert!((found - expected).abs() < 1e-6, "{bearing_deg} of {beams}: {found} {expected}");
    }
}

#[test]
fn the_estimator_gets_the_beams_own_bearing() {
    let place = Place::new();
    let log = place.put("carmen.log", scan(180, [0.0; 3], "1"));
    let mut robot = Robot::parse(&place.path("rig.toml"), &rig_with_bearing(30.3)).expect("good rig");
    lab::input::log::open(&log, &mut robot).expect("a good log");
    assert!((robot.rig.sensors[0].mount.bearing_rad.to_degrees() - 30.0).abs() < 1e-4);
}

#[test]
fn motion_is_that_of_the_second_pose() {
    let place = Place::new();
    let text = scan(4, [1.0, 1.0, std::f64::consts::FRAC_PI_2], "1") + &scan(4, [0.9, 1.3, 2.0], "2");
    let rows = rows(&place, &rig_with_bearing(0.0), &text).expect("a good log");
    let Motion::Increment(step) = rows[1].sample.motion else { panic!("no increment") };
    assert!((step.forward_m - 0.3).abs() < 1e-6 && (step.left_m - 0.1).abs() < 1e-6, "{step:?}");
    assert!((step.turn_rad - (2.0 - std::f32::consts::FRAC_PI_2)).abs() < 1e-6, "{step:?}");
    assert_eq!(rows[1].sample.time_us, 1_000_000);
}

#[test]
fn scans_out_of_order_are_passed_over_with_a_note() {
    let place = Place::new();
    place.put("rig.toml", ODOMETRY_RIG);
    let scans = ["1", "2", "1.5", "2", "3"].map(|time| scan(180, [0.0; 3], time));
    place.put("carmen.log", scans.concat());
    place.replay("carmen.log").assert().success().stderr(contains("passed over 2 scans")).stdout(contains("3 rows"));
}

#[test]
fn bad_scans_name_line_and_field() {
    let place = Place::new();
    let good = scan(4, [0.0; 3], "1");
    let cases = [
        ("FLASER 4 1 2 3", "carmen.log:2: fields: there are 5; a FLASER of 4 beams has 15"),
        ("FLASER x 1 2 3", "carmen.log:2: number of beams: is \"x\""),
        ("FLASER 0 1 1 1 1 1 1 1 r 2", "carmen.log:2: number of beams"),
        ("FLASER 4 1 2 near 4 0 0 0 0 0 0 1 r 2", "carmen.log:2: range 2: is \"near\""),
        ("FLASER 4 1 2 3 4 0 0 0 0 y 0 1 r 2", "carmen.log:2: odometry y: is \"y\""),
        ("FLASER 4 1 2 3 4 0 0 0 0 0 0 1 r late", "carmen.log:2: logger timestamp: is \"late\""),
    ];
    for (line, expected) in cases {
        let error = rows(&place, &rig_with_bearing(40.0), &format!("{good}{line}\n"));
        let error = error.err().unwrap_or_else(|| panic!("accepted {line}"));
        assert!(error.contains(expected), "{error} does not say {expected}");
    }
}

#[test]
fn rigs_that_no_carmen_log_fits_are_refused() {
    let place = Place::new();
    let error = rows(&place, WHEELED_RIG, &log()).expect_err("ticks");
    assert!(error.contains("the rig file must have [odometry]"), "{error}");
    let error = rows(&place, &rig_with_bearing(120.0), &log()).expect_err("behind");
    assert!(error.contains("range sensor left: points at 120.0 degrees"), "{error}");
    let error = rows(&place, ODOMETRY_RIG, "ODOM 0 0 0 0 0 0 1 r 1\n").expect_err("no scan");
    assert!(error.contains("has no FLASER message"), "{error}");
}
