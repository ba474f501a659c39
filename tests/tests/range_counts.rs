//! Converter counts through the robot's sensor trait into the estimator: what is no reading is refused, for its reason.

use std::convert::Infallible;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use hal_sim::{Board, ClosedLoop, Estimate, SharpOptions, SimOptions, Simulation, default_rig, default_rig_with};
use robot::{DriveMotors, Duty, PilotConfig, RangeSensorBank, WheelEncoders};
use slam_core::{Config, Counters, HostSlam, Motion, Outcome, RangeInput, Refusal, Rig, Sample, Ticks};
use tests::sanity::{Tally, assert_sane};

/// A bank of sensors whose converter shows what the script says, the same for each sensor.
struct Scripted<I>(I);

impl<I: Iterator<Item = u16>> RangeSensorBank<16> for Scripted<I> {
    type Error = Infallible;

    async fn read(&mut self) -> [Result<RangeInput, Infallible>; 16] {
        [Ok(self.0.next().map_or(RangeInput::Missing, RangeInput::Counts)); 16]
    }
}

/// What comes of a future that waits for nothing.
fn now<T>(future: impl Future<Output = T>) -> T {
    let Poll::Ready(value) = pin!(future).poll(&mut Context::from_waker(Waker::noop())) else { panic!("it waits") };
    value
}

/// Reads the bank every `period_us` and feeds the estimator; the robot drives `ticks` per sample.
fn run(
    mut bank: impl RangeSensorBank<16, Error = Infallible>,
    rig: Rig<16>,
    period_us: u64,
    ticks: i32,
    samples: u64,
) -> Counters {
    let sensors = rig.sensors.len();
    let mut slam = HostSlam::with_config(rig, Config::default()).unwrap();
    let mut tally = Tally::default();
    for i in 0..samples {
        let ranges = now(bank.read()).map(|Ok(range)| range);
        let cumulative = ticks.wrapping_mul(i as i32);
        let motion = Motion::Ticks(Ticks { left: cumulative, right: cumulative });
        let sample = Sample { time_us: (i + 1) * period_us, motion, ranges };
        let report = slam.step(&sample);
        tally.add(&sample, &report, sensors, true);
        assert_sane(&slam);
    }
    tally.assert_agrees(&slam);
    *slam.counters()
}

/// The front sensor alone, looking straight ahead.
fn front() -> Rig<16> {
    default_rig_with(&[0])
}

fn script(counts: &[u16]) -> Scripted<impl Iterator<Item = u16>> {
    Scripted(counts.iter().copied())
}

/// Counts at which the default sensor reads this range.
fn counts_of(range_m: f64) -> u16 {
    ((range_m / 0.60374).powf(-1.0 / 1.16) / 3.3 * 4095.0).round() as u16
}

/// Refusals of every reason.
fn refused(counters: &Counters) -> Vec<(Refusal, u32)> {
    Refusal::ALL.into_iter().map(|why| (why, counters.refused[why as usize])).filter(|(_, n)| *n > 0).collect()
}

#[test]
fn zero_is_a_floor() {
    assert_eq!(refused(&run(script(&[0; 20]), front(), 100_000, 0, 20)), [(Refusal::Floor, 20)]);
}

#[test]
fn full_scale_is_too_near_and_more_is_invalid() {
    assert_eq!(refused(&run(script(&[4095; 20]), front(), 100_000, 0, 20)), [(Refusal::TooNear, 20)]);
    let over = [4096, 5000, 32_768, 65_535];
    assert_eq!(refused(&run(script(&over), front(), 100_000, 0, 4)), [(Refusal::Invalid, 4)]);
}

#[test]
fn the_floor_voltage_is_a_floor_and_a_little_more_is_too_far() {
    let far = counts_of(1.7);
    assert_eq!(refused(&run(script(&[far; 10]), front(), 100_000, 0, 10)), [(Refusal::TooFar, 10)]);
    let floor = counts_of(3.5);
    assert_eq!(refused(&run(script(&[floor; 10]), front(), 100_000, 0, 10)), [(Refusal::Floor, 10)]);
}

#[test]
fn a_held_reading_is_used_once() {
    // Sampled at 50 Hz, a new reading every 40 ms: every other one is held.
    let counts: Vec<u16> = (0..40u16).map(|i| 1000 + i / 2 * 5).collect();
    let counters = run(script(&counts), front(), 20_000, 20, 40);
    assert_eq!(refused(&counters), [(Refusal::Held, 20)]);
    // A count of converter noise does not make it a new one.
    let counts: Vec<u16> = (0..40u16).map(|i| 1000 + i / 2 * 5 + i % 2).collect();
    assert_eq!(refused(&run(script(&counts), front(), 20_000, 20, 40)), [(Refusal::Held, 20)]);
    // At 10 Hz nothing is held for so long: equal readings are two readings.
    assert_eq!(refused(&run(script(&counts), front(), 100_000, 20, 40)), []);
    // So many in a row are those of a sensor that is frozen.
    let frozen = refused(&run(script(&[1000; 40]), front(), 100_000, 20, 40));
    assert!(matches!(frozen[..], [(Refusal::Frozen, 10..)]), "{frozen:?}");
}

