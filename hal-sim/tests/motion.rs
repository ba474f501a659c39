//! The drive: calibration errors, noise, slip, walls in the way; encoders that wrap; one seed, one run.
use hal_sim::{DriveOptions, Plan, SimError, SimOptions, Simulation, default_rig, plan_file};
use robot::WheelSpeeds;
use slam_core::{DriveModel, Increment, Motion, Pose, Rig, Ticks};

fn field() -> Plan {
    let text = "[start]\nx_m = 0.0\ny_m = 0.0\n[[wall]]\nfrom_m = [-900.0, 900.0]\nto_m = [900.0, 900.0]\n";
    plan_file::parse("test", "test", text).unwrap()
}

fn rig(scale: f32, noise: f32) -> Rig<16> {
    let mut rig = default_rig();
    if let DriveModel::Wheels { scale_sigma, noise_m2_per_m, .. } = &mut rig.drive {
        (*scale_sigma, *noise_m2_per_m) = (scale, noise);
    }
    rig
}

fn ticks(motion: Motion) -> Ticks {
    let Motion::Ticks(ticks) = motion else { panic!("{motion:?}") };
    ticks
}

/// Drives for a time and returns each wheel's travel by its encoder.
fn drive(simulation: &mut Simulation, left_mps: f32, right_mps: f32, samples: usize) -> [f64; 2] {
    let begin = ticks(simulation.sample().motion);
    let mut end = begin;
    for _ in 0..samples {
        end = ticks(simulation.step(WheelSpeeds { left_mps, right_mps }).motion);
    }
    [end.left - begin.left, end.right - begin.right].map(|ticks| f64::from(ticks) * 0.000_445)
}

#[test]
fn an_exact_drive_ends_where_its_encoders_say() {
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), SimOptions::default(), 1).unwrap();
    let [left_m, right_m] = drive(&mut simulation, 0.2, 0.25, 1000);
    let turn_rad = (right_m - left_m) / 0.235;
    assert!((right_m - 10.0).abs() < 0.05, "{right_m}");
    let radius_m = 0.5 * (left_m + right_m) / turn_rad;
    let pose = simulation.pose();
    let away_m = [pose.x_m - radius_m * turn_rad.sin(), pose.y_m - radius_m * (1.0 - turn_rad.cos())];
    assert!(away_m.iter().all(|d| d.abs() < 0.01), "{away_m:?}");
}

#[test]
fn wheel_scales_are_true_travel_over_nominal_travel() {
    for seed in 1..6 {
        let mut simulation = Simulation::new(&field(), &rig(0.02, 0.0), SimOptions::default(), seed).unwrap();
        let [left_m, right_m] = drive(&mut simulation, 0.25, 0.25, 500);
        let truth = simulation.calibration().drive;
        assert!((truth.scale_left - 1.0).abs() > 1e-6 && truth.track == 1.0);
        let expected_rad = (right_m * truth.scale_right - left_m * truth.scale_left) / 0.235;
        assert!((simulation.pose().theta_rad - expected_rad).abs() < 0.005);
    }
}

#[test]
fn travel_noise_has_the_rig_s_variance_per_metre() {
    let mut squares = 0.0;
    let runs = 300;
    for seed in 0..runs {
        let mut simulation = Simulation::new(&field(), &rig(0.0, 1e-4), SimOptions::default(), seed).unwrap();
        let [left_m, right_m] = drive(&mut simulation, 0.25, 0.25, 100);
        let turned_m = 0.235 * simulation.pose().theta_rad - (right_m - left_m);
        squares += turned_m * turned_m / (left_m + right_m);
    }
    let variance = squares / runs as f64;
    assert!((variance / 1e-4 - 1.0).abs() < 0.25, "{variance}");
}

#[test]
fn slips_lose_travel_that_the_encoders_count() {
    let drive_options = DriveOptions { slips_per_m: 2.0, slip_m: 0.02, ..DriveOptions::default() };
    let options = SimOptions { drive: drive_options, ..SimOptions::default() };
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), options, 1).unwrap();
    let [left_m, right_m] = drive(&mut simulation, 0.25, 0.25, 1000);
    let lost_m = 0.5 * (left_m + right_m) - f64::hypot(simulation.pose().x_m, simulation.pose().y_m);
    // Two slips of one wheel a metre, 2 cm each: the axle's centre loses 2 cm a metre, and the heading wanders.
    assert!(lost_m > 0.1, "{lost_m}");
}

