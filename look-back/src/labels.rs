//! Which wall each group is on.

use crate::chance::likelier_same;
use crate::diary::Diary;
use crate::frame::Frame;
use crate::group::{Group, Offset};
use crate::survey::{Cursor, SIGMAS, faces, through_m};

/// A group that is on a wall stays on it so far beyond its ends, metres; one that is on none comes onto it only so far inside them.
const BEYOND_M: f32 = 0.125;

/// Where a pose is beside a wall is known to this at best, 1-sigma, metres: what a look back leaves of drift and of what walls are not flat.
const PLACED_M: f32 = 0.03;

/// Multiply-adds of a group and one wall.
const COST: u32 = 40;

/// Gives groups to walls anew, group by group.
#[derive(Clone, Copy, Debug)]
pub struct Labels<const W: usize> {
    cursor: Cursor,
    /// Hits that ended on each wall, and that went through it.
    on: [u32; W],
    through: [u32; W],
    /// Hits that are another wall's than before.
    pub changed: u32,
}

impl<const W: usize> Labels<W> {
    /// Before the first group.
    pub const NEW: Self = Self { cursor: Cursor::START, on: [0; W], through: [0; W], changed: 0 };

    /// Gives the next group to the wall that it ended on, whatever the filter took it for: of those within three sigma the
    /// nearest. The cost in multiply-adds; none past the last group.
    pub fn take<const K: usize, const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> Option<u32> {
        let (index, frame) = self.cursor.next(diary)?;
        let found = self.nearest(diary, index, &frame);
        let group = diary.groups.get_mut(index)?;
        if group.wall() != found {
            self.changed += u32::from(group.hits);
            group.set_wall(found);
        }
        if let Some(on) = found.and_then(|wall| self.on.get_mut(wall)) {
            *on += u32::from(group.hits);
        }
        Some(COST * diary.walls.len() as u32)
    }

    fn nearest<const K: usize, const G: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        index: usize,
        frame: &Frame,
    ) -> Option<usize> {
        let group = diary.gains.correct(diary.groups.get(index)?);
        let (from_m, mean_m) = (frame.point(group.from_m), frame.point(group.mean_m));
        // Near an end a group that nothing gave to a wall yet may be the other face of a corner.
        let beyond_m = if group.wall().is_some() { BEYOND_M } else { -BEYOND_M };
        let mut nearest: Option<(usize, f32)> = None;
        for (i, wall) in diary.walls.iter().enumerate() {
            let Some(wall) = wall.as_ref().filter(|wall| wall.is_seen()) else { continue };
            let line = wall.line();
            if !faces(from_m, mean_m, &line) {
                continue;
            }
            let offset = group.offset(frame, &line);
            let is_along = (wall.lo_m - beyond_m..=wall.hi_m + beyond_m).contains(&offset.along_m);
            let is_nearer = offset.square < nearest.map_or(SIGMAS * SIGMAS, |(_, square)| square);
            if is_along && is_nearer && (group.wall().is_some() || is_likely(&group, &offset)) {
                nearest = Some((i, offset.square));
            }
            let far_m = SIGMAS * float::sqrtf(group.variance());
            let is_within = |along_m: f32| (wall.lo_m..=wall.hi_m).contains(&along_m);
            if group.is_stretch()
                && offset.behind_m > far_m
                && through_m(from_m, mean_m, &line).is_some_and(is_within)
                && let Some(through) = self.through.get_mut(i)
            {
                *through += u32::from(group.hits);
            }
        }
        nearest.map(|(wall, _)| wall)
    }

    /// A wall that more hits went through than ended on is not there: its groups are on none.
    pub fn finish<const K: usize, const G: usize>(&self, diary: &mut Diary<K, G, W>) {
        for group in &mut diary.groups {
            let Some(wall) = group.wall() else { continue };
            let is_there = self.on.get(wall) >= self.through.get(wall);
            if !is_there {
                group.set_wall(None);
            }
        }
    }
}

/// Whether a group that was on none is likelier on a wall than on something else beside it, by each of its hits and by all together. Where
/// hits are decimetres wide, what stands before a wall would be on it, and draw it and the poses along: by up to 45 degrees within a few metres.
fn is_likely(group: &Group, offset: &Offset) -> bool {
    let mean_m2 = 1.0 / group.weight + PLACED_M * PLACED_M;
    offset.square < likelier_same(group.variance())
        && offset.behind_m * offset.behind_m < mean_m2 * likelier_same(mean_m2)
}
