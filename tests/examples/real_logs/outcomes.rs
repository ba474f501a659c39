//! What becomes of the readings, and how far off those are that no gate let in.

use std::fmt::Write as _;

use lab::recording::Recording;
use slam_core::{Outcome, Refusal};

use super::Case;

/// The table; `defaults` are the replays with the estimator's defaults.
pub fn write(text: &mut String, defaults: &[(Vec<Recording>, Case)]) -> std::fmt::Result {
    writeln!(
        text,
        "## What becomes of the readings\n\n\
         Shares of all readings; of those outside the gate, how many ended in front of the wall that they should have met,\n\
         and how far from it.\n\n\
         | log | used | outside the gate | unexplained | too far | other refusals | in front | under 15 cm | up to 50 cm | \
         farther |\n|{}",
        "---|".repeat(10)
    )?;
    for (recordings, case) in defaults {
        let Some(recording) = recordings.first() else { continue };
        writeln!(text, "| {} | {} | {} |", case.title, shares(recording).join(" | "), off(recording).join(" | "))?;
    }
    writeln!(text)
}

fn percent(part: usize, all: usize) -> String {
    format!("{:.0} %", 100.0 * part as f64 / all.max(1) as f64)
}

fn shares(recording: &Recording) -> [String; 5] {
    let count = |is: fn(&Outcome) -> bool| recording.readings.iter().filter(|reading| is(&reading.outcome)).count();
    let all = count(|outcome| *outcome != Outcome::Missing);
    let too_far = |outcome: &Outcome| *outcome == Outcome::Refused(Refusal::TooFar);
    [
        count(|outcome| matches!(outcome, Outcome::Updated { .. })),
        count(|outcome| matches!(outcome, Outcome::Gated { .. })),
        count(|outcome| *outcome == Outcome::Unexplained),
        count(too_far),
        count(|outcome| matches!(outcome, Outcome::Refused(_))) - count(too_far),
    ]
    .map(|n| percent(n, all))
}

fn off(recording: &Recording) -> [String; 4] {
    let innovation_m = |outcome: Outcome| match outcome {
        Outcome::Gated { innovation_m, .. } => Some(innovation_m),
        _ => None,
    };
    let off_m: Vec<f32> = recording.readings.iter().filter_map(|reading| innovation_m(reading.outcome)).collect();
    let count = |is: &dyn Fn(f32) -> bool| percent(off_m.iter().filter(|off_m| is(**off_m)).count(), off_m.len());
    [
        count(&|off_m| off_m < 0.0),
        count(&|off_m| off_m.abs() < 0.15),
        count(&|off_m| (0.15..0.5).contains(&off_m.abs())),
        count(&|off_m| off_m.abs() >= 0.5),
    ]
}
