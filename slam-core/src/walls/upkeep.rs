//! The map's upkeep once a step: the grid, walls that are one, walls that are gone.

use crate::filter::ekf::EkfView;
use crate::report::Changes;
use crate::walls::founding;
use crate::walls::map::MapView;
use crate::walls::wall::WallPolicy;

/// Founds the grid or takes a wall into it, merges and removes, in the step of this number.
pub fn upkeep(map: &mut MapView, ekf: &mut EkfView, policy: WallPolicy, number: usize, path_m: f32) -> Changes {
    founding::upkeep(map, ekf, policy, number);
    // One wall a step is held against all others.
    let turn = number % map.walls().len().max(1);
    let merges = u8::from(map.merge(ekf, policy, turn, false));
    let prunes = u8::from(map.prune(ekf, path_m));
    Changes { merges, prunes, ..Changes::default() }
}
