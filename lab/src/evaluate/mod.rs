//! How good an estimate is: scores against the truth and against itself, the same with the whole log at hand, two runs
//! side by side.

pub mod compare;
pub mod robot_look_back;
pub mod score;
pub mod smoother;
pub mod statistics;
