//! Areas to clean: which of them it came to, and how it goes to what it has not seen of them.
//!
//! Where they are is known, and what lies between is not. Where nothing that was seen is left, the search takes what was not seen for
//! floor: the robot goes towards an area until something stands in its way, then another way, until it is there or none is left.

use heapless::Vec;
use slam_core::Pose;

use super::FloorJob;
use super::bounds::{AREAS, AreaKind, Bounds, encloses};
use super::sheet::QUARTER_M;
use super::swept::{CELLS, Quarter};
use super::wave::Aim;
use crate::pilot::memory::Cell;

const _: () = assert!(AREAS <= 8, "an area is a bit of a byte");

/// Cells of the picture, and those that areas are drawn into in one step: all of them every thirteen seconds.
const ALL: u16 = (CELLS * CELLS) as u16;
const MARKED: u16 = 20;
/// The brush reaches so far to each side, metres.
const BESIDE_M: f32 = 0.12;
/// Edge of the picture, metres, and how far to each side of its path beams that meet nothing show the floor: half a metre from the body. On a
/// path of `LOOK_M` they have shown all of it: so long it looks for an area, and again for the way home.
const EDGE_M: f32 = 2.0 * QUARTER_M * CELLS as f32;
const SEEN_M: f32 = 0.67;
const LOOK_M: f32 = EDGE_M * EDGE_M / (2.0 * SEEN_M);
/// A step in which it stands counts for so much path, metres: half of what it could have driven.
const STANDS_M: f32 = 0.006;
/// An area beyond the picture is looked for this near to where the picture ends, in cells: where the robot comes there the picture moves.
const TOWARDS: i16 = CELLS as i16 / 8 - 3;

/// What the job knows of the areas to clean.
#[derive(Clone, Debug)]
pub(super) struct Areas {
    /// The robot is where it need not clean.
    pub is_elsewhere: bool,
    /// The next cell of the picture that the areas are drawn into, row by row, and how many they were not drawn into at all.
    marked: u16,
    left: u16,
    /// There are areas to clean.
    is_any: bool,
    /// Those that the brush came to, a bit each in their order, and those that it did not.
    reached: u8,
    pub missed: u8,
    /// Searches take what was not seen for floor.
    pub dares: bool,
    /// Path that is left for that, metres.
    look_m: f32,
}

impl Areas {
    pub(super) const NONE: Self = Self {
        is_elsewhere: false,
        marked: 0,
        left: ALL,
        is_any: false,
        reached: 0,
        missed: 0,
        dares: false,
        look_m: LOOK_M,
    };

    /// Other cells came into the picture.
    pub(super) fn draw_anew(&mut self) {
        self.left = ALL;
    }

    /// Whether a search that found nothing is worth another one that dares.
    pub(super) fn may_dare(&self) -> bool {
        self.is_any && !self.dares && !self.is_spent()
    }

    /// Whether no path is left for searches that dare.
    pub(super) fn is_spent(&self) -> bool {
        self.look_m <= 0.0
    }

    /// A step over, in which the robot drove so far, metres.
    pub(super) fn drive(&mut self, step_m: f32) {
        self.look_m -= if self.dares { step_m.max(STANDS_M) } else { 0.0 };
    }

    /// The robot is where it dared to go: searches go by what was seen. Whether it dared.
    pub(super) fn settle(&mut self) -> bool {
        core::mem::take(&mut self.dares)
    }

    /// The floor is done: the way home may be looked for as long again.
    pub(super) fn turn_home(&mut self) {
        (self.dares, self.look_m) = (false, LOOK_M);
    }

    /// Begins a search: whether it dares.
    pub(super) fn begin_search(&mut self) -> bool {
        self.dares &= !self.is_spent();
        self.dares
    }
}

/// The bit of an area to clean.
fn bit(index: usize) -> u8 {
    1 << (index % AREAS)
}

/// The areas to clean that a point (metres) is in, a bit each.
fn areas_at(bounds: &Bounds, point_m: [f32; 2]) -> u8 {
    let here = bounds.areas(AreaKind::Clean).enumerate().filter(|(_, corners)| encloses(corners, point_m));
    here.fold(0, |areas, (index, _)| areas | bit(index))
}

/// The cell of the picture that is nearest to one outside, not too near its edge to be driven to.
pub(super) fn within_picture(cell: Cell) -> Cell {
    let last = CELLS as i16 - 3;
    Cell { col: cell.col.clamp(2, last), row: cell.row.clamp(2, last) }
}

