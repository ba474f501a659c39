//! `lab compare` as a user calls it.

use crate::common::Place;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::{Value, json};

/// A summary as a replay writes it, with what the tests are about.
fn summary(place: &Place, folder: &str, change: impl Fn(&mut Value)) {
    let mut value = json!({
        "program": "wall-slam lab",
        "version": "1.0.0",
        "finished": true,
        "title": "somewhere/log.csv",
        "rows": 100,
        "path_m": 10.0,
        "duration_s": 20.0,
        "ate_m": 0.2,
        "mean_nis": 0.5,
        "walls": 4,
        "lost": 0.0,
        "floor": { "swept": 0.9, "time_s": { "lanes": 250.0 } },
        "consistency": { "entropy_nats": -1.5, "odometry_entropy_nats": -1.0, "widest_gap_m": null },
        "readings": { "all": 200, "shares": { "used": 0.6, "outside_gate": 0.2, "too_far": 0.1 } },
        "counters": { "refused": { "too_far": 20 }, "births": 5 },
        "configuration": { "estimator": { "gate": 10.83 }, "rig_toml": "" },
    });
    change(&mut value);
    place.put(&format!("{folder}/summary.json"), value.to_string());
}

fn compare(place: &Place) -> Vec<Value> {
    let output = place.lab().args(["compare", "a", "b", "--json"]).output().expect("it runs");
    assert!(output.status.success(), "{output:?}");
    let comparison: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(comparison["a"]["folder"], "a");
    comparison["scores"].as_array().expect("scores").clone()
}

fn score<'a>(scores: &'a [Value], key: &str) -> &'a Value {
    scores.iter().find(|score| score["key"] == key).unwrap_or_else(|| panic!("no {key} in {scores:?}"))
}

#[test]
fn each_score_says_which_is_better_where_that_has_a_meaning() {
    let place = Place::new();
    summary(&place, "a", |_| ());
    summary(&place, "b", |value| {
        value["ate_m"] = json!(0.1);
        // Twice the ideal is as far off as half of it; a little more is farther.
        value["mean_nis"] = json!(2.1);
        value["consistency"]["entropy_nats"] = json!(-1.2);
        value["readings"]["shares"]["used"] = json!(0.8);
        value["readings"]["shares"]["floor"] = json!(0.05);
        value["counters"]["births"] = json!(9);
        value["lost"] = json!(0.25);
        value["floor"]["swept"] = json!(0.95);
        value["floor"]["time_s"]["lanes"] = json!(200.0);
    });
    let scores = compare(&place);
    let better = |key: &str| score(&scores, key)["better"].as_str();
    assert_eq!(better("/ate_m"), Some("b"));
    assert_eq!(better("/mean_nis"), Some("a"));
    assert_eq!(better("/consistency/entropy_nats"), Some("a"));
    assert_eq!(better("/readings/shares/used"), Some("b"));
    assert_eq!((better("/walls"), better("/counters/births")), (None, None));
    assert_eq!((better("/lost"), better("/floor/swept"), better("/floor/time_s/lanes")), (Some("a"), Some("b"), None));
    let difference = score(&scores, "/ate_m")["difference"].as_f64().expect("a number");
    assert!((difference + 0.1).abs() < 1e-12);
    let below = score(&scores, "/consistency/odometry_entropy_nats - /consistency/entropy_nats");
    assert_eq!((&below["a"], &below["better"]), (&json!(0.5), &json!("a")));
    // One side has it, the other does not.
    let floor = score(&scores, "/readings/shares/floor");
    assert_eq!((&floor["a"], &floor["b"], &floor["better"]), (&json!(null), &json!(0.05), &json!(null)));
    assert!(!scores.iter().any(|score| score["key"] == "/consistency/widest_gap_m"), "neither has it");
}

#[test]
fn the_table_is_for_people() {
    let place = Place::new();
    summary(&place, "a", |_| ());
    summary(&place, "b", |value| {
        value["ate_m"] = json!(0.1);
        value["configuration"]["estimator"]["gate"] = json!(6.63);
    });
    let table = place.lab().args(["compare", "a", "b"]).assert().success();
    let line = predicate::str::is_match(r"position, best alignment \(RMSE\) +0\.200 m +0\.100 m +-0\.100 m  B\n");
    table
        .stdout(line.expect("a pattern"))
        .stdout(contains("setting gate: 10.83 in A, 6.63 in B"))
        .stdout(contains("outside the gate").and(contains("25.0 %")))
        .stdout(contains("warning").not());
}

#[test]
fn what_cannot_be_compared_fairly_is_said() {
    let place = Place::new();
    summary(&place, "a", |_| ());
    summary(&place, "b", |value| {
        value["title"] = json!("elsewhere/log.csv");
        value["path_m"] = json!(10.5);
        value["lost"] = json!(0.25);
        value["finished"] = json!(false);
        value["error"] = json!("log.csv:7: t_s: is missing");
        value["configuration"]["rig_toml"] = json!("[wheels]");
    });
    place
        .lab()
        .args(["compare", "a", "b"])
        .assert()
        .success()
        .stdout(contains(
            "warning: different logs: somewhere/log.csv (10.0 m, 20 s) and elsewhere/log.csv (10.5 m, 20 s)",
        ))
        .stdout(contains(
            "warning: scores against the truth are of other rows: A claims no place in 0.0 %, B in 25.0 %",
        ))
        .stdout(contains("warning: B ended early: log.csv:7: t_s: is missing"))
        .stdout(contains("warning: the rig files differ"));
}

#[test]
fn what_is_no_result_is_an_error_that_says_so() {
    let place = Place::new();
    summary(&place, "a", |_| ());
    let fails = |b: &str, parts: &[&str]| {
        let assert = place.lab().args(["compare", "a", b]).assert().failure().stdout("");
        let error = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(parts.iter().all(|part| error.contains(part)), "{parts:?} not all in {error}");
    };
    fails("b", &["b: is not there", "lab replay"]);
    place.put("file", "");
    fails("file", &["file: is not a folder"]);
    place.put("b/other.txt", "");
    fails("b", &["b: holds no summary.json"]);
    place.put("b/summary.json", "{\n\"rows\": }");
    fails("b", &["b/summary.json:2", "is not JSON"]);
    place.put("b/summary.json", "{ \"program\": \"another\" }");
    fails("b", &["b/summary.json: program", "wall-slam lab"]);
    place.put("b/summary.json", "{ \"program\": \"wall-slam lab\", \"finished\": false }");
    fails("b", &["b/summary.json: rows: is missing"]);
}

#[test]
fn a_run_and_its_replay_are_the_same() {
    let place = Place::new();
    place.lab().args(["run", "--plan", "room", "--minutes", "1", "--out", "a"]).assert().success();
    place.lab().args(["replay", "a/log.csv", "--rig", "a/rig.toml", "--out", "b"]).assert().success();
    let scores = compare(&place);
    assert!(scores.len() > 30, "{}", scores.len());
    for score in scores.iter().filter(|score| !["/estimator_s"].contains(&score["key"].as_str().expect("a key"))) {
        // The plan's own walls and floor are known to the run only.
        let of_plan = score["key"].as_str().is_some_and(|key| key.starts_with("/map/") || key.starts_with("/floor/"));
        assert!(of_plan || score["difference"] == 0.0, "{score}");
    }
    place.lab().args(["compare", "a", "b"]).assert().success().stdout(contains("different logs").not());
}
