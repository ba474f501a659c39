//! Writes a `log.csv` from rows, so that it reads back as the same rows, bit for bit.

use std::fmt::Write as _;

use slam_core::{DriveModel, Motion, RangeInput, RangeModel};

use super::Row;
use crate::input::rig_file::Robot;
use crate::numbers::shortest;
use crate::recording::Pose2;

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
    text + ",lifted,docked,true_x_m,true_y_m,true_theta_rad"
}

/// One row; increments without the pose that they led to leave empty cells.
pub fn line(robot: &Robot, row: &Row) -> String {
    let mut text = row.t_text.clone();
    let _ = match row.sample.motion {
        Motion::Ticks(ticks) => write!(text, ",{},{}", ticks.left, ticks.right),
        Motion::Increment(_) => write!(text, ",{}", cells(row.odometry)),
    };
    for range in &row.sample.ranges[..robot.rig.sensors.len()] {
        let _ = match *range {
            RangeInput::Missing => write!(text, ","),
            RangeInput::Counts(counts) => write!(text, ",{counts}"),
            RangeInput::Metres(range_m) => write!(text, ",{}", shortest(range_m)),
        };
    }
    let _ = write!(text, ",{},{},", u8::from(row.lifted), u8::from(row.docked));
    text + &cells(row.truth)
}

/// The three cells of a pose.
fn cells(pose: Option<Pose2>) -> String {
    pose.map_or_else(|| ",,".to_owned(), |pose| [pose.x_m, pose.y_m, pose.theta_rad].map(shortest).join(","))
}
