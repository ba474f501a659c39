//! Range sensors on a bus that report metres: each is asked in turn, while other tasks run.

use robot::{MetricSensor, RangeSensorBank};
use slam_core::RangeInput;

/// A bank of sensors that report metres, all of one kind.
#[derive(Debug)]
pub struct MetricBank<R, const N: usize>([R; N]);

impl<R, const N: usize> MetricBank<R, N> {
    /// These sensors, in the rig's order.
    pub fn new(sensors: [R; N]) -> Self {
        Self(sensors)
    }
}

impl<R: MetricSensor, const N: usize, const S: usize> RangeSensorBank<S> for MetricBank<R, N> {
    type Error = R::Error;

    async fn read(&mut self) -> [Result<RangeInput, R::Error>; S] {
        let mut ranges = [const { Ok(RangeInput::Missing) }; S];
        for (range, sensor) in ranges.iter_mut().zip(&mut self.0) {
            *range = sensor.range_m().await.map(|range_m| range_m.map_or(RangeInput::Missing, RangeInput::Metres));
        }
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::{block_on, yield_now};

    /// Answers after a while: a range, nothing, or a fault of the bus.
    #[derive(Clone, Copy)]
    struct Slow(Result<Option<f32>, ()>);

    impl MetricSensor for Slow {
        type Error = ();

        async fn range_m(&mut self) -> Result<Option<f32>, ()> {
            yield_now().await;
            self.0
        }
    }

    #[test]
    fn each_sensor_has_its_own_answer() {
        let mut bank = MetricBank::new([Slow(Ok(Some(0.5))), Slow(Err(())), Slow(Ok(None))]);
        let [first, second, third, absent] = block_on(RangeSensorBank::<4>::read(&mut bank));
        assert_eq!(
            [first, third, absent],
            [Ok(RangeInput::Metres(0.5)), Ok(RangeInput::Missing), Ok(RangeInput::Missing)]
        );
        assert_eq!(second, Err(()));
    }
}
