//! What the report of a run and the studio share: the view modules, their style sheet, and a server for a folder of files.
//!
//! The modules are plain scripts that go into one scope, one after the other. A page adds a script of its own that puts them
//! together.

#![forbid(unsafe_code)]

pub mod serve;

/// The style sheet.
pub const STYLE: &str = include_str!("style.css");

/// The head of a page, with the choice of its theme; `{{EYEBROW}}`, `{{TITLE}}` and `{{VERDICT}}` in it are its words.
pub const HEADER: &str = include_str!("header.html");

/// The sections that the view modules fill; `{{MAP_NOTE}}` in it is what the page says of its map.
pub const SECTIONS: &str = include_str!("views.html");

/// The view modules, in the order in which they build on each other.
pub const VIEWS: [&str; 20] = [
    include_str!("js/errors.js"),
    include_str!("js/format.js"),
    include_str!("js/theme.js"),
    include_str!("js/decode.js"),
    include_str!("js/display.js"),
    include_str!("js/hits.js"),
    include_str!("js/clock.js"),
    include_str!("js/layers.js"),
    include_str!("js/view.js"),
    include_str!("js/picture.js"),
    include_str!("js/apart.js"),
    include_str!("js/map.js"),
    include_str!("js/robot.js"),
    include_str!("js/chart.js"),
    include_str!("js/charts.js"),
    include_str!("js/figures.js"),
    include_str!("js/tables.js"),
    include_str!("js/controls.js"),
    include_str!("js/floor.js"),
    include_str!("js/place.js"),
];
