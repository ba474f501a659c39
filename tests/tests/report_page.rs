//! The report page as a user meets it: opened in a browser, without a network.

use lab::recording::{Job, Recording};
use serde_json::{Value, json};
use slam_core::{Outcome, ReadingReport};
use std::path::{Path, PathBuf};
use tests::browser::Browser;
use tests::report::assert_sound;
use tests::sample_recording::{cleaned, sample_recording};

fn open(name: &str, recording: &Recording, hash: &str, probe: &str) -> Option<Value> {
    tests::report::open(&folder(name), recording, hash, probe)
}

/// A folder of its own for each page and its browser profile.
fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-page").join(name)
}

/// Figures, chart titles and what else a reader sees at first.
const LOOK_AROUND: &str = r##"
    const text = (node) => node.textContent.replace(/\s+/g, " ").trim();
    const all = (selector) => [...document.querySelectorAll(selector)];
    const painted = (canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const colours = new Set();
        for (let i = 0; i < data.length; i += 4) if (data[i + 3]) colours.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
        return colours.size;
    };
    return {
        title: text(document.querySelector("h1")),
        verdict: text(document.querySelector("#verdict")),
        figures: Object.fromEntries(all("[data-figure]").map((card) => [card.dataset.figure, text(card.querySelector(".value"))])),
        charts: all("[data-chart]").map((chart) => chart.dataset.chart),
        unpainted: all("[data-chart] canvas").filter((canvas) => painted(canvas) < 3).length,
        mapColours: painted(document.querySelector("#map")),
        sensors: all("#trace tbody th").map(text),
        walls: all("#walls tbody tr").length,
        layers: all("[data-layer]").map((box) => box.dataset.layer),
        clock: text(document.querySelector("#clock")),
        fetched: performance.getEntriesByType("resource").length,
        unnamed: all("button, input, canvas, select").filter((node) =>
            !(node.getAttribute("aria-label") || node.getAttribute("aria-hidden") || node.closest("label") || text(node))).length,
        wide: document.documentElement.scrollWidth - innerWidth,
        nan: /NaN|undefined|null|Infinity/.test(document.querySelector("main").innerText),
    };
"##;

#[test]
fn a_run_with_truth_shows_its_figures_map_and_charts() {
    let Some(seen) = open("full", &sample_recording(60.0, 10.0), "", LOOK_AROUND) else { return };
    assert_eq!(seen["title"], "Sample room");
    let verdict = seen["verdict"].as_str().unwrap();
    assert!(verdict.contains("0.8 cm") && verdict.contains("26 times closer than dead reckoning"), "{verdict}");
    for (figure, value) in
        [("ate", "0.8 cm"), ("start", "1.1 cm"), ("heading", "0.31°"), ("nees", "3.40"), ("nis", "1.04")]
    {
        assert_eq!(seen["figures"][figure], value, "{figure}");
    }
    assert_eq!(seen["figures"]["path"], "15.00 m");
    assert!(verdict.starts_with("15.00 m in 1 min 0 s"), "{verdict}");
    let charts = ["distance", "heading", "error-x", "error-y", "nees", "nis", "walls", "alpha"];
    let calibration = ["gain_front", "gain_left", "scale_left", "scale_right"].map(|p| format!("calibration-{p}"));
    let expected: Vec<&str> = charts.into_iter().chain(calibration.iter().map(String::as_str)).collect();
    assert_eq!(seen["charts"], json!(expected));
    assert_eq!(seen["unpainted"], 0);
    assert!(seen["mapColours"].as_u64().unwrap() > 10, "{}", seen["mapColours"]);
    assert_eq!(seen["sensors"].as_array().unwrap().len(), 8);
    assert_eq!(seen["walls"], seen["figures"]["walls"].as_str().unwrap().parse::<u32>().unwrap());
    assert_eq!(seen["layers"], json!(["plan", "walls", "hits", "estimate", "truth", "odometry", "robot"]));
    assert_eq!(seen["clock"], "1:00.0 / 1:00.0");
    assert_eq!((&seen["fetched"], &seen["unnamed"]), (&json!(0), &json!(0)));
    assert!(seen["wide"].as_i64().unwrap() <= 0, "the page scrolls sideways");
    assert_eq!(seen["nan"], false);
}

