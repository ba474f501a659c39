//! Where the robot was, in a memory that lasts over a reset: after it the robot expects itself there in its kept map.
//!
//! It is a record [in turn](crate::in_turn) with the one before, which says:
//!
//! | bytes | what they are |
//! |---|---|
//! | 4 | check sum of the kept map in whose frame the pose is |
//! | 12 | x, y, theta |
//! | 8 | variance of its place along each axis, of its heading |

use slam_core::kept::LastPose;
use slam_core::{Health, Pose, Slam};

use crate::in_turn::InTurn;
use crate::traits::LastingMemory;

const RECORDS: InTurn = InTurn::new(*b"POS\x01", 24);

/// Bytes of a memory that the last pose is written in.
pub const POSE_RECORD_BYTES: usize = 2 * RECORDS.len;

/// A robot that turned or moved more than this in a step does not stand, metres and radians: more than an encoder that rests on an edge shows.
const MOVES_M: f32 = 1e-3;
const MOVES_RAD: f32 = 5e-3;

/// How far a robot rolls on when its power goes, metres. Soft wheels and gears that they turn backwards slow it down by a twentieth of its weight at
/// least, 0.5 m/s^2, and it drives at 0.3 m/s at most.
pub const COASTS_M: f32 = 0.1;
/// The same of its turn, radians: at 1.2 rad/s a wheel goes 0.14 m/s and rolls on for 2 cm, of a track of 0.235 m.
pub const COASTS_RAD: f32 = 0.2;

/// Where the robot is if its power goes now; none where its estimator is not sure of that.
pub fn last_pose<const S: usize, const W: usize, const B: usize, const ROWS: usize>(
    slam: &Slam<S, W, B, ROWS>,
) -> Option<LastPose> {
    let is_sure = slam.health() == Health::Well && !slam.is_about_to_forget();
    let moved = slam.last_motion();
    let moves = moved.x_m.abs() + moved.y_m.abs() > MOVES_M || moved.theta_rad.abs() > MOVES_RAD;
    let [coasts_m, coasts_rad] = if moves { [COASTS_M, COASTS_RAD] } else { [0.0; 2] };
    let variance = |i: usize| slam.state_covariance(i, i);
    let last = LastPose {
        pose: slam.pose(),
        place_m2: 0.5 * (variance(0) + variance(1)) + coasts_m * coasts_m,
        heading_rad2: variance(2) + coasts_rad * coasts_rad,
    };
    Some(last).filter(|last| is_sure && is_possible(last))
}

/// What is in the memory that the last pose is written in.
#[derive(Clone, Debug, Default)]
pub struct PoseNotes {
    /// Number of the record that comes next; none before the memory was looked at.
    next: Option<u32>,
    /// There is a whole one.
    is_there: bool,
}

impl PoseNotes {
    /// Number of the record that comes next.
    fn open(&mut self, memory: &impl LastingMemory) -> u32 {
        *self.next.get_or_insert_with(|| {
            let found = RECORDS.newest(memory);
            self.is_there = found.is_some();
            found.map_or(0, |number| number.wrapping_add(1))
        })
    }

    /// Writes down a pose in the kept map of this number.
    pub fn write(&mut self, last: &LastPose, map: u32, memory: &mut impl LastingMemory) {
        let number = self.open(memory);
        let LastPose { pose: Pose { x_m, y_m, theta_rad }, place_m2, heading_rad2 } = *last;
        let numbers = [x_m, y_m, theta_rad, place_m2, heading_rad2].map(f32::to_le_bytes);
        RECORDS.write(number, [map.to_le_bytes()].into_iter().chain(numbers).flatten(), memory);
        (self.next, self.is_there) = (Some(number.wrapping_add(1)), true);
    }

    /// No pose is known any more.
    pub fn wipe(&mut self, memory: &mut impl LastingMemory) {
        let next = self.open(memory);
        if core::mem::take(&mut self.is_there) {
            RECORDS.wipe(next.wrapping_sub(1), memory);
        }
    }
}

