//! What speaks against the estimate, and what becomes of the estimator then.

use std::boxed::Box;
use std::vec::Vec;

use super::runs::{Truth, rig};
use crate::filter::layout::THETA;
use crate::health::HealthMonitor;
use crate::{Health, Outcome, RangeInput, Refusal, RobotSlam, Sample};

const FITS: Outcome = fits(1);
const IS_OFF: Outcome = hidden(2);

const fn fits(wall: u16) -> Outcome {
    Outcome::Updated { wall, innovation_m: 0.0, variance_m2: 1e-4, noise_m2: 1e-4 }
}

/// Something is seen before the wall.
const fn hidden(wall: u16) -> Outcome {
    Outcome::Gated { wall, innovation_m: -0.5, variance_m2: 1e-4 }
}

/// Something is seen behind it.
const fn passed(wall: u16) -> Outcome {
    Outcome::Gated { wall, innovation_m: 0.5, variance_m2: 1e-4 }
}

/// A step each centimetre from one path length to another; the first cause for a new map, with the path then. Beams meet other places all
/// the time.
fn drive(monitor: &mut HealthMonitor, path_cm: core::ops::Range<u32>, readings: &[Outcome]) -> Option<(u32, Health)> {
    drive_by(monitor, path_cm, readings, u32::MAX)
}

/// The same of a robot that comes by where it was once in so many centimetres.
fn drive_by(
    monitor: &mut HealthMonitor,
    path_cm: core::ops::Range<u32>,
    readings: &[Outcome],
    lap_cm: u32,
) -> Option<(u32, Health)> {
    for cm in path_cm {
        let path_m = cm as f32 * 0.01;
        let along_m = (cm % lap_cm) as f32 * 0.01;
        readings.iter().for_each(|outcome| monitor.note(outcome, path_m, Some(along_m)));
        if let Some(cause) = monitor.judge(path_m, 0.01, Some(1e-4), true) {
            return Some((cm, cause));
        }
        monitor.follow(NEXT);
    }
    None
}

/// Walls from this identifier on are not drawn yet.
const NEXT: u16 = 20;

/// Of a robot in a map that was there before.
fn in_map() -> HealthMonitor {
    let mut monitor = HealthMonitor::NEW;
    monitor.begin_map(NEXT);
    monitor
}

#[test]
fn readings_against_the_map_for_metres_are_no_chance() {
    let off = [FITS, IS_OFF, passed(3), hidden(4), passed(5)];
    let mut monitor = in_map();
    assert_eq!(drive(&mut monitor, 0..2000, &[FITS, fits(2), fits(3), fits(4)]), None);
    assert_eq!(drive(&mut monitor, 2000..2100, &off), None);
    assert_eq!(monitor.health(), Health::Well);
    let (cm, cause) = drive(&mut monitor, 2100..3000, &off).expect("contradicted");
    assert_eq!(cause, Health::Contradicted);
    assert!((2100..2400).contains(&cm), "{cm} cm");
    assert_eq!(monitor.health(), Health::Contradicted);
    // Until readings fit walls again.
    assert_eq!(drive(&mut monitor, cm..cm + 19, &[FITS]), None);
    assert_eq!(monitor.health(), Health::Contradicted);
    assert_eq!(drive(&mut monitor, cm + 19..cm + 30, &[FITS]), None);
    assert_eq!(monitor.health(), Health::Well);
}

#[test]
fn people_and_open_doors_are_no_reason() {
    let mut monitor = in_map();
    for metre in 0..1000 {
        // A third of the way most walls are hidden, or open.
        let readings = match metre % 6 {
            0 => [FITS, IS_OFF, hidden(3), hidden(4)],
            3 => [FITS, IS_OFF, passed(3), passed(4)],
            _ => [FITS, fits(2), fits(3), IS_OFF],
        };
        assert_eq!(drive(&mut monitor, 100 * metre..100 * metre + 100, &readings), None, "{metre} m");
    }
    assert_eq!(monitor.health(), Health::Well);
}

#[test]
fn readings_of_one_kind_in_a_stretch_say_so_and_of_two_nothing() {
    let odds = |readings: &[Outcome]| {
        let mut monitor = in_map();
        assert_eq!(drive(&mut monitor, 0..40, readings), None);
        monitor.elsewhere().log_odds
    };
    let one = odds(&[IS_OFF]);
    assert!(one > 0.0);
    assert!((odds(&[IS_OFF; 5]) - one).abs() < 1e-6, "a wall says one thing, however many sensors see it");
    assert!((odds(&[hidden(2), hidden(3)]) - 2.0 * one).abs() < 1e-6);
    assert!(odds(&[passed(2)]) > one, "people hide walls oftener than walls go");
    assert_eq!(odds(&[hidden(2), fits(2)]), 0.0);
}

