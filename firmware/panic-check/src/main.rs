//! Calls every public method of slam-core's estimator, with a kept map's record, and of look-back with inputs that the compiler knows nothing about. This program is never
//! run: `cargo xtask panic-check` looks whether the linker had to keep `panic_reached`.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;
use kept_map::Record;
use look_back::{Hit, RobotBackEnd, RobotDiary, RobotLookBack, Unknown};
use slam_core::kept::Kept;
use slam_core::{
    Adc, Config, DriveModel, HandOver, Increment, Match, Motion, Pose, RangeInput, RobotSlam, Sample, SecondCopy,
    Ticks, angle,
};

#[cortex_m_rt::entry]
fn main() -> ! {
    #[cfg(feature = "bad")]
    black_box([1, 2, 3][black_box(7)]);
    plane();
    if let Ok(mut slam) = RobotSlam::with_config(rig(), black_box(Config::default())) {
        estimator(&mut slam);
        view(&slam);
        other_maps(&mut slam);
        beside(&mut slam);
        black_box(slam.start(rig())).ok();
        black_box(slam.start_with_config(rig(), black_box(Config::default()))).ok();
    }
    black_box(RobotSlam::new(rig())).ok();
    back_end();
    loop {
        cortex_m::asm::nop();
    }
}

fn rig() -> slam_core::Rig<8> {
    let mut rig = slam_core::Rig {
        drive: black_box(DriveModel::Odometry {
            scale_sigma: 0.05,
            noise_m2_per_m: 4e-4,
            noise_rad2_per_m: 2e-4,
            noise_rad2_per_rad: 1e-3,
            veer_sigma: 0.0,
        }),
        adc: black_box(Some(Adc { bits: 12, vref_v: 3.3 })),
        sensors: heapless::Vec::new(),
    };
    for _ in 0..black_box(8) {
        // A full list refuses the rest, which is none of slam-core's business.
        let _ = rig.sensors.push(black_box(slam_core::RangeSensor {
            mount: slam_core::Mount::default(),
            min_m: 0.2,
            max_m: 1.5,
            max_incidence_rad: 1.2,
            gain_sigma: 0.01,
            model: slam_core::RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 },
        }));
    }
    rig
}

fn plane() {
    black_box(angle::wrap(black_box(1.0)));
    black_box(angle::sin_cos(black_box(1.0)));
    let pose = black_box(Pose::new(black_box(1.0), black_box(2.0), black_box(3.0)));
    black_box(pose.compose(&pose.inverse()));
    black_box(pose.transform(black_box([1.0, 2.0])));
}

fn estimator(slam: &mut RobotSlam) {
    let ticks = Motion::Ticks(Ticks { left: 1, right: 2 });
    let increment = Motion::Increment(Increment { forward_m: 1.0, left_m: 0.0, turn_rad: 0.1 });
    for motion in [ticks, increment] {
        for range in [RangeInput::Counts(1000), RangeInput::Metres(1.0), RangeInput::Missing] {
            let sample = Sample { time_us: 1, motion, ranges: [range; 8] };
            black_box(slam.step(&black_box(sample)));
        }
    }
}

fn view(slam: &RobotSlam) {
    let index = black_box(7);
    black_box((slam.rig(), slam.config(), slam.counters(), slam.health(), slam.elsewhere()));
    black_box((
        slam.pose(),
        slam.start_pose(),
        slam.estimate(),
        slam.filter_pose(),
        slam.dead_reckoning(),
        slam.displaced(),
    ));
    black_box((slam.alpha(), slam.filter_alpha(), slam.last_motion(), slam.lost_motion(), slam.is_held()));
    black_box((slam.position_level(), slam.wheel_level(), slam.output_level(), slam.latency(), slam.stamp_sigma()));
    black_box((slam.gain(index), slam.is_frozen(index), slam.frozen_sensors(), slam.late_sensors()));
    black_box((slam.state_len(), slam.state_mean(index), slam.state_covariance(index, index), slam.standing(index)));
    for wall in slam.walls() {
        black_box(wall);
    }
    for factor in slam.calibration() {
        black_box(factor);
    }
    // Its table has all that is kept of the map.
    black_box::<&dyn Kept>(slam);
}

/// Maps begun anew, taken up, handed over or found twice.
fn other_maps(slam: &mut RobotSlam) {
    let found = black_box(Match { quarters: 1, pairs: [(1, 2), (3, 4)] });
    if let Ok(record) = Record::parse(black_box(&[0; 4096])) {
        black_box(slam.suits(&record)).ok();
        black_box(slam.take_up(&record, &found)).ok();
    }
    black_box(slam.give_up_copy(&black_box(SecondCopy { since: 1, grid: Some(2) }), &found)).ok();
    let hand_over = black_box(HandOver {
        epoch: 1,
        pose: Pose::ORIGIN,
        alpha_rad: Some(0.1),
        calibration: slam_core::Calibration::EXACT,
        gains: [1.0; slam_core::hand_over::MOST_GAINS],
        walls: black_box(&[]),
        names: black_box(&[]),
        covariance: black_box(&[]),
        is_displaced: false,
    });
    black_box(slam.take_over(&hand_over)).ok();
    if black_box(slam.is_about_to_forget()) {
        slam.put_off_forgetting();
    }
    slam.restart_map();
    slam.restart_elsewhere();
    slam.release();
    slam.stands_in_dock();
    black_box((slam.begin_in_dock(), slam.before_dock_m()));
}

fn beside(slam: &mut RobotSlam) {
    let mut back = black_box(RobotBackEnd::IDLE);
    let increment = Motion::Increment(Increment { forward_m: 1.0, left_m: 0.0, turn_rad: 0.1 });
    let report = slam.step(&black_box(Sample { time_us: 1, motion: increment, ranges: [RangeInput::Counts(1000); 8] }));
    back.record(slam, &black_box(report));
    back.work(black_box(40_000));
    black_box(back.hand_over(slam)).map(black_box);
    black_box((slam.epoch(), back.tally(), back.is_looking_back()));
}

fn back_end() {
    let mut diary = black_box(RobotDiary::new(&rig().drive, black_box(Pose::ORIGIN)));
    diary.travel(&black_box(Increment { forward_m: 1.0, left_m: 0.0, turn_rad: 0.1 }));
    if black_box(diary.is_due()) {
        diary.begin_keyframe(&black_box(Pose::ORIGIN));
    }
    diary.grid(black_box(0.1));
    let hit = Hit { from_m: [0.0; 2], end_m: [1.0, 0.0], variance_m2: 1e-4, alike: 1.0, sensor: 0, wall: Some(1) };
    diary.hit(&black_box(hit));
    let mut look_back = black_box(RobotLookBack::new());
    look_back.begin(&diary);
    black_box(look_back.work(&mut diary, black_box(1000)));
    black_box(look_back.effort());
    black_box(look_back.is_positive());
    black_box(look_back.covariance(black_box(Unknown::Direction(3)), black_box(Unknown::X)));
    black_box(diary.robot());
    black_box(diary.keyframes().last());
    black_box(diary.walls().last());
    black_box(diary.id_of(black_box(3)));
    black_box((diary.calibration(), diary.alpha_rad(), diary.losses(), diary.group_count()));
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    panic_reached()
}

/// Kept by the linker exactly when some panic can be reached.
#[allow(unsafe_code, reason = "a symbol that can be found by name needs an attribute that counts as unsafe")]
#[unsafe(no_mangle)]
#[inline(never)]
fn panic_reached() -> ! {
    loop {
        cortex_m::asm::bkpt();
    }
}
