//! Whether an estimator can go on with a kept map.

use kept_map::Record;
use slam_core::kept::{Direction, Kept as _};
use slam_core::{HostSlam, Unfit, WallPolicy};

/// Checks that a kept map of this robot is one that the estimator could have made.
///
/// # Errors
/// Why it is not.
pub(super) fn suits(slam: &HostSlam, record: &Record<'_>) -> Result<(), String> {
    slam.suits(record).map_err(|unfit| unsuitable(unfit).to_owned())?;
    let policy = slam.config().walls.policy;
    let mut walls = (0..usize::from(record.frame().walls)).filter_map(|index| record.wall(index));
    // A map of free walls has no grid, and does not come so far.
    let suits = policy != WallPolicy::Free && walls.all(|wall| is_of(policy, wall.direction));
    if suits { Ok(()) } else { Err(OTHER_WALLS.to_owned()) }
}

/// Why a kept map cannot be gone on with.
pub fn unsuitable(unfit: Unfit) -> &'static str {
    match unfit {
        Unfit::TooLarge => "has more walls or states than there is room for; it must be the map of a smaller home",
        Unfit::OtherCalibration => {
            "was made with other settings, which calibrate other things; the same --walls, --without and --no-calibration are needed"
        }
        Unfit::NoGrid => "has no wall grid, which finding oneself needs; it must be the map of a longer drive",
        Unfit::NoMatch | Unfit::NoNumber => "has values that no map has; it must be one that a run or a replay wrote",
    }
}

/// A kept map whose walls are others than the settings have.
const OTHER_WALLS: &str = "was made with other settings for its walls; the same --walls is needed";

/// Whether a map that is made with this setting can have such a wall. On a grid walls are tied to it loosely at first.
fn is_of(policy: WallPolicy, direction: Direction) -> bool {
    let is_snapped = matches!(policy, WallPolicy::Snapped { .. });
    match direction {
        Direction::Free(_) => true,
        Direction::Snapped(_) => is_snapped,
        Direction::Grid(_) | Direction::NearGrid(..) | Direction::Built(..) => !is_snapped,
    }
}
