//! The simulated range sensors as the robot's bank.

use core::convert::Infallible;
use firmware::SENSORS;
use robot::RangeSensorBank;
use slam_core::RangeInput;

/// The simulated bank with the robot's number of sensors.
pub struct Ranges(pub hal_sim::board::SimRanges);

impl RangeSensorBank<SENSORS> for Ranges {
    type Error = Infallible;

    async fn read(&mut self) -> [Result<RangeInput, Infallible>; SENSORS] {
        let wide = self.0.read().await;
        core::array::from_fn(|i| wide.get(i).copied().unwrap_or(Ok(RangeInput::Missing)))
    }
}
