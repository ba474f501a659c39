//! The diary: what a drive's path and walls are placed from, in bounded memory.

use heapless::Vec;
use slam_core::angle::wrap;
use slam_core::hand_over::MOST_GAINS;
use slam_core::pose::length;
use slam_core::{Calibration, DriveModel, Increment, Pose};

use crate::frame::{Frame, Moving, relative};
use crate::gains::Gains;
use crate::group::Group;
use crate::keyframe::Keyframe;
use crate::names::{NAMES, Name};
use crate::rows::Odometry;
use crate::turned::Turned;
use crate::wall::Wall;

/// Hits of one sensor that no wall explains and that are so near to each other are on one thing, metres.
const ONE_THING_M: f32 = 0.5;

/// A wall that fewer hits met is noise, and makes room.
pub(crate) const FEWEST: u32 = 10;

/// One hit: a reading that ended on something.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Where its beam began, in the robot's frame, metres.
    pub from_m: [f32; 2],
    /// Where it ended by what the sensor reported, in the robot's frame, metres.
    pub end_m: [f32; 2],
    /// Variance of that along the beam, m^2.
    pub variance_m2: f32,
    /// Of so many hits that say the same it is one.
    pub alike: f32,
    /// The sensor.
    pub sensor: u8,
    /// Identifier of the wall that the filter used it for.
    pub wall: Option<u16>,
}

/// What a full diary lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Keyframes that were made one with the one before them.
    pub thinned: u32,
    /// Hits for which there was no room.
    pub hits: u32,
    /// Hits on a wall for which there was no room; they were kept as on none.
    pub walls: u32,
}