#[test]
fn a_wall_stops_the_body_but_not_the_wheels() {
    let plan = plan_file::load("room").unwrap();
    let mut simulation = Simulation::new(&plan, &rig(0.0, 0.0), SimOptions::default(), 1).unwrap();
    simulation.set_duty(robot::Duty { left: 0.5, right: 0.5 });
    let before = simulation.ticks();
    simulation.advance(30.0);
    let turned_m = f64::from(simulation.ticks().left - before.left) * 0.000_445;
    assert!(turned_m > 8.0 && simulation.pose().x_m < 3.5, "{turned_m} {:?}", simulation.pose());
    let place = simulation.pose_in_plan();
    assert!(place.x_m < 4.5 - 0.17 + 1e-6 && place.x_m > 4.5 - 0.2, "{place:?}");
    assert!(simulation.contacts().any());
}

/// A wheel that runs against its duty for longer is wired the wrong way round.
#[test]
fn a_reversal_at_full_speed_brakes_in_a_fifth_of_a_second_and_is_no_stall() {
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), SimOptions::default(), 1).unwrap();
    for mps in [0.6, -0.6, 0.6, -0.1, 0.6] {
        let speeds = [(); 50].map(|()| drive(&mut simulation, mps, mps, 1)[0] * f64::from(mps.signum()) / 0.04);
        let against = speeds.iter().filter(|speed_mps| **speed_mps < 0.0).count();
        assert!(against <= 5, "{against} samples at {mps} m/s");
        assert!(speeds[49] > 0.08, "{} m/s", speeds[49]);
        assert!(!simulation.condition().is_stalled, "{mps} m/s");
    }
}

#[test]
fn encoders_are_16_bit_counters_that_wrap() {
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), SimOptions::default(), 1).unwrap();
    let mut wraps = 0;
    let mut last = simulation.raw_counters();
    for _ in 0..4000 {
        simulation.step(WheelSpeeds { left_mps: 0.3, right_mps: 0.3 });
        let raw = simulation.raw_counters();
        wraps += usize::from(raw[0] < last[0]);
        last = raw;
    }
    let total = ticks(simulation.sample().motion).left;
    assert!(wraps >= 1 && total > 65_536 && f64::from(total) * 0.000_445 > 45.0, "{wraps} {total}");
}

#[test]
fn one_seed_gives_one_run_bit_for_bit_and_another_seed_another() {
    let plan = plan_file::load("clutter").unwrap();
    let run = |seed| {
        let mut simulation = Simulation::new(&plan, &default_rig(), SimOptions::default(), seed).unwrap();
        let turn = |i: usize| WheelSpeeds::from_twist(0.2, if i % 200 < 100 { 0.5 } else { -0.3 }, 0.235);
        let samples: Vec<_> = (0..2000).map(|i| simulation.step(turn(i))).collect();
        (samples, simulation.pose().x_m.to_bits(), simulation.calibration().clone())
    };
    assert_eq!(run(11), run(11));
    assert_ne!(run(11).0, run(12).0);
}

#[test]
fn samples_come_at_the_chosen_rate() {
    for rate_hz in [1.0, 5.0, 25.0, 30.0, 100.0] {
        let options = SimOptions { rate_hz, ..SimOptions::default() };
        let mut simulation = Simulation::new(&field(), &default_rig(), options, 1).unwrap();
        assert_eq!(simulation.sample().time_us, 0);
        let times: Vec<_> = (0..10).map(|_| simulation.step(WheelSpeeds::STOP).time_us).collect();
        let expected: Vec<_> = (1..=10).map(|i| (f64::from(i) / rate_hz * 1e6).round() as u64).collect();
        assert_eq!(times, expected);
    }
}

#[test]
fn what_cannot_be_simulated_is_said() {
    let plan = plan_file::load("room").unwrap();
    let start = |rig: &Rig<16>, options| Simulation::new(&plan, rig, options, 1).map(|_| ()).unwrap_err();
    let no_adc = Rig { adc: None, ..default_rig() };
    assert_eq!(start(&no_adc, SimOptions::default()), SimError::NeedsAdc(0));
    let fast = SimOptions { rate_hz: f64::NAN, ..SimOptions::default() };
    assert!(start(&default_rig(), fast).to_string().contains("1 to 100"));
    let fat = SimOptions { body_radius_m: 0.9, ..SimOptions::default() };
    assert!(start(&default_rig(), fat).to_string().contains("[start]"));
}

#[test]
fn uneven_slips_lose_as_much_on_average() {
    let lost_m = |slip_tail| {
        let slipping = DriveOptions { slips_per_m: 2.0, slip_m: 0.01, slip_tail, ..DriveOptions::default() };
        let options = SimOptions { drive: slipping, ..SimOptions::default() };
        let mut sum_m = 0.0;
        for seed in 0..20 {
            let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), options, seed).unwrap();
            let [left_m, right_m] = drive(&mut simulation, 0.25, 0.25, 200);
            sum_m += 0.5 * (left_m + right_m) - f64::hypot(simulation.pose().x_m, simulation.pose().y_m);
        }
        sum_m
    };
    let (alike_m, uneven_m) = (lost_m(0.0), lost_m(0.8));
    assert!((uneven_m / alike_m - 1.0).abs() < 0.3, "{alike_m} {uneven_m}");
}

