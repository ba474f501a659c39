//! The report page of a recording, opened in a browser.

use std::path::Path;

use lab::recording::Recording;
use serde_json::Value;

use crate::browser::{Browser, Visit};

/// Opens the page of a recording with a browser profile in this folder; it must load without a fault and without fetching
/// anything. What the probe found, or none without a browser.
pub fn open(profile: &Path, recording: &Recording, hash: &str, probe: &str) -> Option<Value> {
    let visit = Browser::find()?.visit(profile, &lab::show::report::html(recording), hash, probe);
    assert_sound(&visit);
    Some(visit.answer)
}

/// It loaded without a fault, and the probe ran.
pub fn assert_sound(visit: &Visit) {
    assert!(visit.ready, "the page did not get ready; console: {:#?}", visit.console);
    assert_eq!(visit.errors, Some(0), "console: {:#?}", visit.console);
    assert!(visit.console.is_empty(), "{:#?}", visit.console);
    assert!(visit.answer.get("fault").is_none(), "the probe failed: {}", visit.answer["fault"]);
}