#[test]
fn the_moment_follows_slider_keys_address_and_playback() {
    let probe = r##"
        const clock = () => document.querySelector("#clock").textContent.split(" ")[0];
        const slider = document.querySelector("#time");
        const seen = { address: clock(), wallsThen: document.querySelector("#pose").innerText.match(/Walls\s+(\d+)/)[1] };
        slider.value = "100";
        slider.dispatchEvent(new Event("input"));
        seen.slider = clock();
        seen.front = document.querySelector("#trace tbody tr").innerText.replace(/\s+/g, " ");
        document.querySelector("#step-on").click();
        seen.stepped = clock();
        document.body.dispatchEvent(new KeyboardEvent("keydown", { key: ",", bubbles: true }));
        seen.key = clock();
        document.querySelector("[data-speed='60']").click();
        document.querySelector("#play").click();
        seen.label = document.querySelector("#play").textContent;
        await until(() => clock() === "1:00.0");
        seen.played = clock();
        seen.labelAfter = document.querySelector("#play").textContent;
        return seen;
    "##;
    let Some(seen) = open("moments", &sample_recording(60.0, 10.0), "t=3.25", probe) else { return };
    assert_eq!(seen["address"], "0:03.2");
    assert_eq!(seen["slider"], "0:10.0");
    assert!(seen["front"].as_str().unwrap().starts_with("front "), "{}", seen["front"]);
    assert_eq!((&seen["stepped"], &seen["key"]), (&json!("0:10.1"), &json!("0:10.0")));
    assert_eq!((&seen["label"], &seen["labelAfter"]), (&json!("Pause"), &json!("Play")));
    assert_eq!(seen["played"], "1:00.0");
}

#[test]
fn toggles_colourings_and_themes_change_the_picture() {
    let probe = r##"
        const map = document.querySelector("#map");
        const picture = async () => { await settle(); return map.toDataURL(); };
        const pictures = [await picture()];
        const click = async (selector) => { document.querySelector(selector).click(); pictures.push(await picture()); };
        await click("[data-layer='odometry']");
        await click("[data-layer='hits']");
        await click("[data-layer='hits']");
        await click("[data-colouring='pass']");
        const passes = document.querySelectorAll("[data-class]").length;
        await click("[data-class='0']");
        await click("[data-colouring='time']");
        await click("[data-colouring='sensor']");
        const sensors = document.querySelectorAll("[data-class]").length;
        await click("[data-placing='odometry']");
        await click("[data-placing='estimate']");
        await click("[data-comparison='fit']");
        await click("#zoom-in");
        await click("#walls button");
        await click("[data-theme-choice='dark']");
        const dark = getComputedStyle(document.body).backgroundColor;
        await click("[data-theme-choice='light']");
        const light = getComputedStyle(document.body).backgroundColor;
        return { same: pictures.map((p, i) => i > 0 && p === pictures[i - 1]).filter(Boolean).length,
            back: pictures[1] === pictures[3], passes, sensors, dark, light };
    "##;
    let Some(seen) = open("toggles", &sample_recording(120.0, 10.0), "theme=light", probe) else { return };
    assert_eq!(seen["same"], 0, "a control changed nothing on the map");
    assert_eq!(seen["back"], true, "hits switched off and on again are not the same picture");
    assert!(seen["passes"].as_u64().unwrap() >= 2, "the second lap is a second pass: {}", seen["passes"]);
    assert_eq!(seen["sensors"], 8);
    assert_ne!(seen["dark"], seen["light"]);
}

