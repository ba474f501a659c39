//! `docs/reference/settings.md` is what the code has.

use lab::input::part::PARTS;
use slam_core::Config;

const PAGE: &str = include_str!("../../docs/reference/settings.md");

/// The settings by their paths, as Rust writes their values: `walls` is `Grid`, a nested one `observe.gate`.
fn settings(config: &Config) -> Vec<(String, String)> {
    let text = format!("{config:#?}");
    let (mut path, mut settings) = (Vec::new(), Vec::new());
    for line in text.lines().skip(1) {
        let line = line.trim().trim_end_matches(',');
        match line.split_once(": ") {
            Some((name, value)) if value.ends_with(" {") => path.push(name),
            Some((name, value)) => settings.push(([&path[..], &[name]].concat().join("."), value.to_owned())),
            None => drop(path.pop()),
        }
    }
    settings
}

#[test]
fn every_setting_has_its_row_with_both_defaults() {
    let [analogue, metric] = [Config::default(), Config::real_rooms()].map(|config| settings(&config));
    assert!(analogue.len() > 10, "{analogue:?}");
    for ((name, default), (_, real)) in analogue.iter().zip(&metric) {
        let row = format!("| `{name}` | `{default}` | `{real}` | ");
        assert!(PAGE.contains(&row), "docs/reference/settings.md lacks {row}");
    }
    let table = PAGE.split("\n## ").next().expect("the first section");
    let rows = table.lines().filter(|line| line.starts_with("| `")).count();
    assert_eq!(rows, analogue.len(), "the page has settings that are none");
}

#[test]
fn every_part_has_its_row() {
    for part in &PARTS {
        let row = format!("| `{}` | {} |", part.name, part.without);
        assert!(PAGE.contains(&row), "docs/reference/settings.md lacks {row}");
    }
    let table = PAGE.split("## Parts").nth(1).expect("the section");
    assert_eq!(table.lines().filter(|line| line.starts_with("| `")).count(), PARTS.len());
}
