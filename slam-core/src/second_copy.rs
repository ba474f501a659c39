//! A second copy of the home in one map.
//!
//! Something turns the robot, and neither its wheels nor its readings tell: it goes on in the frame of that turn, and what it
//! comes to again it draws again, askew. All of that fits, so that no reading speaks against it. Or something pushes it along, and it
//! has drawn again what is about it before enough readings said so. Where the walls drawn since lie to one another as older ones do,
//! the robot is beside those.

use crate::filter::layout::ALPHA;
use crate::kept::KeptWall;
use crate::slam::Slam;
use crate::take_up::{Match, Placement, Unfit};
use crate::walls::wall::Direction;

/// The walls of a map that were drawn since something turned the robot, or pushed it along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SecondCopy {
    /// Identifier of the first of them.
    pub since: u16,
    /// Identifier of the one whose direction they have as their grid; none where that is the map's.
    pub grid: Option<u16>,
}

impl SecondCopy {
    /// Whether a wall of this identifier is one of them.
    pub fn has(&self, wall: u16) -> bool {
        wall.wrapping_sub(self.since) as i16 >= 0
    }

    /// The index of the state that is their grid's direction, in a map of walls with these identifiers and directions; none where the wall
    /// that it is of is gone.
    pub fn grid_state(&self, mut walls: impl Iterator<Item = (u16, Direction)>) -> Option<usize> {
        match self.grid {
            None => Some(ALPHA),
            Some(grid) => walls.find(|(id, _)| *id == grid)?.1.state(),
        }
    }
}

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Gives up the walls of a second copy, where `found` says how they lie in the older ones: the robot goes on beside these.
    ///
    /// # Errors
    /// A wall of the match is not there, or its two walls are parallel; nothing is changed then.
    #[inline(never)]
    pub fn give_up_copy(&mut self, copy: &SecondCopy, found: &Match) -> Result<(), Unfit> {
        let wall_of = |id: u16| self.map.walls().iter().find(|wall| wall.id == id);
        let walls = self.map.walls().iter().map(|wall| (wall.id, wall.direction));
        let grid = copy.grid_state(walls).ok_or(Unfit::NoMatch)?;
        let beside = self.beside(found, grid).ok_or(Unfit::NoMatch)?;
        let older = found.pairs.map(|(_, id)| wall_of(id).filter(|wall| !copy.has(wall.id)).map(KeptWall::of));
        let [Some(first), Some(second)] = older else { return Err(Unfit::NoMatch) };
        let pose = Placement::of(&*self, [first, second], &beside, found.quarters).ok_or(Unfit::NoMatch)?;
        self.stand(&pose);
        self.map.forget_some(&mut self.ekf, |wall| copy.has(wall.id));
        self.map.begin_epoch();
        self.counters.add_second_copy(copy.grid.is_some());
        Ok(())
    }
}