#[test]
fn pointing_at_map_and_charts_tells_what_is_there() {
    let probe = r##"
        const point = (node, type, x, y) => {
            const box = node.getBoundingClientRect();
            node.dispatchEvent(new PointerEvent(type, { bubbles: true, pointerId: 1, clientX: box.x + x, clientY: box.y + y }));
        };
        const chart = document.querySelector("[data-chart='distance']");
        const canvas = chart.querySelector("canvas");
        const readout = () => chart.querySelector(".readout").textContent;
        const before = readout();
        // Half of the plotting area, between the margins of 52 and 12 pixels.
        point(canvas, "pointermove", 52 + (canvas.clientWidth - 64) / 2, 50);
        const hovered = readout();
        point(canvas, "pointerleave", 0, 0);
        const after = readout();
        const map = document.querySelector("#map");
        const tip = document.querySelector("#map-tip");
        const tips = new Set();
        for (let x = 4; x < map.clientWidth; x += 4) {
            point(map, "pointermove", x, map.clientHeight / 2);
            if (!tip.hidden) tips.add(tip.textContent);
        }
        return { before, hovered, after, tips: [...tips] };
    "##;
    let Some(seen) = open("pointing", &sample_recording(60.0, 10.0), "", probe) else { return };
    assert!(seen["hovered"].as_str().unwrap().starts_with("0:30.0 · Estimate 0.8\u{a0}cm"), "{}", seen["hovered"]);
    assert_ne!(seen["before"], seen["hovered"]);
    assert_eq!(seen["before"], seen["after"]);
    let tips: Vec<&str> = seen["tips"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(tips.iter().any(|tip| tip.starts_with("Wall ")), "{tips:?}");
    assert!(tips.iter().any(|tip| tip.contains(": used, wall ") && tip.contains("pass 1")), "{tips:?}");
}

#[test]
fn a_run_without_truth_plan_or_calibration_says_what_it_can() {
    let mut recording = sample_recording(90.0, 5.0);
    recording.true_walls.clear();
    recording.parameters.clear();
    recording.calibration.clear();
    recording.figures.estimate = None;
    recording.figures.odometry = None;
    recording.figures.map = None;
    recording.seed = None;
    recording.steps.iter_mut().for_each(|step| step.truth = None);
    let Some(seen) = open("no-truth", &recording, "", LOOK_AROUND) else { return };
    assert_eq!(seen["charts"], json!(["distance", "sigma", "nis", "walls", "alpha"]));
    assert_eq!(seen["layers"], json!(["walls", "hits", "estimate", "odometry", "robot"]));
    assert!(seen["verdict"].as_str().unwrap().contains("The true path is not known"), "{}", seen["verdict"]);
    assert!(seen["figures"].get("ate").is_none() && seen["figures"].get("visits").is_some(), "{}", seen["figures"]);
    assert_eq!(seen["nan"], false);
}

#[test]
fn a_map_without_a_plan_opens_by_passes_and_marks_the_walls_that_they_place_apart() {
    let mut recording = sample_recording(120.0, 10.0);
    recording.true_walls.clear();
    let walls = recording.figures.consistency.as_mut().map(|score| &mut score.walls).expect("it was scored");
    for wall in walls.iter_mut() {
        (wall.visits, wall.gap_m) = (vec![Default::default(); 2], Some(0.1));
    }
    walls[0].gap_m = Some(0.4);
    let probe = r##"
        const map = document.querySelector("#map");
        const pressed = (choice) => document.querySelector(`[data-colouring='${choice}']`).getAttribute("aria-pressed");
        await settle();
        const seen = { pass: pressed("pass"), odometry: document.querySelector("[data-layer='odometry']").checked };
        const marked = map.toDataURL();
        document.querySelector("[data-layer='apart']").click();
        await settle();
        seen.same = marked === map.toDataURL();
        return seen;
    "##;
    let Some(seen) = open("apart", &recording, "theme=light", probe) else { return };
    assert_eq!((&seen["pass"], &seen["odometry"]), (&json!("true"), &json!(false)));
    assert_eq!(seen["same"], false, "the wall is not marked");
}

#[test]
fn a_truth_slower_than_the_log_still_makes_lines() {
    let mut recording = sample_recording(30.0, 10.0);
    for (i, step) in recording.steps.iter_mut().enumerate() {
        step.truth = step.truth.filter(|_| i % 7 == 0);
    }
    let probe = r##"
        const chart = document.querySelector("[data-chart='error-x']");
        const canvas = chart.querySelector("canvas");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const columns = new Set();
        // The error's line is the only thing of this strong blue.
        for (let i = 0; i < data.length; i += 4) {
            if (data[i] < 60 && data[i + 2] > 150 && data[i + 3] > 200) columns.add((i / 4) % canvas.width);
        }
        return { covered: columns.size / canvas.width, readout: chart.querySelector(".readout").textContent };
    "##;
    let Some(seen) = open("sparse", &recording, "theme=light", probe) else { return };
    assert!(seen["covered"].as_f64().unwrap() > 0.8, "{}", seen["covered"]);
    assert!(seen["readout"].as_str().unwrap().ends_with("cm"), "{}", seen["readout"]);
}

#[test]
fn a_robot_that_explored_shows_no_floor() {
    let recording = Recording { job: Some(Job::Explore), ..cleaned() };
    let Some(seen) = open("no-floor", &recording, "", LOOK_AROUND) else { return };
    assert!(!seen["charts"].as_array().unwrap().contains(&json!("floor-swept")), "{}", seen["charts"]);
}

#[test]
fn odd_recordings_still_make_a_page() {
    let sample = sample_recording(10.0, 10.0);
    let mut broken = sample.clone();
    for step in &mut broken.steps[20..40] {
        step.pose.x_m = f64::NAN;
        step.covariance = [[f32::NAN; 3]; 3];
        step.dead_reckoning.theta_rad = f64::INFINITY;
        step.truth = None;
    }
    for reading in broken.readings.iter_mut().step_by(3) {
        let outcome = Outcome::Updated { wall: 900, innovation_m: f32::NAN, variance_m2: 0.0, noise_m2: 0.0 };
        *reading = ReadingReport { outcome, range_m: Some(f32::NAN), hit_m: Some([f32::INFINITY, 0.0]) };
    }
    broken.figures.mean_nis = Some(f64::NAN);
    let blind = Recording { sensors: Vec::new(), readings: Vec::new(), maps: Vec::new(), ..sample.clone() };
    let mut unswept = cleaned();
    unswept.figures.floor = Some(Default::default());
    let single = Recording { steps: sample.steps[..1].to_vec(), maps: Vec::new(), ..sample.clone() };
    let empty = Recording::default();
    for (name, recording) in
        [("empty", empty), ("broken", broken), ("blind", blind), ("single", single), ("unswept", unswept)]
    {
        let Some(seen) = open(name, &recording, "t=2&colour=pass", LOOK_AROUND) else { return };
        assert_eq!(seen["nan"], false, "{name}");
        assert_eq!(seen["unpainted"], 0, "{name}");
    }
}

#[test]
fn a_phone_shows_all_of_it_without_scrolling_sideways() {
    let Some(mut browser) = Browser::find() else { return };
    browser.width_px = 500;
    let page = lab::show::report::html(&cleaned());
    let visit = browser.visit(&folder("phone"), &page, "", LOOK_AROUND);
    assert_sound(&visit);
    assert!(visit.answer["wide"].as_i64().unwrap() <= 0, "{} pixels too wide", visit.answer["wide"]);
    assert_eq!(visit.answer["unpainted"], 0);
}

#[test]
fn the_check_notices_a_broken_page() {
    let Some(browser) = Browser::find() else { return };
    let page = lab::show::report::html(&sample_recording(5.0, 5.0));
    let thrown =
        browser.visit(&folder("thrown"), &page.replace("start();", "start(); noSuchFunction();"), "", "return 1;");
    assert_eq!((thrown.errors, thrown.console.len()), (Some(1), 1));
    let unfinished = browser.visit(&folder("unfinished"), &page.replace("\"t\":[", "\"t\":[x"), "", "return 1;");
    assert!(!unfinished.ready && unfinished.errors == Some(1));
    let fetching =
        browser.visit(&folder("fetching"), &page, "", "await fetch('https://example.org/').catch(() => {});");
    assert_eq!(fetching.errors, Some(1), "a fetch is a fault");
}

#[test]
fn ten_minutes_of_eight_sensors_fit_into_three_megabytes() {
    let page = lab::show::report::html(&sample_recording(600.0, 25.0));
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    let hour = lab::show::report::html(&sample_recording(3600.0, 25.0));
    assert!(hour.len() < 6_000_000, "{} bytes", hour.len());
}