/// Keyframes, groups of hits and walls of a drive, at most K, G and W of them.
///
/// When keyframes or groups are full, the two neighbouring keyframes with the shortest path between them become one, of those
/// that a look back has placed: their groups are put together as these poses lie to each other. So a drive of any length
/// fits, the longer the coarser, and nothing old has to be kept as a dense matrix, which at 64 walls would take 37 KiB more.
/// Groups on no wall make room first, as long as they are more than a quarter.
#[derive(Clone, Debug)]
pub struct Diary<const K: usize, const G: usize, const W: usize> {
    pub(crate) keyframes: Vec<Keyframe, K>,
    /// In the order of their keyframes.
    pub(crate) groups: Vec<Group, G>,
    /// So many at their end are the next keyframe's, and in the last one's frame until that begins.
    pub(crate) ahead: u16,
    /// The robot is past the middle of the way to that.
    is_ahead: bool,
    pub(crate) walls: [Option<Wall>; W],
    pub(crate) names: Vec<Name, NAMES>,
    /// Where among the names that of the last wall is that a sensor saw, where it still is there.
    pub(crate) seen: [u8; MOST_GAINS],
    /// Where among those of the last keyframe the group is that the last hit of a sensor went to, where it still is there.
    last_groups: [u8; MOST_GAINS],
    /// What each sensor read last, metres.
    pub(crate) ranges_m: [f32; MOST_GAINS],
    pub(crate) calibration: Calibration,
    pub(crate) gains: Gains,
    /// Direction of the grid, radians.
    pub(crate) alpha_rad: Option<f32>,
    /// Number of the filter's wall that is asked next how it stands to the grid.
    pub(crate) asked: u8,
    pub(crate) turned: Turned,
    pub(crate) odometry: Odometry,
    /// The robot in the last keyframe's frame, by the odometry as it is calibrated at present.
    pub(crate) robot: Moving,
    /// The filter's pose at the last keyframe.
    pub(crate) filter: Pose,
    /// Which keyframe of the drive was the last that a look back placed.
    pub(crate) placed: u32,
    /// Changes with whatever a look back that has begun may not survive.
    pub(crate) revision: u32,
    pub(crate) losses: Losses,
    /// How old readings are by the filter, seconds, and of which sensors, a bit each.
    pub(crate) age_s: f32,
    pub(crate) late: u16,
}

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// Not begun. Every byte is zero, so that a static of it costs no flash.
    pub const IDLE: Self = Self {
        keyframes: Vec::new(),
        groups: Vec::new(),
        ahead: 0,
        is_ahead: false,
        walls: [Some(Wall::NEW); W],
        names: Vec::new(),
        seen: [0; MOST_GAINS],
        last_groups: [0; MOST_GAINS],
        ranges_m: [0.0; MOST_GAINS],
        calibration: Calibration { distance: 0.0, turn: 0.0, veer_rad_per_m: 0.0 },
        gains: Gains::NONE,
        alpha_rad: None,
        asked: 0,
        turned: Turned::NOT,
        odometry: Odometry::NONE,
        robot: Moving::NONE,
        filter: Pose::ORIGIN,
        placed: 0,
        revision: 0,
        losses: Losses { thinned: 0, hits: 0, walls: 0 },
        age_s: 0.0,
        late: 0,
    };

    /// A diary of a drive that begins at this pose of the filter, of a robot whose sensors' gains are known.
    pub fn new(drive: &DriveModel, start: Pose) -> Self {
        let mut diary = Self::IDLE;
        diary.begin(drive, Gains::KNOWN, start);
        diary
    }

    /// Begins, or begins anew, in place.
    pub(crate) fn begin(&mut self, drive: &DriveModel, gains: Gains, start: Pose) {
        const { assert!(K >= 4 && G <= u16::MAX as usize && W < u8::MAX as usize && W >= 1) };
        self.keyframes.clear();
        // There is room for four.
        let _ = self.keyframes.push(Keyframe::at(0, start));
        self.groups.clear();
        (self.ahead, self.is_ahead) = (0, false);
        self.walls.fill(None);
        self.names.clear();
        self.calibration = Calibration::EXACT;
        self.gains = gains;
        self.alpha_rad = None;
        self.asked = 0;
        self.turned = Turned::NOT;
        self.ranges_m = [0.0; MOST_GAINS];
        self.odometry = Odometry::of(drive);
        (self.robot, self.filter) = (Moving::ORIGIN, start);
        self.placed = 0;
        self.revision = self.revision.wrapping_add(1);
        self.losses = Losses::default();
        (self.age_s, self.late) = (0.0, 0);
    }

    /// The filter's pose is the diary's from now on: what the diary found was taken over.
    pub(crate) fn follow_filter(&mut self) {
        if let Some(last) = self.keyframes.last() {
            self.filter = last.pose;
        }
    }

    /// The robot moved by so much, as the odometry sensed it.
    pub fn travel(&mut self, moved: &Increment) {
        let Some(last) = self.keyframes.last_mut() else { return };
        let path_m = length(moved.forward_m, moved.left_m);
        let Calibration { distance, turn, veer_rad_per_m } = self.calibration;
        let turned = turn * (moved.turn_rad + veer_rad_per_m * path_m);
        last.motion = last.motion.compose(&Pose::new(moved.forward_m, moved.left_m, moved.turn_rad));
        self.robot.go_on([distance * moved.forward_m, distance * moved.left_m], turned);
        last.path_m += path_m;
        last.turning_rad += moved.turn_rad.abs();
        self.is_ahead = last.is_past(0.5);
    }

    /// Whether it is time for a keyframe.
    pub fn is_due(&self) -> bool {
        self.keyframes.last().is_some_and(|last| last.is_past(1.0))
    }

    /// Begins a keyframe where the robot is; `filter` is the filter's pose there. Only its motion since the last one counts.
    pub fn begin_keyframe(&mut self, filter: &Pose) {
        if self.keyframes.is_full() {
            self.thin();
        }
        let Some(last) = self.keyframes.last() else { return };
        let pose = last.pose.compose(&relative(&self.filter, filter));
        let mut next = Keyframe { groups: self.ahead, ..Keyframe::at(last.serial.wrapping_add(1), pose) };
        next.set_age(self.age_s);
        if self.keyframes.push(next).is_ok() {
            let ahead = usize::from(core::mem::take(&mut self.ahead));
            let (before, there) = (self.groups.len().saturating_sub(ahead), Frame::of(&self.robot.pose().inverse()));
            self.groups.iter_mut().skip(before).for_each(|group| *group = group.moved(&there));
            self.filter = *filter;
            self.robot = Moving::ORIGIN;
            self.is_ahead = false;
        }
    }

    /// Takes the filter's direction of the grid, unless the diary has its own by now.
    pub fn grid(&mut self, alpha_rad: f32) {
        let Some(last) = self.keyframes.last() else { return };
        let turned = last.pose.theta_rad - self.filter.theta_rad;
        self.alpha_rad.get_or_insert(wrap(alpha_rad + turned));
    }

    /// Writes a hit down. One that is no number is passed over.
    pub fn hit(&mut self, hit: &Hit) {
        let Hit { from_m, end_m, variance_m2, alike, sensor, wall } = *hit;
        let [from_m, end_m] = [from_m, end_m].map(|point_m| self.robot.point(point_m));
        let weight = 1.0 / (alike * variance_m2);
        // A sum with something that is no number is none.
        let is_number = (from_m[0] + from_m[1] + end_m[0] + end_m[1] + weight).is_finite();
        if !(is_number && weight > 0.0 && alike >= 1.0) {
            return;
        }
        let mut one = Group::of(from_m, end_m, weight, alike, sensor);
        let wall = wall.and_then(|id| self.wall_seen_by(sensor, id));
        one.set_wall(wall);
        if let Some(wall) = wall.and_then(|wall| self.walls.get_mut(wall)?.as_mut()) {
            wall.hits = wall.hits.saturating_add(1);
        }
        self.put(&one);
    }

    /// Puts a hit to its group of the last keyframe, or past the middle of the way to the next one of that: where hits are seen from
    /// is then known, on average over both sides, to a twelfth of the odometry's variance between two keyframes.
    /// On a wall it is mostly the group that its sensor's last hit went to.
    fn put(&mut self, one: &Group) {
        let sensor = usize::from(one.sensor());
        let last = self.last_groups.get(sensor).map_or(0, |place| usize::from(*place));
        let Self { keyframes, groups, gains, ahead, .. } = self;
        let count = if self.is_ahead { *ahead } else { keyframes.last().map_or(0, |last| last.groups) };
        let before = groups.len().saturating_sub(count.into());
        let open = groups.get_mut(before..).unwrap_or_default();
        let place = if one.wall().is_none() {
            open.iter().position(|group| group.is_like(one) && is_near(group, one))
        } else if open.get(last).is_some_and(|group| group.is_like(one)) {
            Some(last)
        } else {
            open.iter().position(|group| group.is_on_wall_of(one) && gains.go_together(group, one))
        };
        let Some(place) = place else { return self.open_group(*one) };
        if let Some(group) = open.get_mut(place) {
            if group.sensor() == one.sensor() { group.add(one) } else { group.take_in(*one, gains) }
        }
        if let (Some(last), Ok(place)) = (self.last_groups.get_mut(sensor), u8::try_from(place)) {
            *last = place;
        }
    }

    fn open_group(&mut self, group: Group) {
        while self.groups.is_full() && (self.drop_fewest() || self.thin()) {}
        if self.groups.push(group).is_err() {
            self.losses.hits = self.losses.hits.saturating_add(u32::from(group.hits));
        } else if let Some(count) = self.open_groups() {
            *count += 1;
        }
    }

    /// How many groups, at their end, hits may go to: those of the nearer keyframe.
    fn open_groups(&mut self) -> Option<&mut u16> {
        if self.is_ahead { Some(&mut self.ahead) } else { self.keyframes.last_mut().map(|last| &mut last.groups) }
    }

    /// Forgets what is to be seen from the next keyframe.
    pub(crate) fn drop_ahead(&mut self) {
        self.groups.truncate(self.groups.len().saturating_sub(core::mem::take(&mut self.ahead).into()));
    }

    /// What was seen from the first so many keyframes.
    pub(crate) fn seen_from_first(&self, keyframes: usize) -> &[Group] {
        let count = self.keyframes.iter().take(keyframes).map(|key| usize::from(key.groups)).sum();
        self.groups.get(..count).unwrap_or(&self.groups)
    }

    /// Each keyframe with what was seen from it.
    pub(crate) fn sightings(&self) -> impl Iterator<Item = (&Keyframe, &[Group])> {
        let mut rest = self.groups.as_slice();
        self.keyframes.iter().map(move |key| {
            let (own, later) = rest.split_at_checked(key.groups.into()).unwrap_or((rest, &[]));
            rest = later;
            (key, own)
        })
    }

    /// The keyframes in the order of the drive: which one of all that were begun each is, and its pose as it is placed at present.
    pub fn keyframes(&self) -> impl ExactSizeIterator<Item = (u32, Pose)> + '_ {
        self.keyframes.iter().map(|key| (key.serial, key.pose))
    }

    /// Which one of all that were begun the last keyframe is.
    pub fn newest(&self) -> u32 {
        self.keyframes.last().map_or(0, |key| key.serial)
    }

    /// Where the robot is: the last keyframe's pose and the odometry since.
    pub fn robot(&self) -> Pose {
        self.keyframes.last().map_or(Pose::ORIGIN, |last| last.pose.compose(&self.robot.pose()))
    }

    /// The walls whose line is known.
    pub fn walls(&self) -> impl Iterator<Item = (usize, &Wall)> + '_ {
        let known = self.walls.iter().enumerate().filter_map(|(i, wall)| Some((i, wall.as_ref()?)));
        known.filter(|(_, wall)| wall.is_placed)
    }

    /// Groups of hits at present.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The odometry's calibration.
    pub fn calibration(&self) -> Calibration {
        self.calibration
    }

    /// Direction of the grid, radians; none before the filter had one.
    pub fn alpha_rad(&self) -> Option<f32> {
        self.alpha_rad
    }

    /// What was lost because something was full.
    pub fn losses(&self) -> Losses {
        self.losses
    }
}

/// Whether hits that no wall explains may be on one thing.
fn is_near(group: &Group, one: &Group) -> bool {
    let near = |axis: usize| (group.mean_m[axis] - one.mean_m[axis]).abs() < ONE_THING_M;
    near(0) && near(1)
}
