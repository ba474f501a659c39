//! `lab replay` of `log.csv`: what is read, and what is said about what cannot be.

use std::io::Write;

use crate::common::{ODOMETRY_RIG, Place, SHARP_RIG, WHEELED_RIG, wheeled_log};
use flate2::write::GzEncoder;
use lab::input::rig_file::Robot;
use predicates::str::contains;
use slam_core::{Motion, RangeInput};

fn place_with(rig: &str, log: impl AsRef<[u8]>) -> Place {
    let place = Place::new();
    place.put("rig.toml", rig);
    place.put("log.csv", log);
    place
}

/// Every row, or the error that ends them.
fn rows_of(rig: &str, log: &str) -> (Vec<lab::input::log::Row>, Option<String>) {
    let place = place_with(rig, log);
    let mut robot = Robot::parse(&place.path("rig.toml"), rig).expect("good rig");
    let mut rows = Vec::new();
    for row in lab::input::log::open(&place.path("log.csv"), &mut robot).expect("good header") {
        match row {
            Ok(row) => rows.push(row),
            Err(error) => return (rows, Some(error.to_string())),
        }
    }
    (rows, None)
}

#[test]
fn wheel_drop_switches_are_read_where_there_are_any() {
    let log =
        |cell: &str| format!("t_s,left_ticks,right_ticks,range_0_m,range_1_m,lifted\n0,0,0,1,1,0\n1,0,0,1,1,{cell}\n");
    for (cell, expected) in [("0", false), ("1", true), ("", false), ("nan", false)] {
        let (rows, error) = rows_of(WHEELED_RIG, &log(cell));
        assert_eq!((rows.iter().map(|row| row.lifted).collect(), error), (vec![false, expected], None));
    }
    let error = rows_of(WHEELED_RIG, &log("2")).1.expect("an error");
    assert!(error.contains("log.csv:3: lifted: is \"2\"; it must be 0 on the floor or 1 off it"), "{error}");
}

#[test]
fn a_replay_writes_every_output() {
    let place = place_with(WHEELED_RIG, wheeled_log(100));
    place.replay("log.csv").assert().success().stdout(contains("100 rows"));
    let estimate = place.get("out/estimate.csv");
    let mut lines = estimate.lines();
    assert_eq!(
        lines.next(),
        Some("t_s,x_m,y_m,theta_rad,var_x,cov_xy,cov_xtheta,var_y,cov_ytheta,var_theta,alpha_rad,walls,located")
    );
    assert_eq!(lines.clone().count(), 100);
    assert!(lines.all(|line| line.split(',').count() == 13 && line.ends_with(",1")));
    let last: Vec<f64> =
        estimate.lines().last().expect("rows").split(',').map(|cell| cell.parse().expect("a number")).collect();
    assert!((last[1] - 99.0 * 0.025).abs() < 0.05, "{last:?}");
    assert_eq!(place.get("out/trajectory.tum").lines().count(), 100);
    assert!(place.get("out/trajectory.tum").lines().all(|line| line.split(' ').count() == 8));
    assert!(place.get("out/walls.csv").starts_with("kind,rho_m,beta_rad,lo_m,hi_m,sigma_rho_m\n"));
    let calibration = place.get("out/calibration.csv");
    for name in ["parameter,estimate,sigma", "gain_left,", "gain_front,1,0", "scale_left,", "scale_right,", "track,1,0"]
    {
        assert!(calibration.lines().any(|line| line.starts_with(name)), "{calibration}");
    }
    let summary = place.summary("out");
    assert_eq!(summary["rows"], 100);
    assert_eq!(summary["finished"], true);
    assert!((summary["duration_s"].as_f64().expect("a number") - 9.9).abs() < 1e-9);
    assert!((summary["path_m"].as_f64().expect("a number") - 2.475).abs() < 1e-3);
    assert!(summary.get("ate_m").is_none(), "there is no truth");
    assert!(!place.path("out/truth.tum").exists());
    assert!(place.get("out/report.html").contains("<html"));
}

