//! When a robot that nobody tells to stand makes a stop to save its map.

use slam_core::kept::{Kept, KeptFrame};

use crate::record::Record;

/// Path after which a map is worth saving again, metres.
pub const WORTH_M: f32 = 3.0;

/// Walls of the first map that a robot makes a stop for, those of a room: switched off after that, it knows where it is again.
const ROOM: u16 = 4;

/// Whether a map is worth a stop, so long after it was saved or found, metres: where it has twice as many walls as the record that is kept.
/// Power that fails, or readings that contradict it, then cost half of a map at most, for five stops up to 64 walls.
pub fn is_outgrown(kept: Option<&Record<'_>>, now: &KeptFrame, unsaved_m: f32) -> bool {
    let kept = kept.map_or(0, |record| record.frame().walls);
    now.has_grid && unsaved_m >= WORTH_M && now.walls >= ROOM.max(2 * kept)
}
