mod areas;
mod growth;
mod nor;
mod power_cuts;
mod receiving;
mod records;

use slam_core::Pose;
use slam_core::kept::{Direction, Kept, KeptFrame, KeptWall};

/// A map of two walls whose numbers all tell which save it was.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Map(u16);

const STATES: usize = 9;

impl Map {
    /// Whether walls stand off their grid as built ones do.
    fn is_built(self) -> bool {
        self.0.is_multiple_of(5)
    }
}

impl Kept for Map {
    fn frame(&self) -> KeptFrame {
        let pose = |x_m: f32| Pose { x_m, y_m: 2.0, theta_rad: 0.25 };
        KeptFrame {
            states: STATES as u16,
            common: 7,
            walls: 2,
            next_id: self.0,
            has_grid: true,
            has_dock: self.0.is_multiple_of(3),
            exactness: if self.is_built() { i8::MIN } else { -2 },
            start: pose(f32::from(self.0)),
            anchor: self
                .0
                .is_multiple_of(2)
                .then_some((pose(-1.0), [[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])),
            number: 0,
        }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        let near = if self.is_built() { Direction::Built(8, 1) } else { Direction::NearGrid(8, 1) };
        let directions = [Direction::Grid(3), near];
        directions.get(index).map(|&direction| KeptWall {
            id: self.0.wrapping_add(index as u16),
            rho: 7,
            direction,
            lo_m: -f32::from(self.0),
            hi_m: 1.5,
            updates: u32::from(self.0) << 10,
            score: -3,
            drawn: (index == 1).then_some([0.5, -0.5]),
        })
    }

    fn mean(&self, i: usize) -> f32 {
        if i < 3 { 0.0 } else { i as f32 + f32::from(self.0) }
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        let (i, j) = (i.min(j), i.max(j));
        if i < 3 { 0.0 } else { (100 * i + j) as f32 + f32::from(self.0) }
    }
}

/// Whether everything of a map is what it was, to the last bit.
fn same(a: &impl Kept, b: &impl Kept) -> bool {
    let states = || 0..STATES;
    a.frame() == b.frame()
        && (0..3).all(|i| a.wall(i) == b.wall(i))
        && states().all(|i| a.mean(i).to_bits() == b.mean(i).to_bits())
        && states().all(|i| states().all(|j| a.covariance(i, j).to_bits() == b.covariance(i, j).to_bits()))
}