impl<const S: usize> FloorJob<S> {
    /// Takes in where the robot is among the areas, and draws them into the next cells of the picture.
    pub(super) fn mind_areas(&mut self, pose: &Pose, bounds: &Bounds) {
        let all = bounds.areas(AreaKind::Clean).enumerate().fold(0, |all, (index, _)| all | bit(index));
        self.areas.is_elsewhere = !bounds.is_to_clean([pose.x_m, pose.y_m]);
        if bounds.is_empty() || self.is_over() {
            return;
        }
        let brush_m = [-BESIDE_M, 0.0, BESIDE_M].map(|left_m| pose.transform([0.0, left_m]));
        brush_m.iter().for_each(|at_m| self.areas.reached |= areas_at(bounds, *at_m));
        self.areas.is_any = all != 0;
        let missed = all & !self.areas.reached;
        if core::mem::replace(&mut self.areas.missed, missed) != missed {
            self.areas.draw_anew();
            self.areas.look_m = LOOK_M;
            self.retries = 0;
        }
        self.mark_areas(bounds);
    }

    /// Draws the areas into the next cells of the picture: blocked where it must not go, and left out there, since a search forgets what is
    /// blocked, and where it need not clean. Where the map moves them, what was left out is to be cleaned, and what was swept stays so.
    fn mark_areas(&mut self, bounds: &Bounds) {
        let origin = self.frame.origin();
        let (s, c) = slam_core::angle::sin_cos(origin.theta_rad);
        let on_map = |[x_m, y_m]: [f32; 2]| [origin.x_m + c * x_m - s * y_m, origin.y_m + s * x_m + c * y_m];
        let beyond = self.beyond(bounds);
        let cells = CELLS as u16;
        for _ in 0..MARKED {
            let cell = Cell { col: (self.areas.marked % cells) as i16, row: (self.areas.marked / cells) as i16 };
            self.areas.marked = (self.areas.marked + 1) % ALL;
            let quarter = |index: i16| Quarter { col: 2 * cell.col + index % 2, row: 2 * cell.row + index / 2 };
            let quarters_m = [0, 1, 2, 3].map(|index| on_map(self.sheet.centre_m(quarter(index))));
            let is_out = quarters_m.iter().any(|at_m| bounds.is_out(*at_m));
            let is_towards = beyond.iter().any(|beyond| cell.moves_to(*beyond) <= TOWARDS);
            // What an edge of an area goes through is to be cleaned, too.
            let is_to_clean = !is_out && quarters_m.iter().any(|at_m| bounds.is_to_clean(*at_m));
            let is_left = self.sheet.swept.left_in(cell) > 0;
            if is_out {
                self.sheet.picture.block(cell);
            }
            if is_to_clean && self.sheet.swept.is_left_out(cell) {
                self.sheet.picture.unblock(cell);
                self.sheet.swept.set(cell, false);
            } else if is_towards && !is_out {
                self.sheet.swept.set(cell, false);
            } else if !is_to_clean && is_left {
                self.sheet.swept.leave_out(cell);
            } else if is_to_clean && !is_left && self.areas.left > 0 && self.sheet.picture.is_free(cell) {
                // It was there before it knew of the areas.
                self.areas.reached |= areas_at(bounds, on_map(self.sheet.picture.centre_m(cell)));
            }
        }
        self.areas.left = self.areas.left.saturating_sub(MARKED);
    }

    /// Where the picture ends towards areas that it does not reach to, and that the robot did not come to: there it is to go first.
    fn beyond(&self, bounds: &Bounds) -> Vec<Cell, AREAS> {
        let back = self.frame.origin().inverse();
        let areas = bounds.areas(AreaKind::Clean).enumerate();
        let missed = areas.filter(|(index, _)| self.areas.missed & bit(*index) != 0);
        let places = missed.filter_map(|(_, corners)| corners.first()).map(|corner| back.transform(*corner));
        let cells = places.map(|[x_m, y_m]| self.sheet.picture.cell_at(x_m, y_m));
        cells.filter(|cell| *cell != within_picture(*cell)).map(within_picture).collect()
    }

    /// Whether a search has to wait until the areas, if there are any, are drawn into the whole picture: what it dares to go to is what they
    /// left.
    pub(super) fn waits_for_areas(&self, aim: Aim) -> bool {
        self.areas.dares && self.areas.is_any && aim == Aim::Floor && self.areas.left > 0
    }

