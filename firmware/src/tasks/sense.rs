//! Encoders and range sensors, each at its own beat.

use crate::SENSORS;
use crate::faults::Task;
use crate::periodic::{CONTROL_MS, Periodic, SAMPLE_MS};
use crate::shared::{Odometry, Ranges, Shared};
use robot::{RangeSensorBank, WheelEncoders};

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

/// Reads the range sensors for the estimator.
pub async fn sample(bank: &mut impl RangeSensorBank<SENSORS>, shared: &Shared) -> ! {
    let mut beat = Periodic::every_ms(SAMPLE_MS);
    loop {
        let time_us = beat.next().await.as_micros();
        match bank.read() {
            Ok(ranges) => shared.push_ranges(Ranges { time_us, ranges }),
            Err(_) => shared.faults.count(|faults| &mut faults.ranges_failed),
        }
        shared.reports.report(Task::Sample);
    }
}
