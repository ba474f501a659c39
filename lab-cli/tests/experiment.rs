//! `lab experiment` as a user would call it.

use crate::common::Place;
use predicates::prelude::PredicateBooleanExt as _;
use predicates::str::contains;

const SMALL: &str = r#"
title = "Small"
plans = ["room"]
seeds = 2
variants = ["dead reckoning", "grid, calibrated", "floor"]
series = ["grid, calibrated"]
[setting]
minutes = 0.5
[[case]]
name = "fine"
[[case]]
name = "coarse"
gain_sigma = 0.04
[[bar]]
case = "coarse"
metric = "ate_m"
at_most = 1.0
"#;

/// The rows without the column that holds this machine's times, in order.
fn rows(place: &Place, folder: &str) -> Vec<String> {
    let text = place.get(&format!("{folder}/runs.csv"));
    let mut rows: Vec<String> =
        text.lines().map(|line| line.rsplit_once(',').expect("a row has cells").0.to_owned()).collect();
    rows.sort();
    rows
}

#[test]
fn writes_tables_figures_and_page() {
    let place = Place::new();
    place.put("small.toml", SMALL);
    let done = place.lab().args(["experiment", "small.toml", "--out", "out"]).assert().success();
    done.stdout(contains("grid, calibrated").and(contains("| yes |")));
    assert_eq!(rows(&place, "out").len(), 1 + 2 * 2 * 3);
    assert_eq!(place.get("out/table.csv").lines().count(), 1 + 2 * 3);
    assert!(place.get("out/table.md").contains("at most 1"));
    let page = place.get("out/index.html");
    for shown in ["fine-accuracy", "room-coarse-nees-over-time", "room-fine-grid-calibrated-errors"] {
        let svg = place.get(&format!("out/figures/{shown}.svg"));
        assert!(svg.starts_with("<svg") && page.contains(svg.trim_end()), "{shown}");
    }
}

#[test]
fn parts_make_the_whole_and_nothing_is_done_twice() {
    let place = Place::new();
    place.put("small.toml", SMALL);
    place.lab().args(["experiment", "small.toml", "--out", "whole", "--jobs", "1"]).assert().success();
    for part in ["1/2", "2/2"] {
        let out = format!("part{}", &part[..1]);
        place.lab().args(["experiment", "small.toml", "--shard", part, "--out", &out]).assert().success();
    }
    let missing = place.lab().args(["experiment", "merge", "--out", "both", "part1"]).assert().failure();
    missing.stderr(contains("both: lacks 6 runs, the first of plan room, case coarse, seed 1, variant dead reckoning"));
    place.lab().args(["experiment", "merge", "--out", "both", "part1", "part2"]).assert().success();
    let drawn = "figures/room-coarse-grid-calibrated-errors.svg";
    assert_eq!(place.get(&format!("both/{drawn}")), place.get(&format!("whole/{drawn}")));
    assert!(place.get("both/index.html").contains(place.get(&format!("both/{drawn}")).trim_end()));
    assert_eq!(rows(&place, "both"), rows(&place, "whole"));
    assert_ne!(rows(&place, "part1"), rows(&place, "whole"));
    // What is merged is only read.
    std::fs::create_dir(place.path("nothing")).expect("a folder");
    let merge = |part: &str| place.lab().args(["experiment", "merge", "--out", "more", "part1", part]).assert();
    merge("nothing").failure().stderr(contains("nothing/experiment.toml: cannot read"));
    assert!(!place.path("nothing/experiment.toml").exists() && !place.path("more").exists());
    merge("gone").failure().stderr(contains("gone: is no folder; name the folders that --shard wrote"));
    let before = place.get("whole/runs.csv");
    // Stopped while a row was being written: that one is done again, and only that one.
    place.put("whole/runs.csv", &before[..before.len() - 10]);
    place.lab().args(["experiment", "small.toml", "--out", "whole"]).assert().success();
    let after = place.get("whole/runs.csv");
    assert_eq!(rows(&place, "both"), rows(&place, "whole"));
    assert_eq!(before.lines().take(12).collect::<Vec<_>>(), after.lines().take(12).collect::<Vec<_>>());
}