    /// Something that was not seen before stands on the way through what was not seen.
    pub(super) fn sees_obstacle_on_way(&self) -> bool {
        let mut ahead = self.route.iter().rev().take(6);
        (self.areas.dares || self.sheet.border.leaves)
            && ahead.any(|cell| self.sheet.picture.is_obstacle(Cell::unpacked(*cell)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::FloorConfig;
    use super::super::wave::{Slice, Target};
    use super::*;
    use crate::rig::default_rig;

    fn job() -> FloorJob<8> {
        FloorJob::new(FloorConfig::default(), &default_rig())
    }

    /// A square with this lower corner, 2 m wide, is to be cleaned.
    fn square(x_m: f32, y_m: f32) -> Bounds {
        let mut bounds = Bounds::NONE;
        let corners = [[x_m, y_m], [x_m + 2.0, y_m], [x_m + 2.0, y_m + 2.0], [x_m, y_m + 2.0]];
        bounds.add(AreaKind::Clean, &corners).unwrap();
        bounds
    }

    /// Draws the areas into the whole picture of a robot that stands at its origin.
    fn draw(job: &mut FloorJob<8>, bounds: &Bounds) {
        (0..=ALL / MARKED).for_each(|_| job.mind_areas(&Pose::ORIGIN, bounds));
    }

    /// What a search from the origin finds, and the way there.
    fn search(job: &mut FloorJob<8>, dares: bool) -> Option<(Target, usize)> {
        let start = job.sheet.picture.cell_at(0.0, 0.0);
        job.wave.begin(start, 0, dares);
        loop {
            match job.wave.search(&mut job.sheet, Aim::Floor) {
                Slice::More => {}
                Slice::Found(target) => return Some((target, job.wave.route(&job.sheet, target).len())),
                Slice::Nothing => return None,
            }
        }
    }

    #[test]
    fn a_search_that_dares_goes_through_what_was_not_seen_and_round_what_was() {
        let mut job = job();
        draw(&mut job, &square(2.0, -1.0));
        assert_eq!(search(&mut job, false), None);
        let (target, straight) = search(&mut job, true).unwrap();
        let [x_m, _] = job.sheet.picture.centre_m(target.stand());
        assert!((1.9..2.2).contains(&x_m) && straight < 16, "{x_m} {straight}");
        // A wall of 4 m in front of it.
        for row in -13..=13 {
            job.sheet.picture.block(job.sheet.picture.cell_at(1.0, f32::from(row as i8) * 2.0 * QUARTER_M));
        }
        let (_, round) = search(&mut job, true).unwrap();
        assert!(round > straight + 5, "{round} {straight}");
    }

    #[test]
    fn an_area_beyond_the_picture_is_looked_for_where_that_ends() {
        let mut job = job();
        draw(&mut job, &square(9.0, 0.0));
        let (target, _) = search(&mut job, true).unwrap();
        let [x_m, y_m] = job.sheet.picture.centre_m(target.stand());
        assert!(x_m > 4.7 && y_m.abs() < 1.3, "{x_m} {y_m}");
        job.areas.dares = true;
        assert!(job.take_picture_along(&Pose::new(x_m, y_m, 0.0)), "the picture moves on");
    }

    #[test]
    fn an_area_is_reached_under_the_brush_or_where_it_was_swept_before() {
        let (mut job, here) = (job(), square(0.1, -1.0));
        job.mind_areas(&Pose::ORIGIN, &here);
        assert_eq!(job.areas.missed, 1, "the brush lies across the way");
        job.mind_areas(&Pose::new(0.0, 0.0, core::f32::consts::FRAC_PI_2), &here);
        assert_eq!(job.areas.missed, 0);

        let (mut job, there) = (self::job(), square(1.0, 0.0));
        let cell = job.sheet.picture.cell_at(2.0, 1.0);
        job.sheet.picture.stand_on(cell);
        job.sheet.swept.set(cell, true);
        draw(&mut job, &there);
        assert_eq!(job.areas.missed, 0);
    }

    #[test]
    fn areas_that_the_map_moves_are_drawn_where_they_are_and_what_was_swept_stays() {
        let mut job = job();
        let cell = |job: &FloorJob<8>, x_m: f32| job.sheet.picture.cell_at(x_m, 0.0);
        let [before, both, after] = [1.3, 2.0, 3.3].map(|x_m| cell(&job, x_m));
        draw(&mut job, &square(1.0, -1.0));
        assert_eq!([before, both, after].map(|cell| job.sheet.swept.left_in(cell)), [4, 4, 0]);
        job.sheet.swept.set(before, true);
        draw(&mut job, &square(1.6, -1.0));
        assert_eq!([before, both, after].map(|cell| job.sheet.swept.left_in(cell)), [0, 4, 4]);
        draw(&mut job, &square(1.0, -1.0));
        assert_eq!([before, both, after].map(|cell| job.sheet.swept.left_in(cell)), [0, 4, 0]);
    }

    #[test]
    fn it_dares_for_a_limited_time_and_only_where_there_are_areas() {
        let mut job = job();
        assert!(!job.areas.may_dare());
        draw(&mut job, &square(1.0, 1.0));
        assert!(job.areas.may_dare());
        job.areas.dares = true;
        assert!(job.areas.begin_search());
        (0..20_000).for_each(|_| job.areas.drive(0.0));
        assert!(!job.areas.begin_search() && !job.areas.may_dare());
        job.areas.turn_home();
        assert!(job.areas.may_dare(), "the way home is looked for anew");
    }

    #[test]
    fn one_that_dares_waits_for_areas_where_there_are_any() {
        let mut job = job();
        job.areas.dares = true;
        assert!(!job.waits_for_areas(Aim::Floor));
        job.mind_areas(&Pose::ORIGIN, &square(1.0, 1.0));
        assert!(job.waits_for_areas(Aim::Floor));
        draw(&mut job, &square(1.0, 1.0));
        assert!(!job.waits_for_areas(Aim::Floor));
    }
}
