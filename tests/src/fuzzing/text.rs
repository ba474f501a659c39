//! Bytes on the serial line, and texts: logs, plans, rig files. What cannot be read is an error with words, never a panic.

use std::io::Write as _;
use std::path::Path;

use lab::input::log;
use lab::input::rig_file::Robot;
use tempfile::NamedTempFile;
use wire::Decoder;

use super::source::Source;

/// Words that numbers and keys are replaced by.
const WORDS: [&str; 14] =
    ["NaN", "inf", "-inf", "1e308", "-1e308", "1e-320", "0", "-0", "", "18446744073709551616", "[", "\"", "\n", ","];

/// A good text with as many changes as there are bytes for; or, one time in four, the bytes themselves.
fn edited(good: &str, bytes: &[u8]) -> Vec<u8> {
    let mut source = Source::new(bytes);
    if source.chance(64) {
        return bytes.get(1..).unwrap_or(&[]).to_vec();
    }
    let mut text = good.as_bytes().to_vec();
    while !source.is_empty() {
        let at = (source.unit() * text.len() as f64) as usize;
        let end = (at + source.below(24)).min(text.len());
        match source.below(4) {
            0 => drop(text.splice(at..end, WORDS[source.below(WORDS.len())].bytes())),
            1 => drop(text.drain(at..end)),
            2 => drop(text.splice(at..at, text[at..end].to_vec())),
            _ => drop(text.splice(at..end, [source.byte()])),
        }
        text.truncate(1 << 16);
    }
    text
}

/// Bytes of a serial line: every frame that comes out goes in again as the same bytes.
pub fn wire(bytes: &[u8]) -> u64 {
    let mut decoder = Decoder::new();
    for &byte in bytes.iter().chain(&[0]) {
        if let Some(Ok(frame)) = decoder.push(byte) {
            let encoded = wire::encode(&frame).expect("what was decoded has room");
            let mut again = Decoder::new();
            let decoded = encoded.iter().find_map(|&byte| again.push(byte));
            let encoded_again = decoded.and_then(Result::ok).and_then(|frame| wire::encode(&frame).ok());
            assert_eq!(encoded_again.as_deref(), Some(encoded.as_slice()), "{frame:?}");
        }
    }
    bytes.len() as u64
}

/// A log, for the built-in robot.
pub fn logs(bytes: &[u8]) -> u64 {
    let (mut robot, _) = lab::input::built_in_robot().expect("the built-in rig is good");
    let good = lab::input::log::writer::header(&robot) + "\n" + &"0.04,1,2,300,301,302,303,304,305,306,307\n".repeat(5);
    let mut file = NamedTempFile::new().expect("a temporary file");
    file.write_all(&edited(&good, bytes)).expect("room on the disk");
    let mut rows = 0;
    if let Ok(log) = log::open(file.path(), &mut robot) {
        let mut last_us = None;
        for row in log.map_while(Result::ok) {
            assert!(row.t_s.is_finite() && last_us < Some(row.sample.time_us), "{row:?}");
            last_us = Some(row.sample.time_us);
            rows += 1;
        }
    }
    rows
}

/// A plan.
pub fn plans(bytes: &[u8]) -> u64 {
    let good = include_str!("../../../hal-sim/plans/clutter.toml");
    let text = String::from_utf8_lossy(&edited(good, bytes)).into_owned();
    if let Ok(plan) = hal_sim::plan_file::parse("plan", "plan", &text) {
        assert!(plan.faces.iter().all(|face| face.length_m().is_finite()), "{plan:?}");
    }
    1
}

/// A rig file: what it lets pass the estimator takes.
pub fn rig_files(bytes: &[u8]) -> u64 {
    let (robot, _) = lab::input::built_in_robot().expect("the built-in rig is good");
    let text = String::from_utf8_lossy(&edited(&robot.to_toml(), bytes)).into_owned();
    if let Ok(robot) = Robot::parse(Path::new("rig"), &text) {
        robot.rig.validate().expect("what a rig file may say the estimator takes");
    }
    1
}