#[test]
fn times_are_copied_as_they_are_written() {
    let log = "t_s,left_ticks,right_ticks,range_0_m,range_1_m\n 1e1 ,0,0,,\n10.10,5,5,nan,NaN\n+11,9,9,0.7,\n";
    let place = place_with(WHEELED_RIG, log);
    place.replay("log.csv").assert().success();
    let times = |file: &str, separator: char| -> Vec<String> {
        place.get(file).lines().map(|line| line.split(separator).next().expect("a cell").to_owned()).collect()
    };
    assert_eq!(times("out/estimate.csv", ',')[1..], ["1e1", "10.10", "+11"]);
    assert_eq!(times("out/trajectory.tum", ' '), ["1e1", "10.10", "+11"]);
}

#[test]
fn empty_and_nan_are_no_readings_and_every_line_ending_is_read() {
    let log = "\u{feff}t_s, left_ticks ,right_ticks,range_0_m,range_1_m\r\n0,1,2,0.5,\r\n\r\n1,3,4,nan,0.25\r\n";
    let (rows, error) = rows_of(WHEELED_RIG, log);
    assert_eq!(error, None);
    let ranges: Vec<_> = rows.iter().map(|row| [row.sample.ranges[0], row.sample.ranges[1]]).collect();
    use RangeInput::{Metres, Missing};
    assert_eq!(ranges, [[Metres(0.5), Missing], [Missing, Metres(0.25)]]);
    assert_eq!(rows.iter().map(|row| row.sample.time_us).collect::<Vec<_>>(), [0, 1_000_000]);
}

#[test]
fn columns_may_stand_in_any_order() {
    let (rows, error) = rows_of(SHARP_RIG, "adc_0,right_ticks,t_s,left_ticks\n4095,7,0.5,-3\n");
    assert_eq!(error, None);
    assert_eq!(rows[0].sample.ranges[0], RangeInput::Counts(4095));
    assert_eq!(rows[0].sample.motion, Motion::Ticks(slam_core::Ticks { left: -3, right: 7 }));
}

#[test]
fn counters_wider_than_32_bits_wrap() {
    let (rows, _) = rows_of(SHARP_RIG, "t_s,left_ticks,right_ticks,adc_0\n0,4294967295,-4294967297,\n");
    assert_eq!(rows[0].sample.motion, Motion::Ticks(slam_core::Ticks { left: -1, right: -1 }));
}

#[test]
fn the_first_odometry_pose_is_the_origin() {
    // Starts at (10, 20) facing +y; goes 0.5 m ahead, 0.2 m to the left and turns by 90 degrees across the seam.
    let log = "t_s,odom_x_m,odom_y_m,odom_theta_rad,range_0_m\n0,10,20,1.5707963267948966,\n\
               1,9.8,20.5,3.1415926535897931,\n2,9.8,20.5,-3.0415926535897931,\n";
    let place = place_with(ODOMETRY_RIG, log);
    place.replay("log.csv").assert().success();
    let pose = |row: usize| -> Vec<f64> {
        let text = place.get("out/estimate.csv");
        let line = text.lines().nth(row + 1).expect("a row");
        line.split(',').skip(1).take(3).map(|cell| cell.parse().expect("a number")).collect()
    };
    let near = |row: usize, expected: [f64; 3]| {
        let found = pose(row);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
    };
    near(0, [0.0, 0.0, 0.0]);
    near(1, [0.5, 0.2, std::f64::consts::FRAC_PI_2]);
    near(2, [0.5, 0.2, std::f64::consts::FRAC_PI_2 + 0.1]);
}

