//! When a robot that nobody tells to stand makes a stop to save its map.

use slam_core::kept::KeptFrame;

/// Path after which a map is worth saving again, metres.
pub const WORTH_M: f32 = 3.0;

/// Walls of the first map that a robot makes a stop for, those of a room.
const ROOM: u16 = 4;

/// Whether a map is worth a stop, so long after it was saved or found, metres: where it has twice as many walls as the one that is kept.
/// Power that fails then costs half of a map at most, for five stops up to 64 walls.
pub fn is_outgrown(kept: Option<KeptFrame>, now: &KeptFrame, unsaved_m: f32) -> bool {
    let walls = kept.map_or(0, |kept| kept.walls);
    now.has_grid && unsaved_m >= WORTH_M && now.walls >= ROOM.max(2 * walls)
}
