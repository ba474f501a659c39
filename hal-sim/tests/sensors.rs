//! What the simulated range sensors read: floor, full scale, fold-back, spikes, hold and latency, gain, incidence.
use hal_sim::sharp::{SharpCurve, counts};
use hal_sim::{Age, Plan, SharpOptions, SimOptions, Simulation, default_rig, default_rig_with, plan_file};
use robot::WheelSpeeds;
use slam_core::{Adc, RangeInput, RangeModel, Rig};

const ADC: Adc = Adc { bits: 12, vref_v: 3.3 };

/// A wall `ahead_m` in front of the robot, turned by `turn_deg` about the point that the front sensor sees.
fn wall_ahead(ahead_m: f64, turn_deg: f64) -> Plan {
    let (s, c) = turn_deg.to_radians().sin_cos();
    let (x_m, half_m) = (1.0 + ahead_m, 3.0);
    let text = format!(
        "[start]\nx_m = 1.0\ny_m = 5.0\n[[wall]]\nfrom_m = [{}, {}]\nto_m = [{}, {}]\n",
        x_m + half_m * s,
        5.0 - half_m * c,
        x_m - half_m * s,
        5.0 + half_m * c
    );
    plan_file::parse("test", "test", &text).unwrap()
}

/// No noise, no spikes, a gain of exactly 1: what is read is the curve.
fn quiet() -> (Rig<16>, SimOptions) {
    let mut rig = default_rig_with(&[0]);
    rig.sensors[0].gain_sigma = 0.0;
    if let RangeModel::Sharp { noise_v, .. } = &mut rig.sensors[0].model {
        *noise_v = 0.0;
    }
    let sharp = SharpOptions { spike_probability: 0.0, ..SharpOptions::default() };
    (rig, SimOptions { sharp, ..SimOptions::default() })
}

fn read(simulation: &mut Simulation) -> u16 {
    match simulation.step(WheelSpeeds::STOP).ranges[0] {
        RangeInput::Counts(counts) => counts,
        other => panic!("{other:?}"),
    }
}

fn range_m(counts: u16) -> f64 {
    0.60374 * (f64::from(counts) / 4095.0 * 3.3).powf(-1.16)
}

#[test]
fn the_converter_has_a_zero_and_a_full_scale() {
    assert_eq!(counts(ADC, -0.5), 0);
    assert_eq!(counts(ADC, 0.0), 0);
    assert_eq!(counts(ADC, 3.3), 4095);
    assert_eq!(counts(ADC, 9.0), 4095);
    assert_eq!(counts(ADC, 1.65), 2048);
}

#[test]
fn ranges_are_measured_from_the_mount_along_the_power_law() {
    let (rig, options) = quiet();
    for ahead_m in [0.3, 0.7, 1.4] {
        let mut simulation = Simulation::new(&wall_ahead(ahead_m, 0.0), &rig, options, 1).unwrap();
        let measured_m = range_m(read(&mut simulation));
        assert!((measured_m - (ahead_m - 0.06)).abs() < 0.003, "{ahead_m}: {measured_m}");
    }
}

#[test]
fn far_walls_no_walls_and_slanting_walls_read_as_the_floor() {
    let (rig, options) = quiet();
    let floor = |ahead_m, turn_deg| {
        let mut simulation = Simulation::new(&wall_ahead(ahead_m, turn_deg), &rig, options, 1).unwrap();
        read(&mut simulation)
    };
    assert_eq!(floor(2.5, 0.0), floor(50.0, 0.0));
    assert_eq!(floor(0.8, 75.0), floor(50.0, 0.0));
    assert!(range_m(floor(50.0, 0.0)) > 1.7);
    assert!((range_m(floor(0.8, 65.0)) - 0.74).abs() < 0.003);
}

