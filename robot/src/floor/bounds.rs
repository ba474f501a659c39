//! What the user says of the floor: areas to stay out of, and areas to clean.
//!
//! The edge of an area to stay out of is driven by as a wall is: points along it stand among those that beams ended at, and
//! its cells are blocked in the picture.

use heapless::Vec;
use slam_core::Pose;

use super::FloorJob;
use crate::pilot::Senses;
use crate::traits::WheelSpeeds;

/// Most areas.
pub const AREAS: usize = 8;
/// Most corners of all areas together.
pub const CORNERS: usize = 48;

/// Points along an edge are so far apart, metres: as dense as beams make them beside a wall.
const SPACING_M: f32 = 0.025;
/// Edges farther from the robot's centre do not matter yet, metres.
const REACH_M: f32 = 0.35;
/// The points stand so far before the edge, metres: twice what the pose is off in a mapped home.
const MARGIN_M: f32 = 0.02;

/// What an area is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaKind {
    /// The robot stays out of it.
    KeepOut,
    /// It is to be cleaned; where there is such an area, nothing else is.
    Clean,
}

impl AreaKind {
    /// Every one; its place here is its number in a kept map.
    pub const ALL: [Self; 2] = [Self::KeepOut, Self::Clean];
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Area {
    kind: AreaKind,
    /// Its corners end before this one; there are fewer than 256.
    end: u8,
}

/// Areas to stay out of and to clean: polygons in the map frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounds {
    areas: Vec<Area, AREAS>,
    /// The corners of one area after those of the other, metres.
    corners: Vec<[f32; 2], CORNERS>,
}

/// There are more areas or corners than the robot can remember, or an area has less than three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadArea;

impl Bounds {
    /// No areas: the robot may go anywhere, and all floor is to be cleaned.
    pub const NONE: Self = Self { areas: Vec::new(), corners: Vec::new() };

    /// Adds an area: its corners in order, map frame, metres.
    ///
    /// # Errors
    /// It has less than three corners, or there is no room for it.
    pub fn add(&mut self, kind: AreaKind, corners: &[[f32; 2]]) -> Result<(), BadArea> {
        let end = self.corners.len() + corners.len();
        if corners.len() < 3 || end > CORNERS || self.areas.is_full() {
            return Err(BadArea);
        }
        self.corners.extend_from_slice(corners).map_err(|_| BadArea)?;
        self.areas.push(Area { kind, end: end as u8 }).map_err(|_| BadArea)
    }

    /// Adds a corner to the last area, or the first one of another area. Until an area has three it has no inside.
    ///
    /// # Errors
    /// There is no room for it.
    pub fn add_corner(&mut self, kind: AreaKind, is_first: bool, at_m: [f32; 2]) -> Result<(), BadArea> {
        if is_first {
            self.areas.push(Area { kind, end: self.corners.len() as u8 }).map_err(|_| BadArea)?;
        }
        let area = self.areas.last_mut().ok_or(BadArea)?;
        self.corners.push(at_m).map_err(|_| BadArea)?;
        area.end += 1;
        Ok(())
    }

    /// The corner of this number, of those that there are, is there, metres.
    pub fn move_corner(&mut self, index: u8, at_m: [f32; 2]) {
        if let Some(corner) = self.corners.get_mut(usize::from(index)) {
            *corner = at_m;
        }
    }

    /// The same areas in the frame whose origin is this pose.
    pub fn seen_from(&self, origin: &Pose) -> Self {
        let back = origin.inverse();
        let mut seen = self.clone();
        seen.corners.iter_mut().for_each(|corner| *corner = back.transform(*corner));
        seen
    }

    /// Whether there are no areas.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// The corners of each area of a kind, metres.
    pub fn areas(&self, kind: AreaKind) -> impl Iterator<Item = &[[f32; 2]]> {
        let begins = core::iter::once(0).chain(self.areas.iter().map(|area| area.end.into()));
        let all = self.areas.iter().zip(begins);
        all.filter(move |(area, _)| area.kind == kind)
            .filter_map(|(area, begin)| self.corners.get(begin..area.end.into()))
    }

    /// Whether a point (metres) is in an area to stay out of.
    pub fn is_out(&self, point_m: [f32; 2]) -> bool {
        self.areas(AreaKind::KeepOut).any(|corners| encloses(corners, point_m))
    }

    /// Whether a point (metres) is to be cleaned.
    pub fn is_to_clean(&self, point_m: [f32; 2]) -> bool {
        let mut areas = self.areas(AreaKind::Clean).peekable();
        areas.peek().is_none() || areas.any(|corners| encloses(corners, point_m))
    }

    /// Points along the edges near the robot, in its frame, metres. A robot within an area sees none of its edges: it may leave.
    fn points_from(&self, pose: &Pose) -> impl Iterator<Item = [f32; 2]> + '_ {
        let back = pose.inverse();
        let here_m = [pose.x_m, pose.y_m];
        let areas = self.areas(AreaKind::KeepOut).filter(move |corners| !encloses(corners, here_m));
        areas.flat_map(edges).flat_map(move |(a, b)| points_of(back.transform(a), back.transform(b)))
    }
}

/// The points of an edge (ends in the robot's frame, metres) that are within reach of its origin.
fn points_of(a: [f32; 2], b: [f32; 2]) -> impl Iterator<Item = [f32; 2]> {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let length_m = slam_core::pose::length(dx, dy).max(1e-6);
    let [ux, uy] = [dx / length_m, dy / length_m];
    let (foot_m, off_m) = (-(a[0] * ux + a[1] * uy), a[1] * ux - a[0] * uy);
    let half_m = float::sqrtf((REACH_M * REACH_M - off_m * off_m).max(0.0));
    let (from_m, to_m) = ((foot_m - half_m).max(0.0), (foot_m + half_m).min(length_m));
    let count = if from_m < to_m { ((to_m - from_m) / SPACING_M) as u16 + 1 } else { 0 };
    let before_m = MARGIN_M.min(off_m.abs()).copysign(off_m);
    (0..count).map(move |index| {
        let at_m = from_m + f32::from(index) * SPACING_M;
        [a[0] + at_m * ux + before_m * uy, a[1] + at_m * uy - before_m * ux]
    })
}

