//! The studio: a page in which the estimator maps a simulated home, replays a log or watches a robot.
//!
//! Everything here runs in the browser as WebAssembly and on a desk as it is, which is how it is tested. The page's own
//! scripts are in `page`; `cargo xtask studio` puts both together. One rule: nothing waits and nothing is without bound. The
//! page asks for a little work a frame, and gets what has come since.

#![forbid(unsafe_code)]

mod bindings;
mod errands;
mod looking_back;
mod replayed;
mod rig;
mod simulated;
mod watched;

pub use errands::Errands;
pub use looking_back::LookingBack;
pub use replayed::{File, Files, Replayed};
pub use rig::{Knobs, tuned};
pub use simulated::{Scene, Simulated};
pub use watched::Watched;
