//! Where the robot was of late: floor that is not sure to be swept where its pose turns out to have been wrong.
//!
//! Wheels do not move sideways. Where the pose does on a lane, it is corrected, and the robot was beside its lane for some time before:
//! by all of the correction just now, by less the farther back.

use slam_core::pose::length;

use super::place::Place;
use super::sheet::{Axis, Sheet};

/// Points of the trail, and how far apart they are, metres: the last five metres.
const POINTS: usize = 25;
pub(super) const APART_M: f32 = 0.2;
/// What a metre is in the unit of ways aside, which are sums of corrections of many steps.
const FINE: f32 = 100_000.0;
/// What the pose is off by grows over about so much path, metres: of farther back a correction says nothing.
const FADES_M: f32 = 3.0;

/// A point of the path.
#[derive(Clone, Copy, Debug)]
struct Point {
    place: Place,
    /// How far across its lane the robot was from there after all, in hundredths of a millimetre.
    aside: i16,
}

/// The last metres of the path.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    points: heapless::Deque<Point, POINTS>,
    since_m: f32,
}

impl Trail {
    pub(super) const fn new() -> Self {
        Self { points: heapless::Deque::new(), since_m: f32::INFINITY }
    }

    /// The robot is here, metres. Where it stands and turns, what its pose jitters by is no way.
    pub(super) fn step(&mut self, at_m: [f32; 2]) {
        self.since_m = self.last_m().map_or(APART_M, |[x_m, y_m]| length(at_m[0] - x_m, at_m[1] - y_m));
        if self.since_m < APART_M {
            return;
        }
        self.since_m = 0.0;
        if self.points.is_full() {
            let _ = self.points.pop_front();
        }
        let _ = self.points.push_back(Point { place: Place::of_m(at_m), aside: 0 });
    }

    /// On a lane, the pose was corrected across it by so much, metres.
    pub(super) fn correct(&mut self, across_m: f32) {
        let mut back_m = self.since_m;
        for point in self.points.iter_mut().rev() {
            let aside_m = across_m * (1.0 - back_m / FADES_M).max(0.0);
            point.aside = point.aside.saturating_add((aside_m * FINE) as i16);
            back_m += APART_M;
        }
    }

    /// A lane of this length (metres) is done: floor that the robot was too far beside for counts as not swept; how many quarters.
    pub(super) fn settle(&mut self, axis: Axis, path_m: f32, sheet: &mut Sheet) -> u16 {
        let mut count = 0;
        for (index, point) in self.points.iter_mut().rev().enumerate() {
            let aside_m = f32::from(core::mem::take(&mut point.aside)) / FINE;
            if index as f32 * APART_M < path_m {
                count += sheet.miss(axis, point.place.at_m(), aside_m);
            }
        }
        count
    }

    /// The last point, metres.
    pub(super) fn last_m(&self) -> Option<[f32; 2]> {
        self.points.back().map(|point| point.place.at_m())
    }

    /// Forgets the last point.
    pub(super) fn drop_last(&mut self) {
        let _ = self.points.pop_back();
    }

    /// What was swept there counts no more; how many quarters.
    pub(super) fn undo(&mut self, sheet: &mut Sheet) -> u16 {
        let mut count = 0_u16;
        while let Some(point) = self.points.pop_back() {
            count = count.saturating_add(sheet.unsweep(point.place.at_m()));
        }
        self.since_m = f32::INFINITY;
        count
    }
}

#[cfg(test)]
mod tests {
    use slam_core::Pose;

    use super::*;

    /// Centre of a row of quarters, metres, and how far the next ones are.
    const ROW_M: f32 = 0.039;
    const NEXT_M: f32 = 0.078;

    /// A lane of 4 m on that row, at the end of which the pose is corrected across it by so much, metres.
    fn lane(correction_m: f32) -> (Sheet, u16) {
        let (mut trail, mut sheet) = (Trail::new(), Sheet::new());
        for step in 0..=400 {
            let at_m = [0.01 * step as f32, ROW_M];
            sheet.sweep(&Pose::new(at_m[0], at_m[1], 0.0));
            trail.step(at_m);
        }
        trail.correct(correction_m);
        let missed = trail.settle(Axis::X, 4.0, &mut sheet);
        assert_eq!(trail.settle(Axis::X, 4.0, &mut sheet), 0, "once");
        (sheet, missed)
    }

    #[test]
    fn beside_a_lane_that_was_elsewhere_floor_on_one_side_is_not_swept() {
        for (correction_m, left, right) in
            [(0.0, true, true), (0.03, true, true), (0.06, true, false), (-0.06, false, true)]
        {
            let (sheet, missed) = lane(correction_m);
            let is_swept = |x_m: f32, off_m: f32| sheet.swept.is_swept(sheet.quarter_at([x_m, ROW_M + off_m]));
            assert_eq!([is_swept(3.8, NEXT_M), is_swept(3.8, -NEXT_M)], [left, right], "{correction_m}");
            assert_eq!(missed > 0, !(left && right), "{correction_m}");
            assert!(is_swept(0.5, NEXT_M) && is_swept(0.5, -NEXT_M), "known before: {correction_m}");
        }
    }
}
