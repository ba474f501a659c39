//! What is seen of each wall at present.

use crate::diary::{Diary, FEWEST};
use crate::frame::{Frame, dot};
use crate::group::{Group, Offset};
use crate::wall::{Line, Wall};

/// Hits on a wall are within so many sigmas of it.
pub const SIGMAS: f32 = 3.0;

/// Least cosine of the incidence at which a wall is seen: 80 degrees.
const LEAST_COS: f32 = 0.17;

/// Goes through a diary's groups, one by one.
#[derive(Clone, Copy, Debug)]
pub struct Cursor {
    key: usize,
    group: usize,
    /// The first group that is another keyframe's.
    end: usize,
}

impl Cursor {
    /// Before the first group.
    pub const START: Self = Self { key: 0, group: 0, end: 0 };

    /// The next group and its keyframe's pose; none past the last.
    pub fn next<const K: usize, const G: usize, const W: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
    ) -> Option<(usize, Frame)> {
        while self.group >= self.end {
            self.end += usize::from(diary.keyframes.get(self.key)?.groups);
            self.key += 1;
        }
        let key = diary.keyframes.get(self.key.checked_sub(1)?)?;
        self.group += 1;
        Some((self.group - 1, Frame::of(&key.pose)))
    }
}

/// Forgets what was seen of each wall.
pub fn begin<const W: usize>(walls: &mut [Option<Wall>; W]) {
    for wall in walls.iter_mut().flatten().filter(|wall| wall.is_placed) {
        (wall.lo_m, wall.hi_m, wall.hits) = (f32::INFINITY, f32::NEG_INFINITY, 0);
    }
}

/// Takes in one group; one that is not where its wall is does not count.
pub fn take<const W: usize>(walls: &mut [Option<Wall>; W], group: &Group, frame: &Frame) {
    let Some(wall) = group.wall().and_then(|wall| walls.get_mut(wall)?.as_mut()) else { return };
    let offset = group.offset(frame, &wall.line());
    if wall.is_placed && is_on(group, &offset) {
        let reach_m = group.reach_m(&offset);
        wall.lo_m = wall.lo_m.min(offset.along_m - reach_m);
        wall.hi_m = wall.hi_m.max(offset.along_m + reach_m);
        wall.hits = wall.hits.saturating_add(group.hits.into());
    }
}

/// Whether a group that is a wall's lies on it: of hits that say the same, all err alike.
pub fn is_on(group: &Group, offset: &Offset) -> bool {
    offset.square < SIGMAS * SIGMAS * f32::from(group.hits) / group.independent
}

impl Wall {
    /// Whether enough of it was seen.
    pub(crate) fn is_seen(&self) -> bool {
        self.is_placed && self.hits >= FEWEST
    }
}

/// Whether a group's beams ran towards the side of a line that is seen, on average.
pub fn faces(from_m: [f32; 2], mean_m: [f32; 2], line: &Line) -> bool {
    let way = [mean_m[0] - from_m[0], mean_m[1] - from_m[1]];
    dot(line.normal, way) > LEAST_COS * slam_core::pose::length(way[0], way[1])
}

/// Where along a line a group's mean beam went through it, metres; none where it ended before it or began behind it.
pub fn through_m(from_m: [f32; 2], mean_m: [f32; 2], line: &Line) -> Option<f32> {
    let behind = |at: [f32; 2]| dot(line.normal, at) - line.rho_m;
    let (begin, end) = (behind(from_m), behind(mean_m));
    if begin >= 0.0 || end <= 0.0 {
        return None;
    }
    let along = |at: [f32; 2]| dot(line.tangent(), at);
    Some(along(from_m) + begin / (begin - end) * (along(mean_m) - along(from_m)))
}
