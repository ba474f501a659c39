//! The section of the report page that shows what was swept of the floor.

use std::path::Path;

use serde_json::{Value, json};
use tests::report::open;
use tests::sample_recording::cleaned;

/// Figures and picture of the floor now; colours of the picture as the style sheet names them.
const LOOK_AT_FLOOR: &str = r##"
    const canvas = document.querySelector("#floor");
    const rgb = (name) => {
        const probe = document.body.appendChild(document.createElement("i"));
        probe.style.color = `var(--${name})`;
        return getComputedStyle(probe).color.match(/\d+/g).slice(0, 3).join();
    };
    const shares = async () => {
        await settle();
        const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
        copy.getContext("2d").drawImage(canvas, 0, 0);
        const { data } = copy.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const counts = {};
        for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255) {
            const key = [data[i], data[i + 1], data[i + 2]].join();
            counts[key] = (counts[key] ?? 0) + 1;
        }
        const [once, twice, toCome, missed] = ["swept", "twice", "to-come", "missed"].map((name) => counts[rgb(name)] ?? 0);
        const all = once + twice + toCome + missed;
        return { once: once / all, twice: twice / all, toCome: toCome / all, missed: missed / all };
    };
    const slider = document.querySelector("#time");
    const seen = { hidden: document.querySelector("#floor-section").hidden };
    seen.end = await shares();
    slider.value = "200";
    slider.dispatchEvent(new Event("input"));
    seen.middle = await shares();
    seen.figures = Object.fromEntries([...document.querySelectorAll("#floor-figures [data-figure]")]
        .map((card) => [card.dataset.figure, card.querySelector(".value").textContent]));
    seen.doing = [...document.querySelectorAll("[data-doing]")].map((item) => item.textContent);
    seen.bar = [...document.querySelectorAll(".time-bar span")].map((part) => part.getBoundingClientRect().width);
    seen.readout = document.querySelector("[data-chart='floor-swept'] .readout").textContent;
    return seen;
"##;

#[test]
fn a_robot_that_swept_shows_its_floor_and_how_it_came_about() {
    let recording = cleaned();
    let floor = recording.figures.floor.clone().unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("floor-page");
    for theme in ["light", "dark"] {
        let Some(seen) = open(&folder.join(theme), &recording, &format!("theme={theme}"), LOOK_AT_FLOOR) else {
            return;
        };
        let share = |when: &str, what: &str| seen[when][what].as_f64().unwrap();
        // The robot, the plan's lines and the ring hide a little.
        let is_near = |seen: f64, expected: f64| (seen - expected).abs() < 0.06;
        assert!(is_near(share("end", "missed"), 1.0 - floor.swept), "{seen:#}");
        assert!(is_near(share("end", "twice"), floor.twice), "{seen:#}");
        assert_eq!(share("end", "toCome"), 0.0, "{seen:#}");
        let at_20_s = floor.progress.iter().find(|at| at.t_s >= 20.0).unwrap();
        assert!(is_near(share("middle", "once"), at_20_s.swept) && share("middle", "twice") < 0.01, "{seen:#}");
        assert!(share("middle", "toCome") > 0.003, "{seen:#}");
        assert_eq!(seen["figures"]["swept"], format!("{:.1}\u{a0}%", 100.0 * floor.swept));
        assert_eq!(seen["figures"]["bumps"], format!("{:.2}", 1.0 / floor.floor_m2));
        assert_eq!(seen["doing"], json!(["lanes 24.0\u{a0}s (60 %)", "docking 16.0\u{a0}s (40 %)"]));
        let widths: Vec<f64> = seen["bar"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
        assert!((widths[0] / widths[1] - 1.5).abs() < 0.02, "{widths:?}");
        assert!(seen["readout"].as_str().unwrap().starts_with("0:20.0 · Swept "), "{}", seen["readout"]);
    }
}