/// The pose that was written last, if it is in the kept map of this number.
pub fn read_last_pose(map: u32, memory: &impl LastingMemory) -> Option<LastPose> {
    let mut said = RECORDS.said(RECORDS.newest(memory)?, memory);
    let mut word = || [0_u8; 4].map(|_| said.next().unwrap_or(0));
    let is_own = word() == map.to_le_bytes();
    let [x_m, y_m, theta_rad, place_m2, heading_rad2] = [(); 5].map(|()| f32::from_le_bytes(word()));
    let last = LastPose { pose: Pose { x_m, y_m, theta_rad }, place_m2, heading_rad2 };
    Some(last).filter(|last| is_own && is_possible(last))
}

fn is_possible(last: &LastPose) -> bool {
    let LastPose { pose: Pose { x_m, y_m, theta_rad }, place_m2, heading_rad2 } = *last;
    [x_m, y_m, theta_rad].iter().all(|value| value.is_finite())
        && [place_m2, heading_rad2].iter().all(|variance| variance.is_finite() && *variance >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_turn::Failing;

    extern crate std;
    use std::vec::Vec;

    const MAP: u32 = 7;

    fn at(x_m: f32) -> LastPose {
        LastPose { pose: Pose::new(x_m, -2.0, 0.5), place_m2: 1e-4, heading_rad2: 1e-3 }
    }

    #[test]
    fn the_last_pose_is_read_back_in_its_own_map_only() {
        let (mut memory, mut notes) = ([0xA5; POSE_RECORD_BYTES], PoseNotes::default());
        assert_eq!(read_last_pose(MAP, &memory), None, "a memory that was never written");
        for x_m in [1.0, 2.0, 3.0] {
            notes.write(&at(x_m), MAP, &mut memory);
            assert_eq!(read_last_pose(MAP, &memory), Some(at(x_m)));
        }
        assert_eq!(read_last_pose(MAP + 1, &memory), None);
        notes.wipe(&mut memory);
        assert_eq!(read_last_pose(MAP, &memory), None);
        notes.write(&LastPose { place_m2: f32::NAN, ..at(1.0) }, MAP, &mut memory);
        assert_eq!(read_last_pose(MAP, &memory), None, "a variance that is no number");
    }

    #[test]
    fn a_cut_anywhere_leaves_the_pose_before_or_the_new_one() {
        let (mut memory, mut notes) = ([0; POSE_RECORD_BYTES], PoseNotes::default());
        notes.write(&at(1.0), MAP, &mut memory);
        notes.write(&at(2.0), MAP, &mut memory);
        let cut = |left: usize, change: &dyn Fn(&mut PoseNotes, &mut Failing<POSE_RECORD_BYTES>)| {
            let mut failing = Failing { memory, left };
            change(&mut notes.clone(), &mut failing);
            read_last_pose(MAP, &failing.memory)
        };
        let found: Vec<_> =
            (0..=RECORDS.len).map(|left| cut(left, &|notes, memory| notes.write(&at(3.0), MAP, memory))).collect();
        assert!(found[..RECORDS.len].iter().all(|last| *last == Some(at(2.0))), "{found:?}");
        assert_eq!(found[RECORDS.len], Some(at(3.0)));
        let wiped: Vec<_> = (0..=8).map(|left| cut(left, &|notes, memory| notes.wipe(memory))).collect();
        assert!(wiped.iter().all(|last| last.is_none_or(|last| last == at(2.0))), "{wiped:?}");
        assert!(wiped[0].is_some() && wiped[8].is_none());
    }

    #[test]
    fn a_damaged_record_does_not_count_and_the_one_before_does() {
        let (mut memory, mut notes) = ([0; POSE_RECORD_BYTES], PoseNotes::default());
        notes.write(&at(1.0), MAP, &mut memory);
        notes.write(&at(2.0), MAP, &mut memory);
        let newer = RECORDS.at(RECORDS.newest(&memory).expect("two are there"));
        for place in newer..newer + RECORDS.len {
            let mut damaged = memory;
            damaged[place] ^= 0x10;
            assert_eq!(read_last_pose(MAP, &damaged), Some(at(1.0)), "byte {place}");
        }
    }
}
