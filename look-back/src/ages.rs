//! How old the readings were for which hits were written down, and where these are by what is known of that since.
//!
//! A reading that is older than it was taken for saw the robot where it was a little before: the hits of a keyframe lie as far off as
//! the robot moved in that time, most of all where it turned. At a radian a second the 16 ms that an analogue reading's age is
//! not known to at first are a degree, and the first keyframes' directions are those of the map. The filter learns the age within
//! some metres; what was written down before follows.

use slam_core::{Pose, Slam};

use crate::diary::Diary;
use crate::frame::Frame;
use crate::group::Group;
use crate::keyframe::{Keyframe, OLDEST_S};

/// Hits stay where they are for an age that changed by less, seconds: a milliradian at a radian a second.
const CHANGED_S: f32 = 1e-3;

/// Multiply-adds that the move of a keyframe's hits takes, for itself and each group.
const MOVE_COST: u32 = 36;

/// Hits of so many keyframes are moved at a time.
const AT_A_TIME: usize = 32;

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// Begins with readings as old as the filter takes them for.
    pub(crate) fn begin_at_age<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &Slam<S, WALLS, O, ROWS>,
    ) {
        self.age_s = slam.latency().map_or(0.0, |(age_s, _)| age_s.clamp(-OLDEST_S, OLDEST_S));
        self.late = slam.late_sensors();
        self.keyframes.iter_mut().for_each(|key| key.set_age(self.age_s));
    }

    /// Takes in how old readings are by the filter, and that so much time has passed, seconds.
    pub(crate) fn pass<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &Slam<S, WALLS, O, ROWS>,
        time_s: f32,
    ) {
        let Some((age_s, _)) = slam.latency() else { return };
        self.age_s = age_s.clamp(-OLDEST_S, OLDEST_S);
        if let Some(last) = self.keyframes.last_mut() {
            last.pass(time_s);
        }
    }

    /// Moves hits of some keyframes to where they are by what is known now of how old their readings were: the multiply-adds that takes;
    /// none where all are there.
    pub(crate) fn follow_age(&mut self) -> Option<u32> {
        let Self { keyframes, groups, age_s, late, .. } = self;
        let (mut rest, mut before, mut times, mut cost) = (groups.as_mut_slice(), None, 0, 0);
        for key in keyframes {
            let (own, later) = rest.split_at_mut_checked(key.groups.into())?;
            rest = later;
            let by_s = *age_s - key.age_s();
            if by_s.abs() >= CHANGED_S && times < AT_A_TIME {
                key.set_age(*age_s);
                let frame = Frame::of(&moved(before.as_ref(), key, -by_s));
                for group in own.iter_mut().filter(|group| is_late(group, *late)) {
                    *group = group.moved(&frame);
                }
                times += 1;
                cost += MOVE_COST * (1 + own.len() as u32);
            }
            before = Some(*key);
        }
        (times > 0).then_some(cost)
    }
}

/// Whether it is its sensor's readings of which an age is known: one bit a sensor.
fn is_late(group: &Group, late: u16) -> bool {
    1u16.checked_shl(group.sensor().into()).is_some_and(|bit| late & bit != 0)
}

/// How the robot moves in so much time about a keyframe, in its frame: on average over the way to it and from it, for what is seen from it is
/// seen from the half of both that is nearer. Not at all where the odometry did not sense it.
fn moved(before: Option<&Keyframe>, key: &Keyframe, time_s: f32) -> Pose {
    let to = before.and_then(Keyframe::sensed).map(|(motion, of_s)| (from_its_end(&motion), of_s));
    let (mut sum, mut of_both_s) = (Pose::ORIGIN, 0.0);
    for (Pose { x_m, y_m, theta_rad }, of_s) in [to, key.sensed()].into_iter().flatten() {
        sum = Pose { x_m: sum.x_m + x_m, y_m: sum.y_m + y_m, theta_rad: sum.theta_rad + theta_rad };
        of_both_s += of_s;
    }
    let share = if of_both_s > 0.0 { time_s / of_both_s } else { 0.0 };
    Pose::new(share * sum.x_m, share * sum.y_m, share * sum.theta_rad)
}

/// A motion as it is seen from where it ends, whole turns included.
fn from_its_end(motion: &Pose) -> Pose {
    let [x_m, y_m] = Frame::of(motion).turn_back([motion.x_m, motion.y_m]);
    Pose { x_m, y_m, theta_rad: motion.theta_rad }
}