#[test]
fn other_rows_are_not_mixed_in() {
    let place = Place::new();
    place.put("small.toml", SMALL);
    place.put("other.toml", SMALL.replace("seeds = 2", "seeds = 1"));
    place.lab().args(["experiment", "other.toml", "--out", "out"]).assert().success();
    let refused = place.lab().args(["experiment", "small.toml", "--out", "out"]).assert().failure();
    refused.stderr(contains("out: holds rows of another experiment"));
}

#[test]
fn files_that_no_experiment_wrote_stay_as_they_are() {
    let place = Place::new();
    place.put("small.toml", SMALL);
    for (name, content) in [
        ("runs.csv", &b"name,laps\nmine,3"[..]),
        ("samples.csv", b"t,x\n0,1"),
        ("index.html", b"my page"),
        ("table.csv", b"a,b"),
        ("table.md", b"|a|"),
        ("experiment.toml", b"\xff\xfe"),
        ("build.txt", b"\xe9t\xe9"),
    ] {
        let folder = place.path("mine");
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join(name), content).expect("a file");
        let refused = place.lab().args(["experiment", "small.toml", "--out", "mine"]).assert().failure();
        refused.stderr(contains(format!("mine/{name}:")));
        assert_eq!(std::fs::read(folder.join(name)).expect("the file"), content, "{name}");
        std::fs::remove_dir_all(folder).expect("the folder goes");
    }
}

#[test]
fn rows_of_another_rig_or_plan_file_are_not_mixed_in() {
    let place = Place::new();
    let room = include_str!("../../hal-sim/plans/room.toml");
    place.put("home.toml", room);
    place.put("small.toml", SMALL.replace("[\"room\"]", "[\"home.toml\"]").replace("seeds = 2", "seeds = 1"));
    let run = ["experiment", "small.toml", "--out", "out"];
    place.lab().args(run).assert().success();
    place.lab().args(run).assert().success();
    place.put("home.toml", format!("# Another one.\n{room}"));
    place.lab().args(run).assert().failure().stderr(contains("or of other rig or plan files"));
}