#[test]
fn a_home_where_much_is_hidden_is_not_soon_another_one() {
    let contradicted_cm = |people: &[Outcome]| {
        let mut monitor = in_map();
        assert_eq!(drive(&mut monitor, 0..20_000, people), None);
        drive(&mut monitor, 20_000..40_000, &[hidden(2), passed(3), hidden(4)]).map(|(cm, _)| cm - 20_000)
    };
    let (quiet, crowded) = (contradicted_cm(&[fits(2), fits(3)]), contradicted_cm(&[fits(2), hidden(3), fits(4)]));
    let (quiet, crowded) = (quiet.expect("elsewhere"), crowded.expect("elsewhere"));
    assert!(quiet < 300 && crowded > 2 * quiet, "{quiet} cm, {crowded} cm");
}

#[test]
fn the_same_thing_says_so_once_however_often_the_robot_comes_by() {
    let off = [FITS, IS_OFF, passed(3), hidden(4), passed(5)];
    let mut monitor = in_map();
    assert_eq!(drive_by(&mut monitor, 0..100_000, &off, 100), None, "a metre, a thousand times");
    let told = monitor.elsewhere().log_odds;
    assert!(told > 0.0);
    assert_eq!(drive_by(&mut monitor, 100_000..100_100, &off, 100), None);
    assert_eq!(monitor.elsewhere().log_odds, told);
    // But what fitted there before, and does not now, is new.
    let mut monitor = in_map();
    assert_eq!(drive_by(&mut monitor, 0..1000, &[FITS, fits(2), fits(3), fits(4), fits(5)], 100), None);
    assert_eq!(monitor.elsewhere().log_odds, 0.0);
    assert_eq!(drive_by(&mut monitor, 1000..1100, &off, 100), None);
    assert!(monitor.elsewhere().log_odds > 0.9 * told);
}

#[test]
fn what_is_drawn_by_a_robot_that_may_be_elsewhere_says_nothing() {
    let lost = [IS_OFF, hidden(3), passed(4), hidden(5), passed(6)];
    // It draws what is there a second time, and that fits.
    let drawn = [lost.as_slice(), &[20, 21, 22, 23, 24, 25, 26, 27].map(fits)].concat();
    let mut monitor = in_map();
    assert_eq!(drive(&mut monitor, 0..76, &lost), None);
    let (cm, cause) = drive(&mut monitor, 76..1000, &drawn).expect("contradicted");
    assert!(cm < 400 && cause == Health::Contradicted, "{cm} cm, {cause:?}");
    let known = [lost.as_slice(), &[7, 8, 9, 10, 11, 12, 13, 14].map(fits)].concat();
    let mut monitor = in_map();
    assert_eq!(drive(&mut monitor, 0..1000, &known), None, "walls that were there before anything spoke for that do");
}

#[test]
fn a_robot_that_finds_nothing_to_hold_on_to_says_so_and_keeps_its_map() {
    let mut monitor = in_map();
    assert_eq!(drive(&mut monitor, 0..2000, &[Outcome::Unexplained]), None);
    assert_eq!(monitor.health(), Health::Well);
    assert_eq!(drive(&mut monitor, 2000..2010, &[Outcome::Unexplained]), None);
    assert_eq!(monitor.health(), Health::Unexplained);
    assert_eq!(drive(&mut monitor, 2010..2040, &[FITS]), None);
    assert_eq!(monitor.health(), Health::Well);
    // In a hall there is nothing that could be explained.
    assert_eq!(drive(&mut monitor, 2040..9000, &[Outcome::Refused(Refusal::TooFar)]), None);
    assert_eq!(monitor.health(), Health::Well);
}

#[test]
fn what_is_no_estimate_ends_at_once() {
    let judged = |outcome: Outcome, heading_variance: Option<f32>, is_sound: bool| {
        let mut monitor = in_map();
        monitor.note(&outcome, 0.0, Some(0.0));
        monitor.judge(0.0, 0.0, heading_variance, is_sound)
    };
    assert_eq!(judged(FITS, Some(0.9), true), None);
    assert_eq!(judged(FITS, Some(1.1), true), Some(Health::Disoriented));
    assert_eq!(
        judged(FITS, None, true),
        None,
        "without walls there is nothing that the heading could be known against"
    );
    assert_eq!(judged(FITS, Some(0.1), false), Some(Health::Degenerate));
    assert_eq!(judged(Outcome::Refused(Refusal::Degenerate), Some(0.1), true), Some(Health::Degenerate));
    assert_eq!(judged(Outcome::Refused(Refusal::Invalid), Some(0.1), true), None);
}

/// A robot with walls and a calibration, and where it really is.
fn mapped() -> (Box<RobotSlam>, Truth) {
    let (rig, mut truth) = (rig(), Truth::new(3));
    let mut slam = Box::new(RobotSlam::with_config(rig.clone(), crate::Config::default()).expect("a good rig"));
    for number in 0..2000 {
        slam.step(&truth.step(&rig, number));
    }
    assert!(slam.walls().count() >= 4);
    (slam, truth)
}

