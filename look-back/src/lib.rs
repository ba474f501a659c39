//! The back end of the estimator: a drive's path and walls placed together, so that all that was sensed is likeliest.
//!
//! The filter of slam-core knows at each moment what was sensed until then; what it drew before a loop closed stays where it
//! was drawn. This crate keeps a [`Diary`] of the drive in bounded memory and solves it as a whole (full SLAM: Thrun and
//! Montemerlo 2006) with a [`LookBack`], in slices of bounded cost, so that a robot can do it beside its filter.
//!
//! Layers, in the order in which the data flow; none reaches back:
//!
//! | layer | what it makes |
//! |---|---|
//! | [`diary`], keyframe, group, thin, redundancy | keyframes, the odometry between them, and what was seen from each: the hits on one surface as sums |
//! | kept | what a map that was there before knows, as if its walls had been seen |
//! | gains, rows | residuals of odometry, groups and priors with their derivatives |
//! | system, packed | one Gauss-Newton step: poses eliminated along the path, the border solved, the poses found on the way back |
//! | solve | the step in slices |
//! | place, turned, survey, chance, labels, twins | where a new wall is, whether something turned the robot, what was seen of each wall, which group is on which, which two are one |
//! | [`look_back`] | the order of all that, and what came of it |
//! | record, power | what a step of the filter writes down |
//! | posterior, present | what was found, brought up to the present and handed over to the filter |
//! | back_end | a filter's companion: when it looks back, and for how long at a time |
//!
//! One rule: work is asked for. The crate knows nothing of tasks, files or clocks; [`LookBack::work`] does about as many
//! multiply-adds as it is allowed and returns.
//!
//! What is wired up: `lab run` and `lab replay` run a [`BackEnd`] beside the filter as a robot would (`--hand-overs`); a
//! measurement sets it beside the workbench's look back, which has no bounds on memory (`cargo run --release --package tests
//! --example robot_look_back`). The firmware runs it in a task below all others.
//!
//! Frames and units are slam-core's: metres, radians; *map* is where the first keyframe was put. All is f32; what is solved
//! for are increments, so that sums over a long drive lose nothing that matters.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

mod ages;
mod back_end;
mod chance;
pub mod diary;
mod frame;
mod gains;
mod group;
mod kept;
mod keyframe;
mod labels;
pub mod look_back;
mod names;
mod packed;
mod place;
mod posterior;
mod power;
mod present;
mod record;
mod redundancy;
mod room;
mod rows;
mod solve;
mod survey;
mod system;
#[cfg(test)]
mod tests;
mod thin;
mod turned;
mod twins;
mod wall;

pub use back_end::{BackEnd, STEP_US, Tally};
pub use diary::{Diary, Hit};
pub use look_back::{LookBack, Progress, Unknown};
pub use packed::packed_len;
pub use system::border_len;
pub use wall::Wall;

/// Keyframes of a robot's diary.
pub const ROBOT_KEYFRAMES: usize = 256;
/// Groups of a robot's diary: as many as its RAM has room for beside all else.
pub const ROBOT_GROUPS: usize = 1016;
/// Walls of a robot's diary.
pub const ROBOT_WALLS: usize = 64;
/// Unknowns of its border.
const ROBOT_BORDER: usize = border_len(ROBOT_WALLS);

/// The diary in a size for a robot.
pub type RobotDiary = Diary<ROBOT_KEYFRAMES, ROBOT_GROUPS, ROBOT_WALLS>;
/// Both, beside the robot's filter.
pub type RobotBackEnd = BackEnd<ROBOT_KEYFRAMES, ROBOT_GROUPS, ROBOT_WALLS, ROBOT_BORDER, { packed_len(ROBOT_BORDER) }>;
/// The solver of such a diary.
pub type RobotLookBack = LookBack<ROBOT_KEYFRAMES, ROBOT_WALLS, ROBOT_BORDER, { packed_len(ROBOT_BORDER) }>;