#[test]
fn mistakes_are_named_with_file_line_and_key() {
    let place = Place::new();
    for (from, to, expected) in [
        ("seeds = 2", "seeds = 0", "bad.toml:4: seeds: is 0; it must be a whole number from 1"),
        ("[\"room\"]", "[\"palace\"]", "bad.toml:3: plans: plan \"palace\""),
        ("\"floor\"]", "\"ceiling\"]", "bad.toml:5: variants: has \"ceiling\"; known are"),
        ("gain_sigma = 0.04", "gain_sigma = 0.7", "bad.toml:13: case[1].gain_sigma: is 0.7; it must be"),
        ("gain_sigma = 0.04", "gain = 0.04", "bad.toml:13: case[1].gain: is not known here"),
        ("name = \"coarse\"", "name = \"fine\"", "case: has \"fine\" twice"),
        (
            "minutes = 0.5",
            "minutes = 0.5\nname = \"all\"",
            "bad.toml:9: setting.name: is not known here; known are rig",
        ),
        (
            "minutes = 0.5",
            "minutes = 0.5\n[setting.draw]\nage_ms = [10]",
            "bad.toml:10: setting.draw.age_ms: must be the least and the most: two milliseconds",
        ),
        (
            "minutes = 0.5",
            "minutes = 0.5\n[[sweep]]\nkey = \"rate_hz\"\nvalues = [25, 1000]",
            "bad.toml:11: sweep[0].values[1]: is 1000; it must be a rate from 1 to 100",
        ),
        ("at_most = 1.0", "", "bar[0].at_most: one limit is needed"),
        ("at_most = 1.0", "in_band = 3", "bar[0].statistic: must be \"mean\" with in_band"),
        ("at_most = 1.0", "at_most = 1.0\nplans = [\"flat\"]", "bar[0].plans: has \"flat\""),
        (
            "[[bar]]",
            "[[variant]]\nname = \"wide\"\ngate = 200\n[[bar]]",
            "bad.toml:16: variant[0].gate: is 200; it must be a squared innovation of 1 to 100",
        ),
        ("minutes = 0.5", "minutes = 0.5\nsensors = 5", "bad.toml:9: setting.sensors: is 5; it must be 8, 6, 4 or 2"),
        (
            "minutes = 0.5",
            "minutes = 0.5\n[setting.draw]\nsensors = [4, 8]",
            "bad.toml:10: setting.draw.sensors: cannot be drawn: there are 8, 6, 4 or 2",
        ),
        (
            "minutes = 0.5",
            "minutes = 0.5\nage_ms = 10\n[setting.draw]\nage_ms = [10, 20]",
            "setting: has age_ms both set and drawn",
        ),
        (
            "minutes = 0.5",
            "minutes = 0.5\n[[sweep]]\nkey = \"rate_hz\"\nvalues = [25]\nrate_hz = 10",
            "bad.toml:10: sweep[0].key: is \"rate_hz\", which the table also sets or draws",
        ),
        (
            "[[bar]]",
            "[[variant]]\nname = \"rays\"\nrays = 8\n[[bar]]",
            "bad.toml:16: variant[0].rays: is there without senses = \"laser\"",
        ),
        ("metric = \"ate_m\"", "metric = \"ate\"", "bar[0].metric: is not known; known are path_m"),
    ] {
        place.put("bad.toml", SMALL.replacen(from, to, 1));
        place.lab().args(["experiment", "bad.toml"]).assert().failure().stderr(contains(expected));
    }
    place.lab().args(["experiment", "none.toml"]).assert().failure().stderr(contains("none.toml: cannot read"));
    place.lab().args(["experiment", "bad.toml", "--shard", "3/2"]).assert().failure().stderr(contains("k from 1 to n"));
}

#[test]
fn a_sensor_is_fitted() {
    let place = Place::new();
    let row = |i: u32| {
        let range_m = 0.2 + 0.005 * f64::from(i % 200);
        let volts = (range_m / 0.6).powf(1.0 / -1.2) + if i.is_multiple_of(2) { 0.01 } else { -0.01 };
        format!("{},{range_m},{volts}\n", 0.05 * f64::from(i))
    };
    place.put("log.csv", (0..2000).map(row).fold("time,range,out\n".to_owned(), |text, row| text + &row));
    let fit = ["experiment", "sensor", "log.csv", "--out", "out", "--volts"];
    let done = place.lab().args(fit).arg("out").assert().success();
    done.stdout(contains("0.6000 m x volts^-1.200"));
    assert!(place.get("out/figures/sensor-curve.svg").starts_with("<svg"));
    let good = place.get("log.csv");
    let of = |log: String| {
        place.put("log.csv", log);
        place.lab().args(fit).arg("out").assert()
    };
    // As a spreadsheet writes it, with two lines that say nothing.
    of(format!("\u{feff}{good}200,nan,1\n200.05,0.5,-1\n")).success().stdout(contains("| left out | 2 lines"));
    of(format!("{good}200,0.5\n")).failure().stderr(contains("log.csv:2002: columns: there are 2; the header names 3"));
    let table = place.get("out/sensor.md");
    place.put("out/sensor.md", "my notes");
    of(good).failure().stderr(contains("out/sensor.md: is no table of this command"));
    assert_eq!(place.get("out/sensor.md"), "my notes");
    place.put("out/sensor.md", table);
    let refused = place.lab().args(fit).arg("raw").assert().failure();
    refused.stderr(contains("log.csv:1: raw: is not in the header; there are time, range, out"));
}
