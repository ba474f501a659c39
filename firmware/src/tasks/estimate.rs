//! The estimator: ranges and counts in; senses for the pilot and frames for the telemetry out.

use crate::SENSORS;
use crate::faults::Task;
use crate::shared::{Ranges, Shared};
use core::cell::Cell;
use robot::Senses;
use slam_core::{Config, RobotSlam, StepReport};
use wire::{Calibration, Estimate, Faults, Frame, Sample, Wall};

/// Steps between two frames of calibration and faults: once a second.
const SLOW_FRAMES: u32 = 25;

/// Estimates whenever ranges come; starts afresh with this configuration when the map is to be reset.
pub async fn estimate(slam: &mut RobotSlam, config: Config, shared: &Shared) -> ! {
    let mut steps = 0_u32;
    loop {
        let ranges = shared.ranges.receive().await;
        if shared.reset_map.try_take().is_some() {
            // The rig was accepted before: it is again.
            let _ = slam.start_with_config(slam.rig().clone(), config);
        }
        let sample = raw_sample(&ranges, shared);
        let report = estimator::step(slam, &sample.to_slam());
        shared.senses.signal(senses(slam, &sample, &report, shared));
        steps = steps.wrapping_add(1);
        tell(slam, sample, steps, shared);
        shared.reports.report(Task::Estimate);
    }
}

fn senses(slam: &RobotSlam, sample: &Sample, report: &StepReport<SENSORS>, shared: &Shared) -> Senses<SENSORS> {
    Senses {
        time_us: sample.time_us,
        pose: slam.pose(),
        ranges_m: report.readings.map(|reading| reading.range_m),
        contacts: shared.contacts(),
    }
}

/// Hands the sample and what came of it to the telemetry; one wall after the other, one a step.
fn tell(slam: &RobotSlam, sample: Sample, steps: u32, shared: &Shared) {
    let time_us = sample.time_us;
    shared.push_frame(Frame::Sample(sample));
    shared.push_frame(Frame::Estimate(Estimate::of(slam, time_us)));
    let count = slam.walls().count();
    let index = (steps as usize).checked_rem(count).unwrap_or(0);
    if let Some(wall) = slam.walls().nth(index) {
        shared.push_frame(Frame::Wall(Wall::of(&wall, index as u8, count as u8)));
    }
    if steps.is_multiple_of(SLOW_FRAMES) {
        shared.push_frame(Frame::Calibration(Calibration::of(slam)));
        let slam = slam.counters().into();
        shared.push_frame(Frame::Faults(Faults { slam, board: shared.faults.get() }));
    }
}

/// Ranges and encoder counts as they were, without any reduction.
fn raw_sample(ranges: &Ranges, shared: &Shared) -> Sample {
    let ticks = shared.latest_odometry.lock(Cell::get).ticks;
    let robot::Contacts { bump_left, bump_right, cliff, lifted } = shared.contacts();
    Sample {
        time_us: ranges.time_us,
        left_ticks: ticks.left,
        right_ticks: ticks.right,
        ranges: ranges.ranges.iter().map(|range| (*range).into()).collect(),
        contacts: wire::Contacts { bump_left, bump_right, cliff, lifted },
    }
}
