//! The pilot by itself, without a home around it.

use super::*;
use crate::wild::Wild;

fn senses(time_us: u64, pose: Pose, ranges_m: [Option<f32>; 8], contacts: Contacts) -> Senses<8> {
    Senses { time_us, pose, ranges_m, contacts, condition: Condition::default() }
}

fn pilot() -> Pilot<8> {
    let sensor = |bearing_rad| slam_core::RangeSensor {
        mount: slam_core::Mount { x_m: 0.0, y_m: 0.0, bearing_rad },
        min_m: 0.15,
        max_m: 1.5,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: slam_core::RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
    };
    let drive = slam_core::DriveModel::Wheels {
        track_m: 0.235,
        track_sigma: 0.0,
        metres_per_tick: 0.000_445,
        scale_sigma: 0.0,
        noise_m2_per_m: 0.0,
    };
    let sensors = (0..8).map(|i| sensor(i as f32 * core::f32::consts::FRAC_PI_4)).collect();
    Pilot::new(PilotConfig::default(), &Rig { drive, adc: None, sensors })
}

#[test]
fn a_bump_leads_to_backing_off_and_turning_away_from_it() {
    for (bump_left, sign) in [(true, -1.0), (false, 1.0)] {
        let mut pilot = pilot();
        let bump = Contacts { bump_left, bump_right: !bump_left, ..Contacts::default() };
        let back = pilot.step(&senses(0, Pose::default(), [None; 8], bump));
        assert_eq!(pilot.activity(), Activity::BackingOff);
        assert!(back.left_mps < 0.0 && back.right_mps < 0.0);
        pilot.step(&senses(2_000_000, Pose::default(), [None; 8], Contacts::default()));
        let turn = pilot.step(&senses(2_040_000, Pose::default(), [None; 8], Contacts::default()));
        assert_eq!(pilot.activity(), Activity::TurningAway);
        assert!((turn.right_mps - turn.left_mps) * sign > 0.0);
    }
}

#[test]
fn a_bumper_that_is_jammed_stops_it_until_it_is_freed() {
    let mut pilot = pilot();
    let jammed = Contacts { bump_left: true, ..Contacts::default() };
    let mut drive = |seconds: core::ops::Range<u64>, contacts: Contacts| {
        let mut moved = false;
        for step in 25 * seconds.start..25 * seconds.end {
            let speeds = pilot.step(&senses(40_000 * step, Pose::default(), [Some(1.0); 8], contacts));
            moved |= speeds != WheelSpeeds::STOP;
        }
        (pilot.activity() == Activity::Stuck, moved)
    };
    assert_eq!(drive(0..5, jammed), (false, true), "it backs off and turns away");
    assert!(drive(5..20, jammed).0);
    assert_eq!(drive(20..200, jammed), (true, false));
    assert_eq!(drive(200..201, Contacts::default()), (false, true));
}

#[test]
fn it_never_drives_on_towards_something_just_ahead() {
    let mut pilot = pilot();
    for step in 0..200 {
        let mut ranges_m = [Some(1.0); 8];
        ranges_m[0] = Some(0.2);
        let speeds = pilot.step(&senses(step * 40_000, Pose::default(), ranges_m, Contacts::default()));
        assert!(speeds.left_mps + speeds.right_mps < 0.01, "{step}: {speeds:?}");
    }
}

#[test]
fn whatever_it_is_told_the_speeds_are_finite_and_limited() {
    let mut pilot = pilot();
    let mut wild = Wild::new();
    for _ in 0..20_000 {
        let (pose, ranges_m, contacts) = (wild.pose(), wild.ranges(), wild.contacts());
        let speeds = pilot.step(&senses(u64::from(wild.bits()), pose, ranges_m, contacts));
        for speed_mps in [speeds.left_mps, speeds.right_mps] {
            assert!(speed_mps.abs() <= 0.25 + 0.5 * 0.235 * 0.8 + 1e-6, "{speeds:?}");
        }
    }
}

#[test]
fn the_pilot_of_the_robot_fits_in_8_kib() {
    assert!(size_of::<Pilot<8>>() <= 8192, "{}", size_of::<Pilot<8>>());
    assert!(size_of::<Pilot<16>>() <= 8192, "{}", size_of::<Pilot<16>>());
}

#[test]
fn a_robot_that_cannot_get_away_says_so_stands_and_tries_again() {
    let mut pilot = pilot();
    let mut step = 0;
    let mut drive = |pilot: &mut Pilot<8>, seconds: u64| {
        let mut moving = 0;
        for _ in 0..25 * seconds {
            step += 1;
            // Walls all around, a hand's breadth from the body.
            let speeds = pilot.step(&senses(step * 40_000, Pose::default(), [Some(0.25); 8], Contacts::default()));
            moving += u32::from(speeds != WheelSpeeds::STOP);
        }
        moving
    };
    drive(&mut pilot, 60);
    assert_eq!(pilot.activity(), Activity::Stuck);
    assert!(pilot.rounds() <= 20, "{} rounds", pilot.rounds());
    let tries = [(); 5].map(|()| drive(&mut pilot, 60));
    assert!(tries.iter().all(|moving| *moving < 25 * 30), "{tries:?}");
    assert!(tries.iter().any(|moving| *moving > 0), "it never tries again: {tries:?}");
}

#[test]
fn the_end_of_time_is_a_time() {
    let mut pilot = pilot();
    for left in (0..100).rev() {
        let speeds =
            pilot.step(&senses(u64::MAX - left * 40_000, Pose::default(), [Some(1.0); 8], Contacts::default()));
        assert!(speeds.left_mps.is_finite());
    }
}

/// In somebody's hands nothing is touched for good.
#[test]
fn a_robot_that_was_carried_about_explores_where_it_is_set_down() {
    let mut pilot = pilot();
    let lifted = Contacts { lifted: true, ..Contacts::default() };
    let mut drive = |steps: core::ops::Range<u64>, contacts| {
        steps
            .map(|step| pilot.step(&senses(step * 40_000, Pose::default(), [Some(1.0); 8], contacts)))
            .any(|speeds| speeds.is_forward())
    };
    drive(0..50, Contacts::default());
    drive(50..800, lifted);
    assert!(drive(800..900, Contacts::default()));
}
