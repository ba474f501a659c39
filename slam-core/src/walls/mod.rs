//! The walls of the map, the grid that they stand on and the frame that they hold (Rousse & Qiu 3.2).

pub mod anchor;
pub mod astray;
pub mod decision;
pub mod exact_grid;
pub mod exactness;
pub mod founding;
pub mod hindsight;
pub mod manhattan;
pub mod map;
pub mod map_frame;
pub mod merge;
pub mod tolerance;
pub mod upkeep;
pub mod wall;

use map::MapFrame;
use wall::WallPolicy;

/// The relief of built walls, metres: door frames, skirting boards, panels. In the Freiburg offices a laser's readings lie
/// 2.2 cm from the line of their wall (docs/notes/real-logs.md), whatever the incidence; a good centimetre is the laser's own.
pub const BUILT_RELIEF_M: f32 = 0.015;

/// What walls are like, and what they hold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WallSettings {
    /// Wall kinds.
    pub policy: WallPolicy,
    /// How far the surfaces of walls are from planes, 1-sigma, metres, beyond the roughness of plaster.
    pub relief_m: f32,
    /// What holds the map frame.
    pub frame: MapFrame,
}

impl WallSettings {
    pub(crate) const IDLE: Self =
        Self { policy: WallPolicy::Snapped { theta_moves: false }, relief_m: 0.0, frame: MapFrame::Start };

    /// For walls as they are built.
    pub fn real_rooms() -> Self {
        Self { policy: WallPolicy::NearGrid, relief_m: BUILT_RELIEF_M, frame: MapFrame::Walls }
    }
}

impl Default for WallSettings {
    fn default() -> Self {
        Self { policy: WallPolicy::default(), relief_m: 0.0, frame: MapFrame::default() }
    }
}

impl From<WallPolicy> for WallSettings {
    fn from(policy: WallPolicy) -> Self {
        Self { policy, ..Self::default() }
    }
}