fn off_m(slam: &RobotSlam, truth: &Truth) -> f32 {
    let pose = slam.pose();
    (pose.x_m - truth.pose[0] as f32).hypot(pose.y_m - truth.pose[1] as f32)
}

#[test]
fn a_new_map_goes_on_where_the_robot_is_with_its_calibration() {
    let (mut slam, mut truth) = mapped();
    let (before, calibration) = (slam.estimate(), slam.calibration().collect::<Vec<_>>());
    slam.restart_map();
    let after = slam.estimate();
    assert_eq!((slam.walls().count(), slam.alpha(), slam.counters().restarts), (0, None, 1));
    assert!(before.pose.x_m == after.pose.x_m && before.pose.y_m == after.pose.y_m, "{before:?}, {after:?}");
    assert!(
        (after.covariance - before.covariance).abs().max() < 1e-3 * before.covariance.max(),
        "{before:?} {after:?}"
    );
    assert_eq!(slam.calibration().collect::<Vec<_>>(), calibration);
    let ids: Vec<u16> = slam.walls().map(|wall| wall.id).collect();
    for number in 2000..4000 {
        assert_eq!(slam.step(&truth.step(&rig(), number)).health, Health::Well);
    }
    assert!(slam.walls().count() >= 4 && slam.walls().all(|wall| !ids.contains(&wall.id)));
    assert!(off_m(&slam, &truth) < 0.05, "{} m off", off_m(&slam, &truth));
}

#[test]
fn a_covariance_that_is_none_is_left_behind() {
    let (mut slam, mut truth) = mapped();
    let calibration = slam.calibration().map(|(parameter, value, _)| (parameter, value)).collect::<Vec<_>>();
    let variance = slam.ekf.covariance(0, 0);
    slam.ekf.correlate(0, 0, -2.0 * variance);
    let mut worst = Health::Well;
    for number in 2000..4000 {
        let health = slam.step(&truth.step(&rig(), number)).health;
        worst = if health == Health::Well { worst } else { health };
        if number == 2016 {
            let kept = slam.calibration().map(|(parameter, value, _)| (parameter, value)).collect::<Vec<_>>();
            assert_eq!(slam.counters().restarts, 1);
            assert!(kept.iter().zip(&calibration).all(|(a, b)| (a.1 - b.1).abs() < 1e-2), "{kept:?}, {calibration:?}");
        }
    }
    assert_eq!((worst, slam.health(), slam.counters().restarts), (Health::Degenerate, Health::Well, 1));
    assert!(slam.walls().count() >= 4 && off_m(&slam, &truth) < 0.1, "{} m off", off_m(&slam, &truth));
}

#[test]
fn what_is_no_number_is_not_kept() {
    let (mut slam, truth) = mapped();
    let place = off_m(&slam, &truth);
    slam.ekf.set_mean(4, f32::NAN);
    for number in 2000..2016 {
        slam.step(&Truth::new(3).step(&rig(), number));
    }
    assert_eq!(slam.counters().restarts, 1);
    assert!((0..slam.state_len()).all(|i| slam.state_mean(i).is_finite()));
    let covariance = slam.estimate().covariance;
    assert!(covariance.iter().all(|value| value.is_finite()) && place < 0.1);
}

#[test]
fn a_map_about_to_be_forgotten_can_be_kept_before_and_waits_when_told() {
    let (mut slam, mut truth) = mapped();
    let mut number = 2000..;
    // Nothing is seen that would tell the heading again.
    let mut step = |slam: &mut RobotSlam| {
        let sample = truth.step(&rig(), number.next().expect("a number"));
        slam.step(&Sample { ranges: [RangeInput::Missing; 8], ..sample }).health
    };
    assert!(!slam.is_about_to_forget());
    slam.put_off_forgetting();
    assert!(!slam.is_about_to_forget(), "nothing is to be put off");
    slam.ekf.correlate(THETA, THETA, 4.0);
    slam.monitor.doubted = slam.map.next_id().wrapping_sub(1);
    let walls = slam.walls().count();
    assert_eq!(step(&mut slam), Health::Disoriented);
    assert!(slam.is_about_to_forget() && slam.counters().restarts == 0);
    let newest = slam.map.next_id().wrapping_sub(1);
    assert!(slam.walls().all(|wall| wall.id != newest), "what was drawn in doubt is not kept");
    for _ in 0..5 {
        slam.put_off_forgetting();
        step(&mut slam);
        assert!(slam.is_about_to_forget() && slam.counters().restarts == 0 && slam.walls().count() + 2 > walls);
    }
    step(&mut slam);
    assert_eq!((slam.is_about_to_forget(), slam.counters().restarts), (false, 1));
    // Somebody who begins a new map himself is not asked again.
    slam.monitor.steps_left = 1;
    slam.restart_map();
    step(&mut slam);
    assert_eq!(slam.counters().restarts, 2);
}
