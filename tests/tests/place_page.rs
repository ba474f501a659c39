//! The report page of a robot that lost its place, and of one that takes look backs over.

use std::path::Path;

use lab::recording::{HandOver, Pose2, Recording, Searched};
use serde_json::{Value, json};
use slam_core::{Health, NotTaken};
use tests::report::open;
use tests::sample_recording::sample_recording;

fn opened(name: &str, recording: &Recording, probe: &str) -> Option<Value> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("place-page").join(name);
    open(&folder, recording, "theme=light", probe)
}

/// Whether each column of the time line's marks has something of a colour of the style sheet.
const MARKS: &str = r##"
    const marked = (name) => {
        const probe = document.body.appendChild(document.createElement("i"));
        probe.style.color = `var(--${name})`;
        const wanted = getComputedStyle(probe).color.match(/\d+/g).slice(0, 3).map(Number);
        const canvas = document.querySelector("#births");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const columns = new Set();
        for (let i = 0; i < data.length; i += 4) {
            if (data[i + 3] && wanted.every((value, k) => Math.abs(value - data[i + k]) < 4)) columns.add((i / 4) % canvas.width);
        }
        return [...columns].map((column) => column / canvas.width);
    };
    const rows = (table) => [...document.querySelectorAll(`${table} tbody tr`)].map((row) => row.innerText.replace(/\s+/g, " ").trim());
"##;

#[test]
fn a_robot_that_was_lost_shows_when_and_with_what_odds_it_was_found() {
    let mut recording = sample_recording(40.0, 10.0);
    for step in &mut recording.steps[100..200] {
        (step.searching, step.truth) = (true, None);
        step.pose = Pose2::new(3.0, -2.0, 1.0).compose(&step.pose);
    }
    recording.figures.lost = recording.lost();
    for step in &mut recording.steps[20..30] {
        step.health = Health::Contradicted;
    }
    recording.counters.jolts = 2;
    let search = |step, log_odds| Searched { step, log_odds, against_places: log_odds, walls: [6, 4] };
    recording.searches = vec![search(150, -2.0), search(199, 9.3)];
    let probe = format!(
        r##"{MARKS}
        const lost = marked("apart");
        return {{
            hidden: document.querySelector("#place-section").hidden,
            overs: document.querySelector("#hand-overs-section").hidden,
            lost: [Math.min(...lost), Math.max(...lost)],
            note: document.querySelector("#place-note").textContent,
            rows: rows("#searches"),
            legend: [...document.querySelectorAll("#time-legend li")].map((mark) => mark.textContent),
            verdict: document.querySelector("#verdict").textContent,
            known: document.querySelector("[data-figure='place'] .value").textContent,
            health: document.querySelector("[data-figure='health']").innerText.replace(/\s+/g, " "),
            sensors: rows("#sensor-counts").length,
            readout: document.querySelector("[data-chart='odds'] .readout").textContent,
        }};"##
    );
    let Some(seen) = opened("lost", &recording, &probe) else { return };
    assert_eq!((&seen["hidden"], &seen["overs"]), (&json!(false), &json!(true)));
    let [from, to] = [0, 1].map(|end| seen["lost"][end].as_f64().unwrap());
    assert!((from - 0.25).abs() < 0.02 && (to - 0.5).abs() < 0.02, "{seen:#}");
    assert_eq!(seen["legend"], json!(["A wall was born", "Estimator not well", "Place not known"]));
    let verdict = seen["verdict"].as_str().unwrap();
    assert!(verdict.contains("For 24.9\u{a0}% of the time it did not know its place"), "{verdict}");
    assert_eq!(seen["known"], "75.1\u{a0}%");
    let health = seen["health"].as_str().unwrap();
    assert!(health.contains("contradicted from 0:02.0 to 0:03.0. Jolts that readings undid: 2"), "{health}");
    assert_eq!(seen["sensors"], recording.sensors.len());
    let note = seen["note"].as_str().unwrap();
    assert!(
        note.contains("For 10.0\u{a0}s") && note.contains("again from 0:20.0 on") && note.contains("2 searches"),
        "{note}"
    );
    assert_eq!(seen["rows"], json!(["0:15.0 6 4 10⁻⁰·⁹", "0:19.9 6 4 10⁴·⁰"]));
    assert!(seen["readout"].as_str().unwrap().ends_with("Odds 10⁴·⁰"), "{seen:#}");
}

#[test]
fn a_hand_over_shows_the_map_before_and_after() {
    let mut recording = sample_recording(40.0, 10.0);
    let moved = Pose2::new(0.03, 0.04, 0.01);
    recording.hand_overs = vec![
        HandOver { step: 200, refused: None, moved },
        HandOver { step: 300, refused: Some(NotTaken::LessSure), moved: Pose2::default() },
    ];
    for map in recording.maps.iter_mut().filter(|map| map.step >= 200) {
        map.walls.iter_mut().for_each(|wall| wall.rho_m += 0.1);
    }
    let probe = format!(
        r##"{MARKS}
        const map = document.querySelector("#map");
        const picture = async () => {{ await settle(); return map.toDataURL(); }};
        const seen = {{ hidden: document.querySelector("#hand-overs-section").hidden, rows: rows("#hand-overs"), bars: marked("estimate") }};
        const [before, after] = document.querySelectorAll("#hand-overs .choices button");
        after.click();
        const beside = await picture();
        seen.clock = document.querySelector("#clock").textContent;
        document.querySelector("#hand-overs button.link").click();
        seen.same = beside === await picture();
        before.click();
        seen.changed = beside !== await picture();
        seen.clockBefore = document.querySelector("#clock").textContent;
        return seen;"##
    );
    let Some(seen) = opened("hand-overs", &recording, &probe) else { return };
    assert_eq!(seen["hidden"], false);
    assert_eq!(seen["rows"], json!(["0:20.0 taken over 5.0 cm 0.57° BeforeAfter", "0:30.0 refused: less sure – –"]));
    let bars: Vec<f64> = seen["bars"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert!(
        bars.iter().any(|at| (at - 0.5).abs() < 0.02) && bars.iter().any(|at| (at - 0.75).abs() < 0.02),
        "{bars:?}"
    );
    assert!(bars.iter().all(|at| (at - 0.5).abs() < 0.02 || (at - 0.75).abs() < 0.02), "{bars:?}");
    assert_eq!((&seen["same"], &seen["changed"]), (&json!(false), &json!(true)), "the map before is not drawn beside");
    assert_eq!((&seen["clock"], &seen["clockBefore"]), (&json!("0:20.0 / 0:40.0"), &json!("0:19.9 / 0:40.0")));
}
