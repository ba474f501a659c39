//! Options that both commands share.

use crate::common::Place;
use predicates::str::contains;

#[test]
fn estimator_variants_are_used_and_written_down() {
    let place = Place::new();
    place.lab().args(["--plan", "room", "--minutes", "1", "--out", "sim"]).assert().success();
    let variants: [(&[&str], &str); 6] = [
        (&[], "grid"),
        (&["--walls", "free"], "free"),
        (&["--walls", "snapped"], "snapped"),
        (&["--walls", "snapped-moving"], "snapped, theta moves"),
        (&["--no-calibration"], "grid"),
        (&["--without", "scales", "--without", "track"], "grid"),
    ];
    let mut estimates = Vec::new();
    for (arguments, walls) in variants {
        let mut command = place.lab();
        command.args(["replay", "sim/log.csv", "--rig", "sim/rig.toml", "--out", "out"]).args(arguments);
        command.assert().success();
        let estimator = place.summary("out")["configuration"]["estimator"].clone();
        assert_eq!(estimator["walls"], walls);
        assert_eq!(estimator["calibrate_gains"], !arguments.contains(&"--no-calibration"));
        estimates.push(place.get("out/estimate.csv"));
    }
    assert_eq!(estimates[0], place.get("sim/estimate.csv"));
    for (i, one) in estimates.iter().enumerate() {
        assert!(estimates[..i].iter().all(|other| other != one), "variant {i} changes nothing");
    }
    let calibration = place.get("out/calibration.csv");
    let is_exact = |line: &str| line.ends_with(",1,0");
    assert!(calibration.lines().skip(1).all(|line| is_exact(line) != line.starts_with("gain_")), "{calibration}");
    assert_eq!(place.summary("out")["configuration"]["estimator"]["without"], serde_json::json!(["scales", "track"]));
    // Of a robot whose sensors report metres, the parts that one with analogue sensors has not are parts, too.
    let of_metres =
        ["--rig", "time-of-flight", "--minutes", "0.1", "--out", "tof", "--without", "latency", "--without", "levels"];
    place.lab().args(of_metres).assert().success();
    assert_eq!(place.summary("tof")["configuration"]["estimator"]["without"], serde_json::json!(["latency", "levels"]));
    place.lab().args(["--without", "luck"]).assert().failure().stderr(contains("it must be one of grid, gains"));
    place.lab().args(["--walls", "curved"]).assert().failure().stderr(contains("snapped-moving"));
}

#[test]
fn a_trace_accounts_for_every_reading() {
    let place = Place::new();
    place.lab().args(["--plan", "room", "--minutes", "0.5", "--out", "out", "--trace"]).assert().success();
    let trace = place.get("out/readings.csv");
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("t_s,sensor,outcome,wall,range_m,hit_x_m,hit_y_m,innovation_m,variance_m2,nis"));
    let outcomes: Vec<&str> = lines.map(|line| line.split(',').nth(2).expect("an outcome")).collect();
    let log = place.get("out/log.csv");
    let readings =
        log.lines().skip(1).map(|line| line.split(',').skip(3).take(8).filter(|cell| !cell.is_empty()).count());
    assert_eq!(outcomes.len(), readings.sum::<usize>());
    let summary = place.summary("out");
    let count = |name: &str| outcomes.iter().filter(|outcome| **outcome == name).count() as u64;
    assert_eq!(count("updated"), summary["updates"].as_u64().expect("a count"));
    assert_eq!(count("too_far"), summary["counters"]["refused"]["too_far"].as_u64().expect("a count"));
    // Without the option there is none, not even that of the run before.
    place.lab().args(["--plan", "room", "--minutes", "0.1", "--out", "out"]).assert().success();
    assert!(!place.path("out/readings.csv").exists());
}

#[test]
fn maps_are_scored_without_a_truth() {
    let place = Place::new();
    place.lab().args(["--plan", "room", "--minutes", "4", "--out", "sim"]).assert().success();
    let log = place.get("sim/log.csv");
    let without: Vec<String> = log.lines().map(|line| line.rsplitn(4, ',').last().expect("cells").to_owned()).collect();
    place.put("log.csv", without.join("\n"));
    place.lab().args(["replay", "log.csv", "--rig", "sim/rig.toml", "--out", "out"]).assert().success();
    let summary = place.summary("out");
    assert!(summary.get("ate_m").is_none());
    let score = &summary["consistency"];
    let number = |key: &str| score[key].as_f64().unwrap_or_else(|| panic!("{key}: {score}"));
    assert!(number("entropy_nats") < number("odometry_entropy_nats"), "{score}");
    assert!(number("revisited_walls") >= 4.0 && number("widest_gap_m") < 0.1, "{score}");
    assert!(number("closure_m") < number("odometry_closure_m") && number("thickness_m") < 0.05, "{score}");
    let wall = &score["walls"][0];
    assert!(wall["gap_m"].is_number() && wall["visits"][1]["mean_m"].is_number(), "{wall}");
    let median = |key: &str| score[key]["median_m"].as_f64().unwrap_or_else(|| panic!("{key}: {score}"));
    assert!(median("surfels") < 0.03 && median("surfels") < median("odometry_surfels"), "{score}");
    let shares = summary["readings"]["shares"].as_object().expect("shares");
    let parts = ["used", "outside_gate", "unexplained", "refused"].map(|name| shares[name].as_f64().expect("a share"));
    assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-9 && parts[3] > 0.0, "{shares:?}");
    let reasons: f64 = shares.iter().skip(4).filter_map(|(_, share)| share.as_f64()).sum();
    assert!((reasons - parts[3]).abs() < 1e-9, "{shares:?}");
    assert!(summary["nis_before_gate"].as_f64() > summary["mean_nis"].as_f64(), "{summary}");
    assert!(summary["nis_associated"].as_f64().is_some_and(|nis| (0.3..1.3).contains(&nis)), "{summary}");
    assert!(summary["median_nis_before_gate"].as_f64().is_some_and(|median| (0.1..0.6).contains(&median)), "{summary}");
}
