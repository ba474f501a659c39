//! Outputs written when a run is over: `walls.csv`, `calibration.csv`, `truth.tum` and `looking-back.tum`.

use std::fmt::Write as _;

use slam_core::WallKind;

use super::streams::{trajectory_line, tum_line};
use crate::numbers::shortest;
use crate::recording::{Recording, Step};

/// `walls.csv`.
pub fn walls(recording: &Recording) -> String {
    let mut text = String::from("kind,rho_m,beta_rad,lo_m,hi_m,sigma_rho_m\n");
    for wall in recording.walls() {
        let kind = match wall.kind {
            WallKind::Free => "free",
            WallKind::Snapped => "snapped",
            WallKind::Grid => "grid",
        };
        let numbers = [wall.rho_m, wall.beta_rad, wall.lo_m, wall.hi_m, wall.sigma_rho_m].map(shortest).join(",");
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{kind},{numbers}");
    }
    text
}

/// `calibration.csv`.
pub fn calibration(recording: &Recording) -> String {
    let mut text = String::from("parameter,estimate,sigma\n");
    if let Some(last) = recording.calibration.last() {
        for (parameter, (estimate, sigma)) in recording.parameters.iter().zip(&last.values) {
            let _ = writeln!(text, "{},{},{}", parameter.name, shortest(*estimate), shortest(*sigma));
        }
    }
    text
}

/// A path in the format of `trajectory.tum`.
pub fn path(recording: &Recording) -> String {
    recording.steps.iter().map(|step| trajectory_line(step) + "\n").collect()
}

/// `truth.tum`; none where no true pose is known.
pub fn truth(recording: &Recording) -> Option<String> {
    let line = |step: &Step| {
        let truth = step.truth?;
        let position = [truth.x_m, truth.y_m].map(shortest);
        Some(tum_line(&step.t_text, position, truth.theta_rad) + "\n")
    };
    let text: String = recording.steps.iter().filter_map(line).collect();
    (!text.is_empty()).then_some(text)
}
