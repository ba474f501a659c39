//! Hits of readings that were older than they were taken for.

use slam_core::{Increment, Pose};

use super::drive::DRIVE;
use crate::diary::{Diary, Hit};
use crate::frame::Frame;
use crate::keyframe::OLDEST_S;

const STEP_S: f32 = 0.04;

/// The walls of a square room are so far from its middle, metres.
const WALL_M: f32 = 2.0;

/// The wall that a beam from there meets, and where.
fn meets([x, y]: [f32; 2], [along_x, along_y]: [f32; 2]) -> (u16, [f32; 2]) {
    let range_m = |at: f32, along: f32| (WALL_M - along.signum() * at) / along.abs();
    let ranges_m = [range_m(x, along_x), range_m(y, along_y)];
    let axis = usize::from(ranges_m[1] < ranges_m[0]);
    let is_far = [along_x, along_y][axis] > 0.0;
    (2 * axis as u16 + u16::from(is_far), [x + ranges_m[axis] * along_x, y + ranges_m[axis] * along_y])
}

/// What a robot with four sensors writes down on a round of turns and ways in a square room: its readings are so old, and taken
/// for as old as the diary is told.
fn written(truly_s: f32, taken_s: f32) -> Diary<64, 256, 8> {
    let mut diary = Diary::new(&DRIVE, Pose::ORIGIN);
    (diary.age_s, diary.late) = (taken_s, 0xf);
    diary.keyframes.iter_mut().for_each(|key| key.set_age(taken_s));
    let mut robot = Pose::ORIGIN;
    for step in 0..200 {
        let (speed, rate) = if step % 50 < 30 { (0.0, 1.0) } else { (0.3, 0.2) };
        let after = |time_s: f32| {
            let turn_rad = rate * time_s;
            let (s, c) = (0.5 * turn_rad).sin_cos();
            Pose::new(speed * time_s * c, speed * time_s * s, turn_rad)
        };
        let moved = after(STEP_S);
        robot = robot.compose(&moved);
        diary.travel(&Increment { forward_m: moved.x_m, left_m: moved.y_m, turn_rad: moved.theta_rad });
        diary.keyframes.last_mut().expect("the first").pass(STEP_S);
        if diary.is_due() {
            diary.begin_keyframe(&robot);
        }
        for sensor in 0..4 {
            let at = robot.compose(&after(-truly_s));
            let along = Frame::of(&at).turn([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][usize::from(sensor)]);
            let (wall, met_m) = meets([at.x_m, at.y_m], along);
            // The robot takes the reading to be from where it was as long ago as it takes it for.
            let seen_m = Frame::of(&at).seen(met_m);
            let end_m = Frame::of(&after(-taken_s)).point(seen_m);
            diary.hit(&Hit { from_m: [0.0; 2], end_m, variance_m2: 1e-4, alike: 1.0, sensor, wall: Some(wall) });
        }
    }
    diary
}

/// How far the means of groups are from their walls, metres: root mean square.
fn off_m(diary: &Diary<64, 256, 8>) -> f32 {
    let (mut sum_m2, mut count) = (0.0, 0.0);
    for (key, groups) in diary.sightings() {
        let frame = Frame::of(&key.pose);
        for group in groups {
            let off_m =
                frame.point(group.mean_m).map(|axis| (axis.abs() - WALL_M).abs()).into_iter().fold(f32::MAX, f32::min);
            sum_m2 += off_m * off_m;
            count += 1.0;
        }
    }
    (sum_m2 / count).sqrt()
}

#[test]
fn hits_follow_what_is_learned_of_the_age_of_readings() {
    for (truly_s, taken_s) in [(0.05, 0.03), (0.005, 0.0325), (-0.02, 0.0)] {
        let as_taken = off_m(&written(truly_s, taken_s));
        let mut diary = written(truly_s, taken_s);
        diary.age_s = truly_s;
        while diary.follow_age().is_some() {}
        let (moved, at_best) = (off_m(&diary), off_m(&written(truly_s, truly_s)));
        assert!(
            as_taken > 0.005 && moved < 0.4 * as_taken && at_best < 1e-5,
            "{as_taken} m, moved {moved}, at best {at_best}"
        );
    }
}

/// An age that no reading has does not keep a look back from ever beginning.
#[test]
fn hits_do_not_move_for_ever() {
    for age_s in [OLDEST_S, -OLDEST_S, f32::NAN] {
        let mut diary = written(0.0, 0.0);
        diary.age_s = age_s;
        let times = (0..64).take_while(|_| diary.follow_age().is_some()).count();
        assert!(times < 4, "{age_s} s: {times}");
    }
}

/// A robot that was carried did not move by itself.
#[test]
fn a_motion_that_was_not_sensed_moves_no_hits() {
    let mut diary = written(0.0, 0.0);
    let calibration = diary.calibration;
    let count = diary.keyframes.len();
    for i in 0..count - 1 {
        let next = diary.keyframes[i + 1].pose;
        diary.keyframes[i].part_from(&next, &calibration, [0.5, 0.5]);
    }
    let means = |diary: &Diary<64, 256, 8>| {
        diary.seen_from_first(count - 1).iter().map(|group| group.mean_m).collect::<std::vec::Vec<_>>()
    };
    let before = means(&diary);
    diary.age_s = 0.05;
    while diary.follow_age().is_some() {}
    assert_eq!(means(&diary), before);
}
