//! The motion models: the exact arc, its derivatives, and counters that wrap.

use super::numeric::{arc, derivative};
use super::oracle::{Matrix, sandwich};
use super::random::Random;
use crate::filter::ekf::{Ekf, storage};
use crate::geometry::angle::sin_cos;
use crate::motion::drive::{Drive, Way};
use crate::motion::step::{Factor, Factors, Step, step};
use crate::motion::travel::{Encoders, Travel};
use crate::{DriveModel, Increment, Motion, MotionSettings, Pose, SLIP_M2_PER_RAD, Slip, Ticks};

const TRACK_M: f64 = 0.235;
const WHEELS: DriveModel = DriveModel::Wheels {
    track_m: TRACK_M as f32,
    track_sigma: 0.01,
    metres_per_tick: 0.000_445,
    scale_sigma: 0.005,
    noise_m2_per_m: 1e-5,
};
const ODOMETRY: DriveModel = DriveModel::Odometry {
    scale_sigma: 0.05,
    noise_m2_per_m: 4e-4,
    noise_rad2_per_m: 2e-4,
    noise_rad2_per_rad: 1e-3,
    veer_sigma: 0.0,
};

/// States 4 to 6 are the factors.
fn factors(values: [f64; 3]) -> Factors {
    let factor = |i: usize| Factor { value: values[i] as f32, state: Some(4 + i) };
    Factors { first: factor(0), second: factor(1), third: factor(2) }
}

fn random_state(random: &mut Random) -> [f64; 6] {
    let mut factor = || f64::from(random.uniform(0.95, 1.05) as f32);
    let factors = [factor(), factor(), factor()];
    let mut place = || f64::from(random.uniform(-3.0, 3.0) as f32);
    [place(), place(), place(), factors[0], factors[1], factors[2]]
}

/// Checks pose, Jacobian and noise of one step against `model` of (x, y, theta, three factors), and against its
/// derivatives by two or three sources of noise.
fn assert_step(
    drive: &DriveModel,
    travel: &Travel,
    state: &[f64; 6],
    model: impl Fn(&[f64; 6]) -> [f64; 3],
    expected_noise: &Matrix,
) {
    let [x, y, theta, ..] = *state;
    let factors = factors([state[3], state[4], state[5]]);
    let made = step(drive, travel, &factors);
    let pose = made.applied_to(&Pose::new(x as f32, y as f32, theta as f32));
    let expected = model(state);
    assert!((f64::from(pose.x_m) - expected[0]).abs() < 2e-6, "{travel:?}");
    assert!((f64::from(pose.y_m) - expected[1]).abs() < 2e-6, "{travel:?}");
    assert!((f64::from(pose.theta_rad) - expected[2]).sin().abs() < 2e-6, "{travel:?}");
    let (jacobian, noise) = made.in_map(sin_cos(theta as f32), &factors);
    for (i, row) in jacobian.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            // State 3 is the grid direction, state 7 something else: no motion depends on them.
            let expected = match j {
                0..=2 => derivative(|s| model(s)[i], state, j),
                4..=6 => derivative(|s| model(s)[i], state, j - 1),
                _ => 0.0,
            };
            let tolerance = 2e-6 * (1.0 + expected.abs());
            assert!((f64::from(*entry) - expected).abs() < tolerance, "{i}, {j}: {entry} {expected} {travel:?}");
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            let scale = (expected_noise[i][i] * expected_noise[j][j]).sqrt() + 1e-12;
            let difference = f64::from(noise[i][j]) - expected_noise[i][j];
            assert!(difference.abs() < 1e-4 * scale + 1e-14, "noise {i}, {j} of {travel:?}: {difference} of {scale}");
        }
    }
}

#[test]
fn wheels_roll_on_the_exact_arc_and_so_do_the_derivatives() {
    let mut random = Random::new(1);
    for round in 0..1000 {
        let state = random_state(&mut random);
        // Up to 0.5 m/s at 10 Hz, each wheel on its own; turning on the spot; straight.
        let left = f64::from(random.uniform(-0.05, 0.05) as f32);
        let right = match round % 4 {
            0 => -left,
            1 => left,
            _ => f64::from(random.uniform(-0.05, 0.05) as f32),
        };
        let model = |s: &[f64; 6]| arc([s[0], s[1], s[2]], s[3] * left, s[4] * right, s[5] * f64::from(TRACK_M as f32));
        // Noise of each wheel's own travel, through the same arc.
        let rolled = [state[3] * left, state[4] * right];
        let after =
            |w: &[f64; 2]| arc([state[0], state[1], state[2]], w[0], w[1], state[5] * f64::from(TRACK_M as f32));
        let by_wheel: Matrix =
            (0..3).map(|i| (0..2).map(|w| derivative(|r| after(r)[i], &rolled, w)).collect()).collect();
        let wheel_noise = [[1e-5 * rolled[0].abs(), 0.0].into(), [0.0, 1e-5 * rolled[1].abs()].into()].into();
        let expected_noise = sandwich(&by_wheel, &wheel_noise);
        let travel = Travel::Wheels { left_m: left as f32, right_m: right as f32 };
        assert_step(&WHEELS, &travel, &state, model, &expected_noise);
    }
}