#[test]
fn unequal_wheels_turn_the_robot_by_so_much_a_metre() {
    let drifting = DriveOptions { drift_rad_per_m: 0.05, ..DriveOptions::default() };
    let options = SimOptions { drive: drifting, ..SimOptions::default() };
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), options, 1).unwrap();
    let [left_m, right_m] = drive(&mut simulation, 0.25, 0.25, 100);
    let turned_rad = simulation.pose().theta_rad - (right_m - left_m) / 0.235;
    let expected_rad = 0.05 * 0.5 * (left_m + right_m);
    assert!((turned_rad - expected_rad).abs() < 0.05 * expected_rad, "{turned_rad} {expected_rad}");
}

#[test]
fn published_odometry_adds_up_to_the_wheels_pose_at_its_last_message() {
    let options = SimOptions { odometry_hz: Some(10.0), ..SimOptions::default() };
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), options, 1).unwrap();
    let (mut sum, mut still) = (Pose::default(), 0);
    for _ in 0..100 {
        let Motion::Increment(i) = simulation.step(WheelSpeeds { left_mps: 0.2, right_mps: 0.25 }).motion else {
            panic!("ticks")
        };
        still += u32::from(i == Increment::default());
        sum = sum.compose(&Pose { x_m: i.forward_m, y_m: i.left_m, theta_rad: i.turn_rad });
    }
    let truth = simulation.pose();
    let off_m = f64::hypot(f64::from(sum.x_m) - truth.x_m, f64::from(sum.y_m) - truth.y_m);
    // Of 25 samples a second, 15 have no new message; the last one is a tenth of a second old at most.
    assert!(still >= 55 && off_m < 0.03, "{still} {off_m}");
}

#[test]
fn jittered_stamps_still_increase() {
    let options = SimOptions { stamp_jitter_s: 0.05, ..SimOptions::default() };
    let mut simulation = Simulation::new(&field(), &rig(0.0, 0.0), options, 1).unwrap();
    let stamps: Vec<u64> = (0..200).map(|_| simulation.step(WheelSpeeds::STOP).time_us).collect();
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(stamps.windows(2).any(|pair| pair[1] - pair[0] != 40_000));
}

#[test]
fn a_dead_reckoned_pose_has_the_errors_that_its_rig_states() {
    let (mut distances, mut turns, mut sideways) = (Vec::new(), Vec::new(), Vec::new());
    let (noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad) = (1e-4, 1e-4, 1e-3);
    let drive = DriveModel::Odometry {
        scale_sigma: 0.02,
        noise_m2_per_m,
        noise_rad2_per_m,
        noise_rad2_per_rad,
        veer_sigma: 0.0,
    };
    for seed in 0..200 {
        let rig = Rig { drive, ..default_rig() };
        let mut simulation = Simulation::new(&field(), &rig, SimOptions::default(), seed).unwrap();
        let (mut before, [mut forward_m, mut turn_rad, mut true_m, mut true_rad]) = (simulation.pose(), [0.0_f64; 4]);
        for _ in 0..100 {
            let sample = simulation.step(WheelSpeeds { left_mps: 0.2, right_mps: 0.25 });
            let Motion::Increment(increment) = sample.motion else { panic!("ticks") };
            let moved = before.relative(&simulation.pose());
            before = simulation.pose();
            forward_m += f64::from(increment.forward_m);
            turn_rad += f64::from(increment.turn_rad);
            true_m += moved.x_m;
            true_rad += moved.theta_rad;
            sideways.push((f64::from(increment.left_m) - moved.y_m) / (f64::from(noise_m2_per_m) * moved.x_m).sqrt());
        }
        let calibration = simulation.calibration();
        let position_m = (f64::from(noise_m2_per_m) * true_m).sqrt();
        let heading_rad = (f64::from(noise_rad2_per_m) * true_m + f64::from(noise_rad2_per_rad) * true_rad).sqrt();
        distances.push((forward_m - true_m / calibration.scale_distance) / position_m);
        turns.push((turn_rad - true_rad / calibration.scale_turn) / heading_rad);
    }
    // Each is a normal number of variance 1; 200 of them have that within a tenth, 1-sigma.
    for (name, errors) in [("distance", distances), ("turn", turns), ("sideways", sideways)] {
        let variance = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
        assert!((0.7..1.3).contains(&variance), "{name}: {variance}");
    }
}
