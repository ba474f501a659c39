//! Range sensors on a converter: a burst of conversions of each, reduced to one reading.
//!
//! Supply spikes on a Sharp sensor's output go up only, so the mean of a burst is biased: it takes the median.

use crate::SENSORS;
use core::cmp::Ordering;
use robot::RangeSensorBank;
use slam_core::RangeInput;

/// Conversions of each sensor in a burst.
pub const BURST: usize = 9;

/// An analogue-to-digital converter with the range sensors on its inputs.
pub trait Converter {
    /// What can go wrong.
    type Error;

    /// One conversion of the sensor with this index, counts.
    ///
    /// # Errors
    /// The conversion failed.
    fn convert(&mut self, sensor: usize) -> Result<u16, Self::Error>;
}

/// The one with no more than half of the others below or above it. A sort takes more flash than all the rest here.
fn median(counts: [u16; BURST]) -> u16 {
    let others = |this: u16, beyond: Ordering| counts.iter().filter(|&other| other.cmp(&this) == beyond).count();
    let is_median = |&this: &u16| others(this, Ordering::Less).max(others(this, Ordering::Greater)) <= BURST / 2;
    counts.iter().copied().find(is_median).unwrap_or_default()
}

/// A bank of analogue range sensors.
#[derive(Debug)]
pub struct BurstBank<C>(C);

impl<C: Converter> BurstBank<C> {
    /// The sensors of this converter.
    pub fn new(converter: C) -> Self {
        Self(converter)
    }
}

impl<C: Converter> RangeSensorBank<SENSORS> for BurstBank<C> {
    type Error = C::Error;

    async fn read(&mut self) -> [Result<RangeInput, C::Error>; SENSORS] {
        // Sensor by sensor in turn, so that a spike hits few conversions of each.
        let mut bursts = [const { Ok([0; BURST]) }; SENSORS];
        for round in 0..BURST {
            for (sensor, burst) in bursts.iter_mut().enumerate() {
                if let Ok(counts) = burst {
                    match self.0.convert(sensor) {
                        Ok(conversion) => counts[round] = conversion,
                        Err(error) => *burst = Err(error),
                    }
                }
            }
        }
        bursts.map(|burst| burst.map(|counts| RangeInput::Counts(median(counts))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::block_on;

    /// Sensor i shows 1000 + i, with noise of one count and a spike in every third conversion; one cannot be read.
    struct Spiky(u16);

    const DEAD: usize = 5;

    impl Converter for Spiky {
        type Error = ();

        fn convert(&mut self, sensor: usize) -> Result<u16, ()> {
            if sensor == DEAD {
                return Err(());
            }
            self.0 += 1;
            let spike = if self.0.is_multiple_of(3) { 900 } else { 0 };
            Ok(1000 + sensor as u16 + spike + self.0 % 2)
        }
    }

    #[test]
    fn spikes_do_not_reach_the_reading_and_a_dead_sensor_hides_no_other() {
        for (sensor, range) in block_on(BurstBank::new(Spiky(0)).read()).into_iter().enumerate() {
            if sensor == DEAD {
                assert_eq!(range, Err(()));
                continue;
            }
            let Ok(RangeInput::Counts(counts)) = range else { panic!("{range:?}") };
            assert!((1000..=1001).contains(&(counts - sensor as u16)), "sensor {sensor}: {counts}");
        }
    }
}