#[test]
fn a_wall_under_the_minimum_range_reads_like_a_far_one() {
    let (rig, options) = quiet();
    let curve = SharpCurve::new(&rig.sensors[0], 1.0, &options.sharp).unwrap();
    let peak_v = curve.volts(Some(0.155));
    let law_m = |volts: f64| 0.60374 * volts.powf(-1.16);
    assert!(curve.volts(Some(0.16)) < peak_v);
    let mut last_v = peak_v;
    for near_m in [0.15, 0.1, 0.05, 0.01] {
        assert!(curve.volts(Some(near_m)) < last_v);
        last_v = curve.volts(Some(near_m));
    }
    assert!(law_m(curve.volts(Some(0.08))) > 0.2);
    // The same, through the whole board: the body stands against the wall.
    let mut simulation = Simulation::new(&wall_ahead(0.172, 0.0), &rig, options, 1).unwrap();
    assert!(range_m(read(&mut simulation)) > 0.17);
}

#[test]
fn the_gain_scales_the_range_and_is_told_beside_the_truth() {
    let (mut rig, options) = quiet();
    rig.sensors[0].gain_sigma = 0.03;
    for seed in 0..5 {
        let mut simulation = Simulation::new(&wall_ahead(0.66, 0.0), &rig, options, seed).unwrap();
        let ratio = range_m(read(&mut simulation)) / 0.6;
        assert!((ratio - simulation.calibration().gains[0]).abs() < 2e-3, "{ratio}");
        assert!((simulation.calibration().gains[0] - 1.0).abs() > 1e-6);
    }
}

#[test]
fn a_reading_is_held_until_the_next_cycle_and_noise_is_drawn_once_for_it() {
    let mut rig = default_rig_with(&[0]);
    let options = SimOptions { rate_hz: 100.0, sharp: quiet().1.sharp, ..SimOptions::default() };
    rig.sensors[0].gain_sigma = 0.0;
    let mut simulation = Simulation::new(&wall_ahead(0.66, 0.0), &rig, options, 2).unwrap();
    let readings: Vec<u16> = (0..1000).map(|_| read(&mut simulation)).collect();
    let changes = readings.windows(2).filter(|pair| pair[0] != pair[1]).count();
    // Ten seconds of cycles of 28.7 to 47.9 ms; now and then two readings in a row are the same by chance.
    assert!((190..=349).contains(&changes), "{changes}");
    let volts: Vec<f64> = readings.iter().map(|&counts| f64::from(counts) / 4095.0 * 3.3).collect();
    let mean_v = volts.iter().sum::<f64>() / volts.len() as f64;
    let sigma_v = (volts.iter().map(|v| (v - mean_v).powi(2)).sum::<f64>() / volts.len() as f64).sqrt();
    assert!((sigma_v - 0.012).abs() < 0.002, "{sigma_v}");
}

#[test]
fn a_reading_shows_the_middle_of_the_cycle_before() {
    let (rig, options) = quiet();
    let mut simulation = Simulation::new(&wall_ahead(1.2, 0.0), &rig, options, 4).unwrap();
    let speeds = WheelSpeeds { left_mps: 0.25, right_mps: 0.25 };
    let (mut lag_s, mut count) = (0.0, 0);
    for step in 0..70 {
        let sample = simulation.step(speeds);
        let RangeInput::Counts(counts) = sample.ranges[0] else { panic!() };
        if step > 15 {
            let behind_m = range_m(counts) - (1.2 - 0.06 - simulation.pose().x_m);
            lag_s += behind_m / 0.25;
            count += 1;
        }
    }
    let mean_lag_s = lag_s / f64::from(count);
    assert!(mean_lag_s > 0.028 && mean_lag_s < 0.055, "{mean_lag_s}");
}

#[test]
fn spikes_are_rare_and_only_go_up() {
    let (rig, mut options) = quiet();
    options.sharp.spike_probability = 0.02;
    let mut simulation = Simulation::new(&wall_ahead(0.66, 0.0), &rig, options, 5).unwrap();
    let readings: Vec<u16> = (0..5000).map(|_| read(&mut simulation)).collect();
    let usual = *readings.iter().min().unwrap();
    let spikes: Vec<u16> = readings.iter().copied().filter(|&counts| counts != usual).collect();
    assert!((60..=150).contains(&spikes.len()), "{}", spikes.len());
    assert!(spikes.iter().all(|&counts| counts > usual + 80));
}

