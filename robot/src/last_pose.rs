//! Where the robot was, in a memory that lasts over a reset: after it the robot expects itself there in its kept map.
//!
//! There are two records, of which the whole one with the higher number counts; the other one is written next. So whatever is cut off in
//! the middle leaves the pose before or the new one.
//!
//! | bytes | what they are |
//! |---|---|
//! | 4 | magic and version |
//! | 4 | number of the record |
//! | 4 | check sum of the kept map in whose frame the pose is |
//! | 12 | x, y, theta |
//! | 8 | variance of its place along each axis, of its heading |
//! | 4 | CRC-32 (ISO-HDLC) of all bytes before |

use slam_core::kept::LastPose;
use slam_core::{Health, Pose, Slam};

use crate::floor::{CRC, put};
use crate::traits::LastingMemory;

/// What a record begins with; the last one is the format's version.
const MAGIC: [u8; 4] = *b"POS\x01";
const WORDS: usize = 8;
const RECORD: usize = 4 * (WORDS + 1);

/// Bytes of a memory that the last pose is written in.
pub const POSE_RECORD_BYTES: usize = 2 * RECORD;

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

/// Writes down a pose in the kept map of this number.
pub fn write_last_pose(last: &LastPose, map: u32, memory: &mut impl LastingMemory) {
    let (number, at) = newest(memory).map_or((0, 0), |(number, at)| (number.wrapping_add(1), RECORD - at));
    let LastPose { pose: Pose { x_m, y_m, theta_rad }, place_m2, heading_rad2 } = *last;
    let numbers = [x_m, y_m, theta_rad, place_m2, heading_rad2].map(f32::to_le_bytes);
    let words = [MAGIC, number.to_le_bytes(), map.to_le_bytes()].into_iter().chain(numbers);
    let mut sum = CRC.digest();
    put(memory, at, words.flatten().inspect(|byte| sum.update(&[*byte])));
    put(memory, at + 4 * WORDS, sum.finalize().to_le_bytes());
}

/// No pose is known any more.
pub fn wipe_last_pose(memory: &mut impl LastingMemory) {
    // The older one first, which must not count where the other one is gone.
    let newer = newest(memory).map_or(0, |(_, at)| at);
    [RECORD - newer, newer].into_iter().for_each(|at| put(memory, at, [0; MAGIC.len()]));
}

/// The pose that was written last, if it is in the kept map of this number.
pub fn read_last_pose(map: u32, memory: &impl LastingMemory) -> Option<LastPose> {
    let (_, at) = newest(memory)?;
    let number = |word: usize| f32::from_le_bytes(word_of(memory, at, word));
    let pose = Pose { x_m: number(3), y_m: number(4), theta_rad: number(5) };
    let last = LastPose { pose, place_m2: number(6), heading_rad2: number(7) };
    Some(last).filter(|last| word_of(memory, at, 2) == map.to_le_bytes() && is_possible(last))
}

fn is_possible(last: &LastPose) -> bool {
    let LastPose { pose: Pose { x_m, y_m, theta_rad }, place_m2, heading_rad2 } = *last;
    [x_m, y_m, theta_rad].iter().all(|value| value.is_finite())
        && [place_m2, heading_rad2].iter().all(|variance| variance.is_finite() && *variance >= 0.0)
}

fn word_of(memory: &impl LastingMemory, at: usize, word: usize) -> [u8; 4] {
    [0, 1, 2, 3].map(|byte| memory.read(at + 4 * word + byte))
}

/// Number and place of the newest whole record.
fn newest(memory: &impl LastingMemory) -> Option<(u32, usize)> {
    let number_of = |at: usize| {
        let mut sum = CRC.digest();
        (at..at + 4 * WORDS).for_each(|place| sum.update(&[memory.read(place)]));
        let is_whole = word_of(memory, at, 0) == MAGIC && word_of(memory, at, WORDS) == sum.finalize().to_le_bytes();
        is_whole.then(|| (u32::from_le_bytes(word_of(memory, at, 1)), at))
    };
    [0, RECORD].into_iter().filter_map(number_of).max_by_key(|(number, _)| *number)
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    const MAP: u32 = 7;

    fn at(x_m: f32) -> LastPose {
        LastPose { pose: Pose::new(x_m, -2.0, 0.5), place_m2: 1e-4, heading_rad2: 1e-3 }
    }

    #[test]
    fn the_last_pose_is_read_back_in_its_own_map_only() {
        let mut memory = [0xA5; POSE_RECORD_BYTES];
        assert_eq!(read_last_pose(MAP, &memory), None, "a memory that was never written");
        for x_m in [1.0, 2.0, 3.0] {
            write_last_pose(&at(x_m), MAP, &mut memory);
            assert_eq!(read_last_pose(MAP, &memory), Some(at(x_m)));
        }
        assert_eq!(read_last_pose(MAP + 1, &memory), None);
        wipe_last_pose(&mut memory);
        assert_eq!(read_last_pose(MAP, &memory), None);
        write_last_pose(&LastPose { place_m2: f32::NAN, ..at(1.0) }, MAP, &mut memory);
        assert_eq!(read_last_pose(MAP, &memory), None, "a variance that is no number");
    }

    /// A memory whose power fails after so many bytes.
    struct Failing {
        memory: [u8; POSE_RECORD_BYTES],
        left: usize,
    }

    impl LastingMemory for Failing {
        fn read(&self, place: usize) -> u8 {
            self.memory.read(place)
        }

        fn write(&mut self, place: usize, byte: u8) {
            if self.left > 0 {
                self.left -= 1;
                self.memory.write(place, byte);
            }
        }
    }

    #[test]
    fn a_cut_anywhere_leaves_the_pose_before_or_the_new_one() {
        let mut memory = [0; POSE_RECORD_BYTES];
        write_last_pose(&at(1.0), MAP, &mut memory);
        write_last_pose(&at(2.0), MAP, &mut memory);
        let cut = |left: usize, change: &dyn Fn(&mut Failing)| {
            let mut failing = Failing { memory, left };
            change(&mut failing);
            read_last_pose(MAP, &failing.memory)
        };
        let found: Vec<_> =
            (0..=RECORD).map(|left| cut(left, &|memory| write_last_pose(&at(3.0), MAP, memory))).collect();
        assert!(found[..RECORD].iter().all(|last| *last == Some(at(2.0))), "{found:?}");
        assert_eq!(found[RECORD], Some(at(3.0)));
        let wiped: Vec<_> = (0..=2 * MAGIC.len()).map(|left| cut(left, &|memory| wipe_last_pose(memory))).collect();
        assert!(wiped.iter().all(|last| last.is_none_or(|last| last == at(2.0))), "{wiped:?}");
        assert!(wiped[0].is_some() && wiped[2 * MAGIC.len()].is_none());
    }

    #[test]
    fn a_damaged_record_does_not_count_and_the_one_before_does() {
        let mut memory = [0; POSE_RECORD_BYTES];
        write_last_pose(&at(1.0), MAP, &mut memory);
        write_last_pose(&at(2.0), MAP, &mut memory);
        let (_, newer) = newest(&memory).expect("two are there");
        for place in newer..newer + RECORD {
            let mut damaged = memory;
            damaged[place] ^= 0x10;
            assert_eq!(read_last_pose(MAP, &damaged), Some(at(1.0)), "byte {place}");
        }
    }
}