#[test]
fn a_quarter_circle_ends_where_a_quarter_circle_ends() {
    // Radius 1 m about a centre to the left, in steps of 1.5 degrees.
    let steps = 60.0;
    let turn = core::f64::consts::FRAC_PI_2 / steps;
    let travel = Travel::Wheels {
        left_m: ((1.0 - TRACK_M / 2.0) * turn) as f32,
        right_m: ((1.0 + TRACK_M / 2.0) * turn) as f32,
    };
    let made = step(&WHEELS, &travel, &factors([1.0; 3]));
    let end = (0..60).fold(Pose::default(), |pose, _| made.applied_to(&pose));
    assert!((end.x_m - 1.0).abs() < 1e-5 && (end.y_m - 1.0).abs() < 1e-5, "{end:?}");
    assert!((f64::from(end.theta_rad) - core::f64::consts::FRAC_PI_2).abs() < 1e-5);
    // Chords would fall short of it: the arc of one large step is exact too.
    let large =
        Travel::Wheels { left_m: ((1.0 - TRACK_M / 2.0) * 0.5) as f32, right_m: ((1.0 + TRACK_M / 2.0) * 0.5) as f32 };
    let end = step(&WHEELS, &large, &factors([1.0; 3])).applied_to(&Pose::default());
    assert!(
        (f64::from(end.x_m) - 0.5f64.sin()).abs() < 1e-5 && (f64::from(end.y_m) - (1.0 - 0.5f64.cos())).abs() < 1e-5
    );
}

#[test]
fn an_odometry_increment_moves_in_any_direction() {
    let mut random = Random::new(2);
    for _ in 0..1000 {
        let state = random_state(&mut random);
        let mut draw = |most: f64| f64::from(random.uniform(-most, most) as f32);
        let (forward, left, turn) = (draw(0.1), draw(0.1), draw(0.2));
        let model = |s: &[f64; 6]| {
            let (sin, cos) = s[2].sin_cos();
            let (f, l) = (s[3] * forward, s[3] * left);
            // The veer turns the path as it goes on, by half of its turn on average.
            let veered = s[5] * f;
            let (f, l) = (f - 0.5 * veered * l, l + 0.5 * veered * f);
            [s[0] + cos * f - sin * l, s[1] + sin * f + cos * l, s[2] + s[4] * turn + veered]
        };
        let path = state[3] * forward.hypot(left);
        let heading = 2e-4 * path + 1e-3 * (state[4] * turn).abs();
        let expected_noise =
            [[4e-4 * path, 0.0, 0.0].into(), [0.0, 4e-4 * path, 0.0].into(), [0.0, 0.0, heading].into()].into();
        let increment = Increment { forward_m: forward as f32, left_m: left as f32, turn_rad: turn as f32 };
        assert_step(&ODOMETRY, &Travel::Body(increment), &state, model, &expected_noise);
    }
}

fn ticks(left: i32, right: i32) -> Motion {
    Motion::Ticks(Ticks { left, right })
}

/// Travel of both wheels, in ticks.
fn travelled(encoders: &mut Encoders, left: i32, right: i32) -> Option<(f32, f32)> {
    match encoders.travel(&WHEELS, &ticks(left, right), 0.04)? {
        Travel::Wheels { left_m, right_m } => {
            Some((libm::roundf(left_m / 0.000_445), libm::roundf(right_m / 0.000_445)))
        }
        Travel::Body(_) => None,
    }
}

#[test]
fn counters_wrap_without_a_jump() {
    let mut encoders = Encoders::default();
    assert_eq!(travelled(&mut encoders, i32::MAX - 2, i32::MIN + 2), Some((0.0, 0.0)), "the first is the reference");
    assert_eq!(travelled(&mut encoders, i32::MIN + 7, i32::MAX - 7), Some((10.0, -10.0)));
    assert_eq!(travelled(&mut encoders, i32::MAX, i32::MIN), Some((-8.0, 8.0)));
}

#[test]
fn a_jump_that_no_robot_makes_is_no_motion_and_the_next_step_starts_after_it() {
    let mut encoders = Encoders::default();
    let _ = travelled(&mut encoders, 0, 0);
    assert_eq!(travelled(&mut encoders, 1_000_000, 3), None);
    assert_eq!(travelled(&mut encoders, 1_000_004, 6), Some((4.0, 3.0)));
    assert_eq!(travelled(&mut encoders, i32::MIN, 6), None);
}

