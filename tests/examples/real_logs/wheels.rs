//! Logs with the odometry of real wheels and drones, and what happens to logs whose odometry is made worse.

use std::fmt::Write as _;

use lab::recording::Figures;
use slam_core::Config;
use tests::real_logs::{DRONE_8, DRONE_12, FREIBURG, FREIBURG_WHEELS, INTEL};
use tests::trial::{Disturbance, Trial};

use super::Case;
use super::cells::{centimetres, lost};

/// As the robots logged them, in full and with readings up to 1.5 m.
const LOGS: [Case; 6] = [
    Case { title: "fr079-first-realodo", log: FREIBURG_WHEELS, trial: |trial| trial },
    Case { title: "fr079-first-realodo, as ticks", log: FREIBURG_WHEELS.with_wheels(), trial: |trial| trial },
    Case { title: "intel-loops", log: INTEL, trial: |trial| trial },
    Case { title: "intel-loops, as ticks", log: INTEL.with_wheels(), trial: |trial| trial },
    Case { title: "smcl-S8", log: DRONE_8, trial: |trial| trial },
    Case { title: "smcl-S12", log: DRONE_12, trial: |trial| trial },
];

/// Logs whose odometry is disturbed.
const DISTURBED: [usize; 4] = [0, 2, 4, 5];

/// What is done to an odometry, and how it is called.
const DISTURBANCES: [(&str, Disturbance); 8] = [
    ("as logged", Disturbance::NONE),
    ("drift of 1 degree a metre", Disturbance { drift_deg_per_m: 1.0, ..Disturbance::NONE }),
    ("drift of 3 degrees a metre", Disturbance { drift_deg_per_m: 3.0, ..Disturbance::NONE }),
    ("5 % too long", Disturbance { scale: 1.05, ..Disturbance::NONE }),
    ("5 % too short", Disturbance { scale: 0.95, ..Disturbance::NONE }),
    ("latched 0.1 s off", Disturbance { jitter_s: 0.1, ..Disturbance::NONE }),
    ("a third of the noise stated", Disturbance { stated: 1.0 / 3.0, ..Disturbance::NONE }),
    ("three times the noise stated", Disturbance { stated: 3.0, ..Disturbance::NONE }),
];

/// Most that a reading may be in the second half of each table, metres.
const SHORT_M: f32 = 1.5;

/// The part of the page on real odometry.
pub fn write(text: &mut String) -> std::fmt::Result {
    writeln!(text, "## Real wheels and drones\n\n{LOST}\n\n{HEADER}")?;
    for case in &LOGS {
        row(text, case.title, case, Disturbance::NONE)?;
    }
    writeln!(text, "\n## Disturbed odometry\n")?;
    let offices = Case { title: "fr079-first", log: FREIBURG, trial: |trial| trial };
    for case in [&offices].into_iter().chain(DISTURBED.into_iter().filter_map(|i| LOGS.get(i))) {
        writeln!(text, "### {}\n\n{HEADER}", case.title)?;
        for (name, disturbance) in DISTURBANCES {
            row(text, name, case, disturbance)?;
        }
        writeln!(text)?;
    }
    Ok(())
}

const LOST: &str = "*Lost* is the share of the rows at which the robot says that it does not know where it is, for its readings contradicted its map: the live\nerror is of the others, and odometry's and that of looking back are of all.";

const HEADER: &str = "| odometry | its aligned RMSE | live | lost | looking back | live, up to 1.5 m | lost | looking back |\n|---|---|---|---|---|---|---|---|";

fn row(text: &mut String, name: &str, case: &Case, odometry: Disturbance) -> std::fmt::Result {
    let figures = |cap_m: f32| -> Vec<Figures> {
        let trial = Trial { cap_m, odometry, ..Trial::default() };
        case.replay_with(Config::real_rooms(), trial).into_iter().map(|recording| recording.figures).collect()
    };
    let (full, short) = (figures(f32::INFINITY), figures(SHORT_M));
    let own: Vec<f64> = full.iter().filter_map(|figures| Some(figures.odometry?.ate_m)).take(1).collect();
    let cells = [&full, &short].map(|runs| {
        let live = runs.iter().filter_map(|figures| Some(figures.estimate?.ate_m)).collect();
        let back = runs.iter().filter_map(|figures| Some(figures.looking_back.as_ref()?.estimate?.ate_m)).collect();
        format!("{} | {} | {}", centimetres(live), lost(runs), centimetres(back))
    });
    let own = own.first().map_or_else(String::new, |metres| format!("{:.0} cm", 100.0 * metres));
    writeln!(text, "| {name} | {own} | {} |", cells.join(" | "))
}
