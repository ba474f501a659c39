//! The bodies of the tasks. None ever returns.

mod drive;
mod estimate;
mod guard;
mod look_back;
mod sense;
mod serial;
mod supervise;

pub use drive::drive;
pub use estimate::estimate;
pub use guard::guard;
pub use look_back::look_back;
pub use sense::{odometry, sample};
pub use serial::{commands, telemetry};
pub use supervise::{Platform, supervise};