/// Wheels count on where no row comes for a while.
#[test]
fn more_than_half_a_turn_in_a_pause_is_a_motion_and_ends_where_its_arc_does() {
    let turned = |turn_rad: f64, dt_s: f32| {
        let half = libm::round(0.5 * TRACK_M * turn_rad / 0.000_445) as i32;
        let mut encoders = Encoders::default();
        let _ = encoders.travel(&WHEELS, &ticks(0, 0), dt_s);
        encoders.travel(&WHEELS, &ticks(500 - half, 500 + half), dt_s)
    };
    assert!(turned(4.5, 0.04).is_none() && turned(4.5, 3.0).is_some() && turned(7.0, 3.0).is_none());
    for turn_rad in [-6.0, -2.9, 0.5, 2.7, 2.9, 4.5] {
        let travel = turned(turn_rad, 3.0).expect("a motion");
        let Increment { forward_m, left_m, turn_rad } = step(&WHEELS, &travel, &factors([1.0; 3])).increment;
        let (turn, distance) = (f64::from(turn_rad), 500.0 * 0.000_445);
        let off_m = f64::from(forward_m) - distance * turn.sin() / turn;
        let aside_m = f64::from(left_m) - distance * (1.0 - turn.cos()) / turn;
        assert!(off_m.abs() < 1e-5 && aside_m.abs() < 1e-5, "{turn_rad}: {off_m} {aside_m}");
    }
}

/// In a second without its motion a robot goes as far as it can.
#[test]
fn the_longer_a_motion_was_lost_the_less_is_known_of_where_it_led() {
    let lost = |dt_s: f32| Step { path_m: 0.01, ..Step::default() }.lost(dt_s).lost_by().expect("it is lost");
    assert_eq!(lost(0.04), lost(0.2));
    assert!(lost(0.04)[0] < 0.02 && lost(0.04)[1] < 0.03, "{:?}", lost(0.04));
    assert!((0.4..0.5).contains(&lost(1.0)[0]) && (0.7..0.9).contains(&lost(1.0)[1]), "{:?}", lost(1.0));
    assert!(lost(60.0)[1] < 2.0, "a heading that is any");
    let driven = step(&WHEELS, &Travel::Wheels { left_m: 0.01, right_m: 0.02 }, &factors([1.0; 3]));
    assert!(driven.lost_by().is_none() && Step::STILL.lost_by().is_none());
}

#[test]
fn a_motion_of_the_wrong_kind_or_not_a_number_is_no_motion() {
    let increment = |forward_m, left_m, turn_rad| Motion::Increment(Increment { forward_m, left_m, turn_rad });
    let mut encoders = Encoders::default();
    assert!(encoders.travel(&WHEELS, &increment(0.0, 0.0, 0.0), 0.04).is_none());
    assert!(encoders.travel(&ODOMETRY, &ticks(0, 0), 0.04).is_none());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e9] {
        assert!(encoders.travel(&ODOMETRY, &increment(bad, 0.0, 0.0), 0.04).is_none(), "forward {bad}");
        assert!(encoders.travel(&ODOMETRY, &increment(0.0, bad, 0.0), 0.04).is_none(), "left {bad}");
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(encoders.travel(&ODOMETRY, &increment(0.0, 0.0, bad), 0.04).is_none(), "turn {bad}");
    }
    assert!(encoders.travel(&ODOMETRY, &increment(0.1, -0.1, 0.3), 0.04).is_some());
}

#[test]
fn a_slipping_robot_knows_less_of_its_place_and_as_much_of_its_heading() {
    let factors = Factors::nominal(&ODOMETRY);
    let travel = Travel::Body(Increment { forward_m: 0.03, left_m: 0.04, turn_rad: -0.2 });
    let stated = step(&ODOMETRY, &travel, &factors);
    let slipping = stated.slipping();
    // Four times 4e-4 m^2 per metre, and 2e-3 m^2 per radian.
    let expected = 4.0 * 4e-4 * 0.05 + 2e-3 * 0.2;
    for axis in 0..2 {
        assert!((slipping.noise[axis][axis] - expected).abs() < 1e-9, "{}", slipping.noise[axis][axis]);
    }
    assert_eq!((slipping.noise[2], slipping.noise[0][1]), (stated.noise[2], 0.0));
    assert_eq!(Step::default().slipping().noise, [[0.0; 3]; 3], "who stands still slips nowhere");
}