#[test]
fn truth_scores_the_estimate_and_never_moves_it() {
    let plain = wheeled_log(60);
    let mut with_truth = String::new();
    for (i, line) in plain.lines().enumerate() {
        let truth = format!("5.0,{},1.5707963267948966", 7.0 + 0.025 * (i as f64 - 1.0));
        with_truth += &if i == 0 {
            format!("{line},true_x_m,true_y_m,true_theta_rad\n")
        } else if i % 2 == 0 {
            format!("{line},,,\n")
        } else {
            format!("{line},{truth}\n")
        };
    }
    let (without, with) = (place_with(WHEELED_RIG, &plain), place_with(WHEELED_RIG, &with_truth));
    without.replay("log.csv").assert().success();
    with.replay("log.csv").assert().success().stdout(contains("dead reckoning"));
    assert_eq!(without.get("out/estimate.csv"), with.get("out/estimate.csv"));
    let summary = with.summary("out");
    assert_eq!(summary["poses_compared"], 30);
    for (key, bound) in [("ate_m", 0.05), ("start_m", 0.05), ("heading_deg", 2.0)] {
        let odometry = summary["odometry"][key].as_f64().expect("a number");
        assert!(odometry < 1e-4, "{key} {odometry}");
        let estimate = summary[key].as_f64().expect("a number");
        assert!(estimate < bound, "{key} {estimate}");
    }
    let truth = with.get("out/truth.tum");
    assert_eq!(truth.lines().count(), 30);
    assert!(truth.starts_with("0.0 0 0 0 0 0 0 1\n"), "{truth}");
}

#[test]
fn a_truth_file_is_found_beside_the_log_or_where_it_is_named() {
    let place = place_with(WHEELED_RIG, wheeled_log(20));
    let mut truth = String::from("t_s,x_m,y_m,theta_rad\n");
    for i in 0..20 {
        truth += &format!("{:.1},{},0,0\n", 0.1 * f64::from(i), 0.025 * f64::from(i));
    }
    place.put("elsewhere.csv", &truth);
    place.replay("log.csv").args(["--truth", "elsewhere.csv"]).assert().success();
    assert_eq!(place.summary("out")["poses_compared"], 20);
    place.replay("log.csv").assert().success();
    assert!(place.summary("out").get("poses_compared").is_none());
    assert!(!place.path("out/truth.tum").exists(), "results of the replay before are gone");
    place.put("truth.csv", &truth);
    place.replay("log.csv").assert().success();
    assert_eq!(place.summary("out")["poses_compared"], 20);
    place.put("truth.csv", truth.replace("0.5,", "zero,"));
    place.replay("log.csv").assert().failure().stderr(contains("truth.csv:7: t_s: is \"zero\""));
    for (from, to, expected) in [
        ("0.5,0.125,0,0", "0.5,0.125,0,0,0", "truth.csv:7: columns: there are 5; the header names 4"),
        ("x_m,y_m", "x_m,x_m,y_m", "truth.csv:1: x_m: is there twice"),
        ("t_s,x_m,y_m,theta_rad\n", "", "truth.csv:1: has no header"),
    ] {
        assert!(truth.contains(from), "{truth}");
        place.put("truth.csv", truth.replace(from, to));
        place.replay("log.csv").assert().failure().stderr(contains(expected));
    }
    place.replay("log.csv").args(["--truth", "none.csv"]).assert().failure().stderr(contains("none.csv: cannot read"));
}

#[test]
fn a_gzipped_log_is_the_same_log() {
    let place = place_with(WHEELED_RIG, wheeled_log(50));
    place.replay("log.csv").assert().success();
    let plain = place.get("out/estimate.csv");
    let mut gzip = GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(wheeled_log(50).as_bytes()).expect("in memory");
    place.put("packed", gzip.finish().expect("in memory"));
    place.replay("packed").assert().success();
    assert_eq!(place.get("out/estimate.csv"), plain);
}

#[test]
fn what_precedes_a_bad_line_is_processed_and_written() {
    let whole = wheeled_log(40);
    let place = place_with(WHEELED_RIG, &whole);
    place.replay("log.csv").assert().success();
    let good: Vec<String> = place.get("out/estimate.csv").lines().map(str::to_owned).collect();
    place.put("log.csv", whole.replace("\n2.5,725,", "\n2.5,seven,"));
    let expected = "error: log.csv:27: left_ticks: is \"seven\"; it must be a whole number of ticks";
    place.replay("log.csv").assert().failure().code(1).stderr(contains(expected));
    let kept: Vec<String> = place.get("out/estimate.csv").lines().map(str::to_owned).collect();
    assert_eq!(kept, good[..26]);
    assert_eq!(place.get("out/trajectory.tum").lines().count(), 25);
    let summary = place.summary("out");
    assert_eq!(summary["finished"], false);
    assert_eq!(summary["rows"], 25);
    assert!(summary["error"].as_str().is_some_and(|error| error.contains("log.csv:27")));
    assert!(place.path("out/walls.csv").exists() && place.path("out/report.html").exists());
}

