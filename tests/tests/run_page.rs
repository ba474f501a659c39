//! The report page of a real run, as the program makes it.

use std::path::Path;

use lab::recording::Recording;
use tests::browser::Browser;
use tests::real_logs::HALLWAYS;
use tests::simulated::drive;

const PROBE: &str = r##"
    return {
        title: document.querySelector("h1").textContent,
        nan: /NaN|undefined|null|Infinity/.test(document.querySelector("main").innerText),
    };
"##;

fn assert_opens(name: &str, recording: &Recording) {
    let Some(browser) = Browser::find() else { return };
    let profile = Path::new(env!("CARGO_TARGET_TMPDIR")).join("run-page").join(name);
    let visit = browser.visit(&profile, &lab::show::report::html(recording), "", PROBE);
    assert!(visit.ready && visit.errors == Some(0) && visit.console.is_empty(), "{name}: {:#?}", visit.console);
    assert_eq!(visit.answer["title"].as_str().map(str::trim), Some(recording.title.as_str()));
    assert_eq!(visit.answer["nan"], false, "{name}");
}

#[test]
fn of_a_simulated_drive() {
    assert_opens("flat", &drive("flat", 2.0, 1));
}

#[test]
fn of_a_robot_that_has_just_started() {
    assert_opens("start", &drive("room", 0.001, 1));
}

#[test]
#[ignore = "needs the logs of real robots: cargo xtask test real-logs"]
fn of_a_real_log() {
    assert_opens(HALLWAYS.name, &HALLWAYS.replay().recording);
}
