//! Replay: a log and a rig file of the user's.

use std::path::PathBuf;

use lab::input::built_in_robot;
use lab::input::settings::{Settings, by_default};
use lab::run::{Replay, Run};
use serde_json::json;

use super::{assert_sound, open, picture, scratch};

/// A short simulated run's folder.
fn a_run(name: &str) -> PathBuf {
    let out = scratch(name).join("run");
    let config = by_default(&built_in_robot().expect("the built-in robot").0);
    let run = Run {
        plan: "flat".into(),
        job: lab::run::Job::Explore,
        minutes: 1.0,
        seed: 5,
        rig: None,
        out: out.clone(),
        map: None,
        start: None,
        settings: Settings::Exactly(config),
        trace: false,
    };
    run.run(|_| {}).expect("it runs");
    out
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_log_replays_to_the_bits_of_the_program_and_a_bad_one_is_named() {
    let Some((mut page, address)) = open("replay", "", [1280, 900]) else { return };
    let run = a_run("replay-files");
    let out = scratch("replay-files").join("replayed");
    let replay = Replay {
        log: run.join("log.csv"),
        rig: run.join("rig.toml"),
        out: out.clone(),
        truth: None,
        map: None,
        settings: Settings::Exactly(by_default(&built_in_robot().expect("the built-in robot").0)),
        trace: false,
    };
    replay.run(|_| {}).expect("it replays");
    page.run("document.querySelector(\"[data-mode-choice='replay']\").click();");
    page.choose_files("#files", &[run.join("log.csv"), run.join("rig.toml")]);
    page.until("document.getElementById('status').textContent.startsWith('1\u{202f}501 rows.')");
    let verdict = page.run("return document.getElementById('verdict').textContent;");
    assert!(verdict.as_str().unwrap().contains("closer than dead reckoning"), "{verdict}");
    page.run("document.getElementById('save-estimate').click();");
    let saved = page.run("return await window.saved.text();");
    let expected = std::fs::read_to_string(out.join("estimate.csv")).expect("it was written");
    assert!(saved == json!(expected), "the page's estimate is not that of lab replay");
    page.run("await new Promise((done) => setTimeout(done, 500));");
    picture(&mut page, "replay");
    // The simulator's run between, and back: it is the log's again.
    page.run("document.querySelector(\"[data-mode-choice='simulate']\").click();");
    page.until("document.getElementById('eyebrow').textContent !== 'Replayed log'");
    page.run("document.querySelector(\"[data-mode-choice='replay']\").click();");
    page.until("document.getElementById('status').textContent.startsWith('1\u{202f}501 rows.')");
    page.until("document.getElementById('time').max === '1500'");
    let shown = page.run(
        "return [document.getElementById('eyebrow').textContent, document.getElementById('verdict').textContent];",
    );
    assert_eq!(shown, json!(["Replayed log", verdict]));
    // The report is the program's own page.
    page.run("document.getElementById('save-report').click();");
    let report = page.run("return await window.saved.text();");
    assert!(report.as_str().unwrap().contains("id=\"verdict\""));
    // A bad line is named with file, line and column; what came before it is shown.
    let text = std::fs::read_to_string(run.join("log.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[100] = lines[100].replacen(',', ",ten,", 1).trim_end_matches(|c| c != ',').trim_end_matches(',').to_owned();
    let bad = scratch("replay-files").join("bad.csv");
    std::fs::write(&bad, lines.join("\n")).unwrap();
    page.choose_files("#files", &[bad]);
    page.until("!document.getElementById('problem').hidden");
    let problem = page.run("return document.getElementById('problem').textContent;");
    assert!(problem.as_str().unwrap().starts_with("bad.csv:101: left_ticks: is \"ten\""), "{problem}");
    let rig = scratch("replay-files").join("odd.toml");
    std::fs::write(&rig, "[wheels]\ntrack_m = 0.2\n").unwrap();
    page.choose_files("#files", &[run.join("log.csv"), rig]);
    page.until("document.getElementById('problem').textContent.startsWith('odd.toml')");
    assert_sound(&mut page, &address);
}
