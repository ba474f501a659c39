//! The floor of a home that is rebuilt while the robot drives.

use super::{CELL_M, FloorRaster};
use crate::plan::Plan;

impl FloorRaster {
    /// The floor that can be reached in this plan from where the robot is now, and what of it was swept so far.
    pub fn rebuild(&mut self, plan: &Plan) {
        let here = self.last.unwrap_or(self.start);
        let mut new = Self::new(plan, self.radius_m, here);
        for cell in 0..new.is_floor.len() {
            let Some(old) = self.cell_at(new.centre_m(cell)) else { continue };
            (new.swept_s[cell], new.last_s[cell]) = (self.swept_s[old], self.last_s[old]);
            let [swept, twice] = self.swept_s[old].map(|at_s| usize::from(new.is_floor[cell] && at_s.is_finite()));
            new.swept += swept;
            new.twice += twice;
        }
        let Self { corner_m, columns, rows, is_floor, swept_s, last_s, floor, swept, twice, bounds, .. } = new;
        *self =
            Self { corner_m, columns, rows, is_floor, swept_s, last_s, floor, swept, twice, bounds, ..self.clone() };
    }

    /// The cell that a point of the plan (metres) lies in.
    fn cell_at(&self, point_m: [f64; 2]) -> Option<usize> {
        let index = |axis: usize| ((point_m[axis] - self.corner_m[axis]) / CELL_M).floor();
        let (column, row) = (index(0), index(1));
        let is_inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        is_inside.then(|| row as usize * self.columns + column as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{moment, room};
    use crate::plan_file;

    #[test]
    fn what_was_swept_stays_swept_and_new_floor_is_not() {
        let mut raster = room();
        (0..=50).for_each(|i| raster.record(&moment(0.04 * f64::from(i), 0.2 + 0.01 * f64::from(i))));
        let before = raster.score();
        // Without the wall between, and with a wall that moves the plan's corner.
        let plan = "[start]\nx_m = 0.5\ny_m = 0.5\n\
            [[outline]]\npoints_m = [[-0.3, 0.0], [2.0, 0.0], [2.0, 1.0], [-0.3, 1.0]]\n";
        raster.rebuild(&plan_file::parse("home.toml", "home", plan).unwrap());
        let after = raster.score();
        assert!(after.floor_m2 > 2.0 * before.floor_m2, "{} {}", after.floor_m2, before.floor_m2);
        let [was_m2, is_m2] = [&before, &after].map(|score| score.swept * score.floor_m2);
        assert!((is_m2 - was_m2).abs() < 0.02, "{was_m2} {is_m2}");
        assert_eq!((after.path_m, after.time), (before.path_m, before.time));
    }
}