#[test]
fn under_the_minimum_range_the_output_folds_back() {
    // Towards a wall at 3.6 cm a sample, from 0.45 m; then under the minimum, where the curve falls again. After the jump
    // the folded readings grow no faster than the robot could drive away, and are still not believed.
    let ranges_m = [0.45, 0.414, 0.378, 0.342, 0.306, 0.27, 0.234, 0.198, 0.162, 0.24, 0.245, 0.25, 0.255, 0.26];
    let counters = run(script(&ranges_m.map(counts_of)), front(), 100_000, 81, 14);
    assert_eq!(refused(&counters), [(Refusal::FoldBack, 5)]);
    // Back at the minimum it comes out of the fold.
    let back_m = [ranges_m.as_slice(), &[0.157, 0.19, 0.22]].concat();
    let counts: Vec<u16> = back_m.iter().map(|m| counts_of(*m)).collect();
    assert_eq!(refused(&run(script(&counts), front(), 100_000, 81, 17)), [(Refusal::FoldBack, 5)]);
}

#[test]
fn a_random_stream_is_accounted_for() {
    let mut state = 1u32;
    let random = std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as u16
    });
    let counters = run(Scripted(random), default_rig(), 40_000, 10, 2000);
    // Fifteen sixteenths are over the full scale of 12 bits.
    let invalid = counters.refused[Refusal::Invalid as usize];
    assert!((14_500..15_500).contains(&invalid), "{invalid} of 16000");
    let mut state = 2u32;
    let random = std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 20) as u16
    });
    let counters = run(Scripted(random), default_rig(), 40_000, 10, 2000);
    assert_eq!(counters.refused[Refusal::Invalid as usize], 0);
    assert!(refused(&counters).len() >= 3, "{counters:?}");
}

#[test]
fn the_simulated_board_s_converter_feeds_the_estimator() {
    let plan = hal_sim::plan_file::load("flat").unwrap();
    let board = Board::new(Simulation::new(&plan, &default_rig(), SimOptions::default(), 4).unwrap());
    let (mut ranges, mut encoders, mut motors) = (board.range_sensors(), board.encoders(), board.motors());
    motors.set_duty(Duty { left: 0.22, right: 0.3 }).unwrap();
    let mut slam = HostSlam::with_config(default_rig(), Config::default()).unwrap();
    let mut tally = Tally::default();
    for i in 1..=1500u64 {
        // Twice as often as the sensors have something new.
        board.advance(0.02);
        let motion = Motion::Ticks(encoders.ticks().unwrap());
        let sample = Sample { time_us: 20_000 * i, motion, ranges: now(ranges.read()).map(|Ok(range)| range) };
        let report = slam.step(&sample);
        tally.add(&sample, &report, 8, true);
        assert_sane(&slam);
    }
    tally.assert_agrees(&slam);
    let held = tally.refused(Refusal::Held);
    assert!((4000..8000).contains(&held), "{held} of 12000 held");
    assert!(slam.counters().updates > 500, "{:?}", slam.counters());
}

#[test]
fn spikes_do_not_move_the_estimate() {
    let plan = hal_sim::plan_file::load("room").unwrap();
    let sharp = SharpOptions { spike_probability: 0.05, spike_v: 1.5, ..SharpOptions::default() };
    let options = SimOptions { sharp, ..SimOptions::default() };
    let simulation = Simulation::new(&plan, &default_rig(), options, 1).unwrap();
    let mut slam = HostSlam::with_config(default_rig(), Config::default()).unwrap();
    let mut tally = Tally::default();
    let (mut refused, mut worst_m) = (0u32, 0.0f64);
    let mut drive = ClosedLoop::new(simulation, &default_rig(), PilotConfig::default());
    for _ in 0..3000 {
        let frame = drive.step(&mut |sample| {
            let report = slam.step(sample);
            tally.add(sample, &report, 8, true);
            assert_sane(&slam);
            refused += report.readings.iter().filter(|r| matches!(r.outcome, Outcome::Gated { .. })).count() as u32;
            Estimate::new(slam.pose(), &report)
        });
        let pose = slam.pose();
        let off_m = f64::hypot(f64::from(pose.x_m) - frame.truth.x_m, f64::from(pose.y_m) - frame.truth.y_m);
        worst_m = worst_m.max(off_m);
    }
    tally.assert_agrees(&slam);
    // A twentieth of some ten thousand readings.
    assert!(refused > 300, "{refused} outside the gates");
    assert!(worst_m < 0.15, "{worst_m} m off");
}
