//! Encoders and range sensors, each at its own beat.

use crate::SENSORS;
use crate::faults::Task;
use crate::periodic::{CONTROL_MS, Periodic, SAMPLE_MS};
use crate::shared::{Odometry, Ranges, Shared};
use robot::{RangeSensorBank, WheelEncoders};
use slam_core::RangeInput;

/// Reads the encoders for wheel-speed control and estimator.
pub async fn odometry(encoders: &mut impl WheelEncoders, shared: &Shared) -> ! {
    let mut beat = Periodic::every_ms(CONTROL_MS);
    loop {
        let time_us = beat.next().await.as_micros();
        match encoders.ticks() {
            Ok(ticks) => {
                let odometry = Odometry { time_us, ticks };
                shared.latest_odometry.lock(|latest| latest.set(odometry));
                shared.odometry.signal(odometry);
            }
            Err(_) => shared.faults.count(|faults| &mut faults.encoders_failed),
        }
        shared.reports.report(Task::Odometry);
    }
}

/// Reads the range sensors for the estimator. One that cannot be read is missing in the sample. When none gives a range and
/// some cannot be read, there is no sample, so that the drive task does not drive blind.
pub async fn sample<B: RangeSensorBank<SENSORS>>(bank: &mut B, shared: &Shared) -> ! {
    let mut beat = Periodic::every_ms(SAMPLE_MS);
    loop {
        let time_us = beat.next().await.as_micros();
        let mut failed = false;
        let ranges = bank.read().await.map(|reading| {
            reading.unwrap_or_else(|_| {
                failed = true;
                shared.faults.count(|faults| &mut faults.ranges_failed);
                RangeInput::Missing
            })
        });
        if !failed || ranges.iter().any(|range| *range != RangeInput::Missing) {
            shared.push_ranges(Ranges { time_us, ranges });
        }
        shared.reports.report(Task::Sample);
    }
}