#[test]
fn bad_cells_name_file_line_and_column() {
    let header = "t_s,left_ticks,right_ticks,adc_0\n0,0,0,500\n";
    let cases = [
        ("1,0,0", "log.csv:3: columns: there are 3; the header names 4"),
        ("1,0,0,5,5", "log.csv:3: columns: there are 5; the header names 4"),
        ("0,0,0,5", "log.csv:3: t_s: is 0; it must be above the row before"),
        ("-1,0,0,5", "log.csv:3: t_s: is -1; it must be above the row before"),
        ("nan,0,0,5", "log.csv:3: t_s: is \"nan\"; it must be a finite number"),
        (",0,0,5", "log.csv:3: t_s: is \"\"; it must be a finite number"),
        ("inf,0,0,5", "log.csv:3: t_s: is \"inf\"; it must be a finite number"),
        ("1e308,0,0,5", "log.csv:3: t_s: is \"1e308\"; it must be a finite number of seconds, from -1e10 to 1e10"),
        ("1,0.5,0,5", "log.csv:3: left_ticks: is \"0.5\"; it must be a whole number of ticks"),
        ("1,0,,5", "log.csv:3: right_ticks: is \"\"; it must be a whole number of ticks"),
        ("1,0,0,-5", "log.csv:3: adc_0: is \"-5\"; it must be a whole number of converter counts"),
        ("1,0,0,70000", "log.csv:3: adc_0: is \"70000\"; it must be a whole number of converter counts"),
        ("1,0,0,1.5", "log.csv:3: adc_0: is \"1.5\"; it must be a whole number of converter counts"),
    ];
    for (line, expected) in cases {
        let (rows, error) = rows_of(SHARP_RIG, &format!("{header}{line}\n2,0,0,5\n"));
        assert_eq!(rows.len(), 1, "{line}");
        let error = error.unwrap_or_else(|| panic!("accepted {line}"));
        assert!(error.contains(expected), "{error} does not say {expected}");
    }
    let log = "t_s,odom_x_m,odom_y_m,odom_theta_rad,range_0_m,true_x_m,true_y_m,true_theta_rad\n";
    let cases = [
        ("0,1,nan,0,0.5,,,", "log.csv:2: odom_y_m: is \"nan\"; it must be a finite number"),
        ("0,1,1,0,far,,,", "log.csv:2: range_0_m: is \"far\"; it must be a number of metres"),
        ("0,1,1,0,0.5,1,,0", "log.csv:2: true_y_m: is \"\"; it must be a finite number"),
    ];
    for (line, expected) in cases {
        let (_, error) = rows_of(ODOMETRY_RIG, &format!("{log}{line}\n"));
        assert!(error.as_ref().is_some_and(|error| error.contains(expected)), "{error:?} {expected}");
    }
}

