//! The report: one self-contained HTML page of a run, and a still picture of its map.
//!
//! The page is a template with a style sheet, scripts (the view modules of the crate `pages` and `js/main.js`) and the
//! recording as compact JSON (`data.rs`). It needs no network and no other file.

mod counts;
mod data;
mod events;
mod floor;
mod frames;
pub mod growing;
mod picture;
mod series;

pub use data::{figures, wall_ends};
pub use floor::floor;
pub use picture::map_svg;

use super::svg::escape;
use crate::recording::Recording;
use std::{fs, io, path::Path};

const PAGE: &str = include_str!("page.html");
/// Puts the view modules together.
const MAIN: &str = include_str!("js/main.js");

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
    let map_note = if recording.looks_back { LOOKING_BACK } else { AT_THE_TIME };
    let title = escape(title);
    let header = fill(pages::HEADER, &[("EYEBROW", "Run report"), ("TITLE", &title), ("VERDICT", "")]);
    fill(
        PAGE,
        &[
            ("TITLE", &title),
            ("HEADER", &header),
            ("VIEWS", &fill(pages::SECTIONS, &[("MAP_NOTE", map_note)])),
            ("STYLE", pages::STYLE),
            ("MAP_SVG", &map_svg(recording)),
            ("DATA", &json),
            ("SCRIPT", &(pages::VIEWS.concat() + MAIN)),
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
