//! What a kept map tells before anything is seen: where walls stand, and that between them there is floor.

use slam_core::Pose;

use super::FloorJob;
use super::swept::CELLS;
use crate::pilot::memory::Cell;

/// Cells of the picture in which floor is presumed in one step: all of them in seven seconds.
const PRESUMED: u16 = 40;

/// Where floor is presumed: a box of cells of the picture, and the cell that comes next, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    low: Cell,
    high: Cell,
    next: u16,
}

impl<const S: usize> FloorJob<S> {
    /// Home is there, in the map frame, metres.
    pub fn go_home_to(&mut self, home: Pose) {
        self.home = Some(home);
    }

    /// One more wall of the kept map, by its ends in the map frame, metres: it stands there as if two beams had ended on each of its
    /// cells, and there is floor between it and the others until something is seen to stand there, so that none of it need be explored.
    pub fn know_wall(&mut self, ends_m: [[f32; 2]; 2]) {
        let back = self.frame.origin().inverse();
        let [from_m, to_m] = ends_m.map(|end_m| back.transform(end_m));
        let length_m = libm::hypotf(to_m[0] - from_m[0], to_m[1] - from_m[1]);
        let count = ((length_m / (0.5 * self.sheet.picture.cell_m)) as u16 + 1).min(4 * CELLS as u16);
        for index in 0..=count {
            let share = f32::from(index) / f32::from(count);
            let [x_m, y_m] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            let cell = self.sheet.picture.cell_at(x_m, y_m);
            self.sheet.picture.see_hit(cell);
            self.sheet.picture.see_hit(cell);
            let Known { low, high, .. } = self.known.unwrap_or(Known { low: cell, high: cell, next: 0 });
            self.known = Some(Known {
                low: Cell { col: low.col.min(cell.col), row: low.row.min(cell.row) },
                high: Cell { col: high.col.max(cell.col), row: high.row.max(cell.row) },
                next: 0,
            });
        }
    }

    /// Presumes floor in the next cells between the walls of the kept map.
    pub(super) fn presume_floor(&mut self) {
        let Some(known) = &mut self.known else { return };
        for _ in 0..PRESUMED {
            let cell = Cell { col: (known.next % CELLS as u16) as i16, row: (known.next / CELLS as u16) as i16 };
            let is_between = |value: i16, low: i16, high: i16| low < value && value < high;
            if is_between(cell.col, known.low.col, known.high.col)
                && is_between(cell.row, known.low.row, known.high.row)
            {
                self.sheet.picture.presume_free(cell);
            }
            known.next += 1;
            if known.next == (CELLS * CELLS) as u16 {
                self.known = None;
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FloorConfig, FloorJob};
    use super::*;

    #[test]
    fn between_the_walls_there_is_floor() {
        let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
        job.align(0.1);
        let turned = |[x_m, y_m]: [f32; 2]| Pose::new(0.0, 0.0, 0.1).transform([x_m, y_m]);
        let corners = [[-1.0, -1.0], [3.0, -1.0], [3.0, 2.0], [-1.0, 2.0]];
        (0..4).for_each(|i| job.know_wall([turned(corners[i]), turned(corners[(i + 1) % 4])]));
        (0..200).for_each(|_| job.presume_floor());
        assert_eq!(job.known, None);
        let picture = &job.sheet.picture;
        let at = |[x_m, y_m]: [f32; 2]| picture.cell_at(x_m, y_m);
        assert!(picture.is_free(at([1.0, 0.5])) && picture.is_free(at([2.5, 1.5])));
        assert!(picture.is_obstacle(at([3.0, 0.5])) && picture.is_obstacle(at([0.0, -1.0])));
        assert!(!picture.is_known(at([4.0, 0.5])) && !picture.is_known(at([0.0, 3.0])));
    }
}
