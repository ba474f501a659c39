//! Four sensors that report metres, on a bus that other tasks do not wait for.

use crate::devices;
use embassy_futures::yield_now;
use firmware::SENSORS;
use firmware::metric::MetricBank;
use robot::rig::BuiltIn;
use robot::{MetricSensor, RangeSensorBank};
use slam_core::RangeInput;

/// The robot with these sensors.
pub const ROBOT: BuiltIn = BuiltIn::TimeOfFlight;

/// One sensor, by its place in the host's frame.
struct OnBus(usize);

/// The host shows something else than metres.
struct NoMetres;

impl MetricSensor for OnBus {
    type Error = NoMetres;

    async fn range_m(&mut self) -> Result<Option<f32>, NoMetres> {
        // The transfer is under way: the clock of the loop stands still, the other tasks go on.
        yield_now().await;
        match devices::ranges().get(self.0) {
            Some(RangeInput::Metres(metres)) => Ok(Some(*metres)),
            Some(RangeInput::Missing) => Ok(None),
            Some(RangeInput::Counts(_)) | None => Err(NoMetres),
        }
    }
}

/// Its range sensors.
pub fn bank() -> impl RangeSensorBank<SENSORS> {
    MetricBank::new([OnBus(0), OnBus(1), OnBus(2), OnBus(3)])
}