#[test]
fn headers_that_do_not_fit_the_robot_say_which_column() {
    let cases = [
        (WHEELED_RIG, "t_s,left_ticks,range_0_m,range_1_m", "log.csv:1: right_ticks: is missing from the header"),
        (WHEELED_RIG, "t_s;left_ticks;right_ticks", "its columns are separated by ';'; they must be by commas"),
        (WHEELED_RIG, "t_s left_ticks right_ticks", "its columns are separated by ' '; they must be by commas"),
        (WHEELED_RIG, "\"t_s\",\"left_ticks\"", "it has \"t_s\", which must be written t_s"),
        (
            WHEELED_RIG,
            "T_S,left_ticks,right_ticks",
            "t_s: is missing from the header; it has T_S, which must be written t_s",
        ),
        (WHEELED_RIG, "time,left_ticks,right_ticks,range_0_m,range_1_m", "log.csv:1: t_s: is missing"),
        (WHEELED_RIG, "t_s,left_ticks,right_ticks,range_0_m", "log.csv:1: range_1_m: is missing"),
        (WHEELED_RIG, "t_s,left_ticks,right_ticks,adc_0,adc_1", "log.csv:1: range_0_m: is missing"),
        (SHARP_RIG, "t_s,left_ticks,right_ticks,range_0_m", "log.csv:1: adc_0: is missing"),
        (SHARP_RIG, "t_s,left_ticks,right_ticks,adc_0,adc_1", "log.csv:1: adc_1: has no place"),
        (SHARP_RIG, "t_s,left_ticks,right_ticks,adc_0,t_s", "log.csv:1: t_s: is there twice"),
        (SHARP_RIG, "0.0,0,0,511", "log.csv:1: has no header; its first line must name the columns"),
        (
            SHARP_RIG,
            "t_s,left_ticks,right_ticks,adc_0\r0.0,0,0,511\r0.1,0,0,511\r",
            "log.csv:1: its lines end with CR alone",
        ),
        (SHARP_RIG, "t_s,left_ticks,right_ticks,adc_0,true_x_m", "log.csv:1: true_y_m: is missing"),
        (ODOMETRY_RIG, "t_s,left_ticks,right_ticks,range_0_m", "log.csv:1: odom_x_m: is missing"),
    ];
    for (rig, header, expected) in cases {
        let place = place_with(rig, format!("{header}\n"));
        place.replay("log.csv").assert().failure().code(1).stderr(contains(expected));
    }
}

#[test]
fn unknown_columns_are_passed_over_with_a_note() {
    let place = place_with(SHARP_RIG, "t_s,left_ticks,right_ticks,battery_v,adc_0\n0,0,0,7.4,500\n");
    place.replay("log.csv").assert().success().stderr(contains("battery_v"));
}

#[test]
fn files_that_are_no_logs_are_refused() {
    let cases: [(&[u8], &str); 4] = [
        (b"", "log.csv: is empty"),
        (b"t_s,left_ticks,right_ticks,adc_0\n", "log.csv: has a header but no rows"),
        (b"t_s,left_ticks,right_ticks,adc_0\n0,0,0,5\n1,\xff\xfe,0,5\n", "log.csv:3: is not text"),
        (b"\x1f\x8b\x08\x00 broken", "cannot read"),
    ];
    for (content, expected) in cases {
        let place = place_with(SHARP_RIG, content);
        place.replay("log.csv").assert().failure().stderr(contains(expected));
    }
    let place = place_with(SHARP_RIG, "");
    place.replay("none.csv").assert().failure().stderr(contains("none.csv: cannot read"));
}

#[test]
fn a_line_without_an_end_is_an_error_that_takes_no_memory() {
    let header = "t_s,left_ticks,right_ticks,adc_0\n0,0,0,500\n";
    let (rows, error) = rows_of(SHARP_RIG, &format!("{header}{}", "1".repeat(3 << 20)));
    assert_eq!(rows.len(), 1);
    let error = error.expect("no sample has a line of three million digits");
    assert!(error.contains("log.csv:3: is longer than 1048576 bytes; a log has one sample a line"), "{error}");
}

#[test]
fn an_estimator_that_ends_unwell_is_a_failure() {
    let mut log = String::from("t_s,left_ticks,right_ticks,range_0_m,range_1_m\n");
    for i in 0..1000_u64 {
        // Multiples of the golden ratio: no two readings in a row are of one surface.
        let range_m = 0.2 + 1.6 * (i as f64 * 0.618_034).fract();
        log += &format!("{:.1},{},{},{range_m:.3},\n", i as f64 * 0.1, 25 * i, 25 * i);
    }
    let place = place_with(WHEELED_RIG, log);
    place.replay("log.csv").assert().code(1).stderr(contains("the estimator is not well (unexplained)"));
    let summary = place.summary("out");
    assert_eq!(summary["finished"], true);
    assert_eq!(summary["health"]["at_end"], "unexplained");
    assert!(summary["health"]["unwell"][0]["begin_s"].as_f64().is_some_and(|begin_s| begin_s > 79.0), "{summary:#}");
    place.put("log.csv", wheeled_log(1000));
    place.replay("log.csv").assert().success();
    assert_eq!(place.summary("out")["health"], serde_json::json!({"at_end": "well", "unwell": []}));
}