fn edges(corners: &[[f32; 2]]) -> impl Iterator<Item = ([f32; 2], [f32; 2])> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Whether a ray from the point along x crosses the closed line an odd number of times.
pub(super) fn encloses(corners: &[[f32; 2]], [x_m, y_m]: [f32; 2]) -> bool {
    let crossed = |&([ax, ay], [bx, by]): &([f32; 2], [f32; 2])| {
        (ay > y_m) != (by > y_m) && x_m < ax + (y_m - ay) / (by - ay) * (bx - ax)
    };
    edges(corners).filter(crossed).count() % 2 == 1
}

/// One in so many of the points along an edge is put up in a step.
const TURNS: usize = 4;
/// A point of an edge stands for so long, microseconds: some rounds of those turns.
const STANDS_US: u64 = 600_000;

impl<const S: usize> FloorJob<S> {
    /// The same as [`FloorJob::step`] for a robot that knows areas: in the map frame as it is now, none where it does not know
    /// where it is.
    pub fn step_within(&mut self, senses: &Senses<S>, bounds: &Bounds) -> WheelSpeeds {
        let Pose { x_m, y_m, theta_rad } = senses.pose;
        if !bounds.is_empty() && x_m.is_finite() && y_m.is_finite() && theta_rad.is_finite() {
            self.put_up_fences(senses, bounds);
        }
        self.mind_areas(&senses.pose, bounds);
        self.step(senses)
    }

    /// Lets the next points along the edges nearby stand where a beam's end would.
    fn put_up_fences(&mut self, senses: &Senses<S>, bounds: &Bounds) {
        let pose = self.frame.pose(&senses.pose);
        let until_us = senses.time_us.saturating_add(STANDS_US);
        for (index, at_m) in bounds.points_from(&senses.pose).enumerate() {
            if index % TURNS == usize::from(self.steps) % TURNS {
                self.near.add(pose.transform(at_m), [0.0; 2], until_us, &pose, senses.time_us);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 2]; 4] = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];

    #[test]
    fn a_point_is_in_or_out() {
        let mut bounds = Bounds::default();
        assert!(bounds.is_to_clean([0.0, 0.0]));
        bounds.add(AreaKind::KeepOut, &SQUARE).unwrap();
        bounds.add(AreaKind::Clean, &[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]).unwrap();
        assert!(bounds.is_out([1.5, 1.5]) && !bounds.is_out([0.5, 1.5]) && !bounds.is_out([1.5, 2.5]));
        assert!(bounds.is_to_clean([0.5, 0.5]) && !bounds.is_to_clean([3.0, 3.0]));
        let turned = bounds.seen_from(&Pose::new(0.0, 0.0, core::f32::consts::FRAC_PI_2));
        assert!(turned.is_out([1.5, -1.5]) && !turned.is_out([1.5, 1.5]));
    }

    #[test]
    fn areas_come_corner_by_corner() {
        let (mut whole, mut told) = (Bounds::default(), Bounds::default());
        for (kind, corners) in [(AreaKind::KeepOut, &SQUARE[..]), (AreaKind::Clean, &SQUARE[1..])] {
            whole.add(kind, corners).unwrap();
            for (index, at_m) in corners.iter().enumerate() {
                told.add_corner(kind, index == 0, *at_m).unwrap();
            }
        }
        assert_eq!(told, whole);
        assert_eq!(Bounds::default().add_corner(AreaKind::Clean, false, [0.0; 2]), Err(BadArea));
    }

    #[test]
    fn the_edge_nearby_is_a_row_of_points_and_one_within_sees_none() {
        let mut bounds = Bounds::default();
        bounds.add(AreaKind::KeepOut, &SQUARE).unwrap();
        let beside = Pose::new(1.5, 0.8, 0.0);
        let points: Vec<[f32; 2], 64> = bounds.points_from(&beside).collect();
        assert!(points.len() > 20, "{points:?}");
        assert!(
            points.iter().all(|[x, y]| (y - 0.18).abs() < 1e-5 && slam_core::pose::length(*x, *y) < REACH_M + 0.01)
        );
        assert!(points.windows(2).all(|pair| (pair[1][0] - pair[0][0] - SPACING_M).abs() < 1e-5));
        assert_eq!(bounds.points_from(&Pose::new(1.5, 0.5, 0.0)).count(), 0);
        assert_eq!(bounds.points_from(&Pose::new(1.5, 1.2, 0.0)).count(), 0);
    }

    #[test]
    fn what_is_too_much_is_refused_and_changes_nothing() {
        let mut bounds = Bounds::default();
        assert_eq!(bounds.add(AreaKind::Clean, &SQUARE[..2]), Err(BadArea));
        (0..AREAS).for_each(|_| bounds.add(AreaKind::KeepOut, &SQUARE).unwrap());
        let before = bounds.clone();
        assert_eq!(bounds.add(AreaKind::KeepOut, &SQUARE), Err(BadArea));
        assert_eq!(bounds, before);
        let mut corners = Bounds::default();
        corners.add(AreaKind::Clean, &[[0.0; 2]; CORNERS - 2]).unwrap();
        assert_eq!(corners.add(AreaKind::Clean, &SQUARE), Err(BadArea));
    }
}
