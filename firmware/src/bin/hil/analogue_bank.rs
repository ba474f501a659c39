//! Eight analogue sensors behind a converter.

use crate::devices;
use core::convert::Infallible;
use firmware::SENSORS;
use robot::RangeSensorBank;
use robot::rig::BuiltIn;
use slam_core::RangeInput;

/// The robot with these sensors.
pub const ROBOT: BuiltIn = BuiltIn::Sharp;

/// What the host shows of the converter.
struct Converter;

impl RangeSensorBank<SENSORS> for Converter {
    type Error = Infallible;

    async fn read(&mut self) -> [Result<RangeInput, Infallible>; SENSORS] {
        devices::ranges().map(Ok)
    }
}

/// Its range sensors.
pub fn bank() -> impl RangeSensorBank<SENSORS> {
    Converter
}