#[test]
fn sensors_that_report_metres_have_both_parts_of_their_noise() {
    let (mut rig, options) = quiet();
    rig.adc = None;
    rig.sensors[0].model = RangeModel::Metric { noise_m: 0.01, noise_rel: 0.02 };
    let mut simulation = Simulation::new(&wall_ahead(1.06, 0.0), &rig, options, 6).unwrap();
    let errors_m: Vec<f64> = (0..4000)
        .map(|_| match simulation.step(WheelSpeeds::STOP).ranges[0] {
            RangeInput::Metres(metres) => f64::from(metres) - 1.0,
            other => panic!("{other:?}"),
        })
        .collect();
    let sigma_m = (errors_m.iter().map(|e| e * e).sum::<f64>() / 4000.0).sqrt();
    assert!((sigma_m - 0.02236).abs() < 0.001, "{sigma_m}");
    let mut far = Simulation::new(&wall_ahead(3.0, 0.0), &rig, options, 6).unwrap();
    assert_eq!(far.step(WheelSpeeds::STOP).ranges[0], RangeInput::Missing);
}

#[test]
fn one_more_sensor_does_not_change_what_the_others_read() {
    let plan = plan_file::load("room").unwrap();
    let drive = |rig: &Rig<16>| {
        let mut simulation = Simulation::new(&plan, rig, SimOptions::default(), 9).unwrap();
        let speeds = WheelSpeeds { left_mps: 0.1, right_mps: 0.12 };
        (0..200).map(|_| simulation.step(speeds)).collect::<Vec<_>>()
    };
    let (few, all) = (drive(&default_rig_with(&[0, 1, 2])), drive(&default_rig()));
    for (few, all) in few.iter().zip(&all) {
        assert_eq!(few.motion, all.motion);
        assert_eq!(few.ranges[..3], all.ranges[..3]);
    }
}

/// What the front sensor reads, metres, of a wall that the robot drives towards at 0.25 m/s, less the true range then.
fn shown_late_m(sharp: SharpOptions) -> f64 {
    let (rig, options) = quiet();
    let options = SimOptions { sharp, ..options };
    let mut simulation = Simulation::new(&wall_ahead(2.5, 0.0), &rig, options, 1).unwrap();
    let mut late_m = 0.0;
    let mut readings = 0;
    for step in 0..200 {
        let sample = simulation.step(WheelSpeeds { left_mps: 0.25, right_mps: 0.25 });
        // Once the robot is at its speed and the wall is in range.
        if let (RangeInput::Counts(counts), 125..) = (sample.ranges[0], step) {
            late_m += range_m(counts) - (2.5 - 0.06 - simulation.pose().x_m);
            readings += 1;
        }
    }
    late_m / f64::from(readings)
}

#[test]
fn a_reading_of_age_shows_where_the_robot_was() {
    let aged = |mean_s| SharpOptions { age: Some(Age { mean_s, spread_s: 0.0 }), ..quiet().1.sharp };
    for age_s in [0.0, 0.03, 0.06] {
        let late_m = shown_late_m(aged(age_s));
        // Half a count of the converter is 1.5 mm there.
        assert!((late_m - 0.25 * age_s).abs() < 0.003, "{age_s}: {late_m}");
    }
}

#[test]
fn a_low_pass_makes_readings_later_by_its_time_constant() {
    let direct_m = shown_late_m(quiet().1.sharp);
    let filtered_m = shown_late_m(SharpOptions { filter_s: 0.04, ..quiet().1.sharp });
    assert!((filtered_m - direct_m - 0.25 * 0.04).abs() < 0.003, "{direct_m} {filtered_m}");
}

#[test]
fn the_noise_there_is_may_be_another_than_the_rig_states() {
    let (rig, options) = quiet();
    let sharp = SharpOptions { noise_v: Some(0.045), ..options.sharp };
    let mut simulation = Simulation::new(&wall_ahead(0.7, 0.0), &rig, SimOptions { sharp, ..options }, 1).unwrap();
    let volts: Vec<f64> = (0..4000).map(|_| f64::from(read(&mut simulation)) / 4095.0 * 3.3).collect();
    let mean = volts.iter().sum::<f64>() / volts.len() as f64;
    let sigma = (volts.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / volts.len() as f64).sqrt();
    assert!((sigma / 0.045 - 1.0).abs() < 0.1, "{sigma}");
}
