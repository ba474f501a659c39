//! The report: one self-contained HTML page of a run, and a still picture of its map.
//!
//! The page is a template with a style sheet, a script (the files under `js/`, in order) and the recording as compact
//! JSON (`data.rs`). It needs no network and no other file.

mod data;
mod picture;
mod series;

pub use picture::map_svg;

use super::svg::escape;
use crate::recording::Recording;
use std::{fs, io, path::Path};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");

/// In the order in which they build on each other.
const SCRIPTS: [&str; 17] = [
    include_str!("js/errors.js"),
    include_str!("js/format.js"),
    include_str!("js/theme.js"),
    include_str!("js/decode.js"),
    include_str!("js/display.js"),
    include_str!("js/hits.js"),
    include_str!("js/clock.js"),
    include_str!("js/layers.js"),
    include_str!("js/view.js"),
    include_str!("js/apart.js"),
    include_str!("js/map.js"),
    include_str!("js/robot.js"),
    include_str!("js/chart.js"),
    include_str!("js/charts.js"),
    include_str!("js/figures.js"),
    include_str!("js/tables.js"),
    include_str!("js/main.js"),
];

/// What the map shows.
const AT_THE_TIME: &str = "Walls and hits as they were estimated up to the moment on the slider.";
const LOOKING_BACK: &str = "The final map, and hits up to the moment on the slider, placed with the whole log at hand.";

/// Writes the report page of a run.
///
/// # Errors
/// The file cannot be written.
pub fn write(recording: &Recording, path: &Path) -> io::Result<()> {
    fs::write(path, html(recording))
}

/// The report page of a run.
pub fn html(recording: &Recording) -> String {
    let json = data::page_data(recording).to_string();
    // "</script" inside a string would end the element that holds the data.
    let json = json.replace('<', "\\u003c");
    let title = if recording.title.is_empty() { "Untitled run" } else { &recording.title };
    fill(
        PAGE,
        &[
            ("TITLE", &escape(title)),
            ("MAP_NOTE", if recording.looks_back { LOOKING_BACK } else { AT_THE_TIME }),
            ("STYLE", STYLE),
            ("MAP_SVG", &map_svg(recording)),
            ("DATA", &json),
            ("SCRIPT", &SCRIPTS.concat()),
        ],
    )
}

/// Replaces each `{{NAME}}` in one pass, so that nothing inside a replacement is taken for a name.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut page = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        page.push_str(before);
        let (name, tail) = after.split_once("}}").unwrap_or((after, ""));
        page.push_str(values.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value));
        rest = tail;
    }
    page.push_str(rest);
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_cannot_become_markup() {
        let recording = Recording { title: "</script><b>{{DATA}}".into(), ..Recording::default() };
        let page = html(&recording);
        assert!(!page.contains("<b>"));
        assert!(page.contains("<title>&lt;/script&gt;&lt;b&gt;{{DATA}}</title>"));
    }

    #[test]
    fn every_placeholder_is_filled() {
        let page = html(&Recording { title: "run".into(), ..Recording::default() });
        assert!(!page.contains("{{"), "{}", page.split_once("{{").unwrap().1);
        // The only address is the name of a namespace, which nothing fetches.
        let page = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!page.contains("http://") && !page.contains("https://"));
    }
}