/// A robot that turns and drives in one step, in any order and any shares, ends where the arc ends, give or take what the step
/// allows for it: NEES of the place across the chord.
#[test]
fn an_arc_over_a_long_step_is_a_guess() {
    let known = Factor { value: 1.0, state: None };
    let factors = Factors { first: known, second: known, third: known };
    let mut random = Random::new(3);
    let mut nees = [0.0; 2];
    const DRIVES: usize = 400;
    for _ in 0..DRIVES {
        let (forward_m, turn_rad) = (random.uniform(0.05, 0.3), random.uniform(-1.5, 1.5));
        // Some of the turn, the drive, and the rest of the turn.
        let before = turn_rad * random.uniform(-0.2, 1.2).clamp(0.0, 1.0);
        let end = [forward_m * before.cos(), forward_m * before.sin()];
        let half_m = 0.5 * TRACK_M * turn_rad;
        let travel = Travel::Wheels { left_m: (forward_m - half_m) as f32, right_m: (forward_m + half_m) as f32 };
        let chord = 0.5 * turn_rad;
        let across = [-chord.sin(), chord.cos()];
        for (nees, dt_s) in nees.iter_mut().zip([0.1, 10.0]) {
            let step = step(&WHEELS, &travel, &factors).unsteady(dt_s);
            let error = [f64::from(step.increment.forward_m) - end[0], f64::from(step.increment.left_m) - end[1]];
            let off_m = error[0] * across[0] + error[1] * across[1];
            let variance: f64 = (0..2)
                .flat_map(|i| (0..2).map(move |j| (i, j)))
                .map(|(i, j)| across[i] * f64::from(step.noise[i][j]) * across[j])
                .sum();
            *nees += off_m * off_m / variance / DRIVES as f64;
        }
    }
    assert!(nees[0] > 100.0, "steps of a steady robot are arcs, and have a drive's noise only: {}", nees[0]);
    assert!((0.3..1.0).contains(&nees[1]), "{}", nees[1]);
}

/// A robot of two wheels that turns on the spot slides off it, as any other does.
#[test]
fn wheels_slide_in_turns_where_floors_are_real() {
    let rig = DriveModel::Wheels {
        track_m: 0.4,
        track_sigma: 0.0,
        metres_per_tick: 1e-4,
        scale_sigma: 0.0,
        noise_m2_per_m: 1e-4,
    };
    let ekf = Ekf::<{ storage(8) }>::EMPTY;
    let travel = Travel::Wheels { left_m: -0.02, right_m: 0.02 };
    let noise_m2 = |slip: Slip| {
        let settings = MotionSettings { slip, ..MotionSettings::default() };
        let mut drive = Drive::START;
        drive.advance(&rig, &settings, Some(travel), Way { is_reversed: false, is_held: false, noise: 1.0 }, 0.1, &ekf);
        [drive.step.noise[0][0], drive.step.noise[1][1]]
    };
    for (with, without) in noise_m2(Slip::OfFloors).into_iter().zip(noise_m2(Slip::Stated)) {
        assert!(with >= 0.1 * SLIP_M2_PER_RAD && without < 1e-5, "{with} and {without} m^2");
    }
}

/// What wheels slip beyond what the rig states is in the way since a new line's points were seen, too.
#[test]
fn dead_reckoning_is_as_noisy_as_wheels_turned_out_to_be() {
    let ekf = Ekf::<{ storage(8) }>::EMPTY;
    let travel = Travel::Wheels { left_m: 0.02, right_m: 0.02 };
    let variances = |noise: f32| {
        let mut drive = Drive::START;
        let way = Way { is_reversed: false, is_held: false, noise };
        drive.advance(&WHEELS, &MotionSettings::default(), Some(travel), way, 0.1, &ekf);
        [drive.dead_reckoning.position_variance, drive.dead_reckoning.heading_variance]
    };
    for (slipping, stated) in variances(4.0).into_iter().zip(variances(1.0)) {
        assert!(stated > 0.0 && (slipping / stated - 4.0).abs() < 1e-5, "{slipping} and {stated}");
    }
}

#[test]
fn a_motion_of_the_body_is_that_of_its_wheels_and_back() {
    let [wheels, odometry] = [
        Travel::Wheels { left_m: 0.03, right_m: -0.01 },
        Travel::Body(Increment { forward_m: 0.03, left_m: -0.01, turn_rad: 0.02 }),
    ];
    for (travel, drive) in [(wheels, WHEELS), (odometry, ODOMETRY)] {
        let motion = travel.of_body(&drive);
        assert!((motion.forward_m - travel.forward_m()).abs() < 1e-7 && motion.turn_rad == travel.turn_rad(&drive));
        let back = Travel::from_body(motion, &drive).of_body(&drive);
        assert!((back.forward_m - motion.forward_m).abs() < 1e-7 && (back.turn_rad - motion.turn_rad).abs() < 1e-6);
        assert_eq!(back.left_m, motion.left_m);
    }
}
