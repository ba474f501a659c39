//! Writes a `log.csv` from rows, so that it reads back as the same rows, bit for bit.

use std::fmt::Write as _;

use slam_core::{DriveModel, Motion, RangeInput, RangeModel};

use super::Row;
use crate::input::rig_file::Robot;
use crate::numbers::shortest;

/// The header line for a robot's log with the truth in it.
pub fn header(robot: &Robot) -> String {
    let mut text = String::from("t_s");
    text += match robot.rig.drive {
        DriveModel::Wheels { .. } => ",left_ticks,right_ticks",
        DriveModel::Odometry { .. } => ",odom_x_m,odom_y_m,odom_theta_rad",
    };
    for (i, sensor) in robot.rig.sensors.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = match sensor.model {
            RangeModel::Sharp { .. } => write!(text, ",adc_{i}"),
            RangeModel::Metric { .. } => write!(text, ",range_{i}_m"),
        };
    }
    text + ",true_x_m,true_y_m,true_theta_rad"
}

/// One row of a robot with encoders; a row with increments, which a log does not hold, has empty cells instead.
pub fn line(robot: &Robot, row: &Row) -> String {
    let mut text = row.t_text.clone();
    let _ = match row.sample.motion {
        Motion::Ticks(ticks) => write!(text, ",{},{}", ticks.left, ticks.right),
        Motion::Increment(_) => write!(text, ",,,"),
    };
    for range in &row.sample.ranges[..robot.rig.sensors.len()] {
        let _ = match *range {
            RangeInput::Missing => write!(text, ","),
            RangeInput::Counts(counts) => write!(text, ",{counts}"),
            RangeInput::Metres(range_m) => write!(text, ",{}", shortest(range_m)),
        };
    }
    match row.truth {
        Some(truth) => {
            let _ = write!(text, ",{}", [truth.x_m, truth.y_m, truth.theta_rad].map(shortest).join(","));
        }
        None => text += ",,,",
    }
    text
}
