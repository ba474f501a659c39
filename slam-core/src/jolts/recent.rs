//! The readings of the last moments as beams in the frame of dead reckoning.

use crate::filter::ekf::EkfView;
use crate::geometry::angle::{sin_cos, wrap};
use crate::geometry::pose::Pose;
use crate::measurement::beam::Beam;
use crate::measurement::sensor::Sensor;
use crate::motion::dead_reckoning::DeadReckoning;
use crate::rig::{RangeModel, RangeSensor};
use crate::sensing::latency::Timing;
use crate::sensing::range::{Noise, Reading};
use heapless::{Deque, Vec};

/// Readings that are kept: of half of eight sensors three quarters of a second.
pub const READINGS: usize = 20;

/// Steps are told apart by so many bits, for four more name the sensor in the same number: 25 a second come round after four months.
const STEPS: u32 = u32::MAX >> 4;

/// A reading as it was made.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Step in which it was made, modulo [`STEPS`] + 1, times sixteen, and index of its sensor: in one number they are kept twenty times.
    made: u32,
    /// Where the robot was then, in the frame of dead reckoning.
    pub from: Pose,
    /// Where its beam began, metres, and its unit vector, in the frame of dead reckoning.
    pub origin_m: [f32; 2],
    /// Unit vector of the beam.
    pub direction: [f32; 2],
    /// Range corrected by the sensor's gain, metres.
    pub range_m: f32,
    /// Standard deviation of the sensor's noise there, metres.
    pub sigma_m: f32,
}

impl Seen {
    /// A reading of this step.
    pub fn new(
        sensor: &Sensor,
        reading: &Reading,
        timing: &Timing,
        odometry: &DeadReckoning,
        ekf: &EkfView,
        step: u32,
    ) -> Self {
        let pose = &odometry.pose;
        let mount = sensor.state.mount_then(&sensor.limits.model, timing, ekf);
        let beam = mount.beam([pose.x_m, pose.y_m], sin_cos(pose.theta_rad));
        Self {
            made: step << 4 | sensor.index as u32 & 15,
            from: *pose,
            origin_m: beam.origin,
            direction: beam.direction,
            range_m: reading.range_m / sensor.state.gain(ekf),
            sigma_m: reading.sigma_m(),
        }
    }
}

/// Where the robot is, in the map and by dead reckoning.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// In the map.
    pub map: Pose,
    /// In the frame of dead reckoning.
    pub reckoned: Pose,
}

/// The last readings, oldest first.
#[derive(Clone, Debug)]
pub struct Recent(Deque<Seen, READINGS>);

/// A reading as a beam in the map.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// The beam, its arm from the robot's present position.
    pub beam: Beam,
    /// The reading.
    pub seen: Seen,
}

impl Recent {
    /// No readings.
    pub const NONE: Self = Self(Deque::new());

    /// Adds one; the oldest makes room.
    pub fn push(&mut self, seen: Seen) {
        if self.0.is_full() {
            let _ = self.0.pop_front();
        }
        let _ = self.0.push_back(seen);
    }

    /// Step of the oldest one, modulo [`STEPS`] + 1: all are from it on.
    pub fn oldest(&self) -> u32 {
        self.0.front().map_or(0, |seen| seen.made >> 4)
    }

    /// Those from this step on, in the map, of a robot that went as it is reckoned to have gone.
    pub fn since(&self, step: u32, moment: &Moment) -> Vec<Sighting, READINGS> {
        self.sightings(step, |seen| seen.in_map(moment))
    }

    /// The same of a robot that stood at this pose, whatever was reckoned.
    pub fn standing_since(&self, step: u32, pose: &Pose) -> Vec<Sighting, READINGS> {
        self.sightings(step, |seen| seen.in_map(&Moment { map: *pose, reckoned: seen.from }))
    }

    fn sightings(&self, step: u32, in_map: impl Fn(&Seen) -> Sighting) -> Vec<Sighting, READINGS> {
        let mut found = Vec::new();
        for seen in self.0.iter().filter(|seen| seen.is_since(step)) {
            // There is room for all that are kept.
            let _ = found.push(in_map(seen));
        }
        found
    }
}

impl Seen {
    /// Whether it was made in this step or after it, which was not two months ago.
    fn is_since(&self, step: u32) -> bool {
        (self.made >> 4).wrapping_sub(step) & STEPS <= STEPS / 2
    }

    /// Index of its sensor.
    pub fn sensor(&self) -> u8 {
        (self.made & 15) as u8
    }

    /// The reading of one of these sensors, as it is held against a prediction.
    pub fn reading(&self, sensors: &[RangeSensor]) -> Reading {
        let noise = match sensors.get(usize::from(self.sensor())).map(|sensor| &sensor.model) {
            // In units of the voltage read.
            Some(&RangeModel::Sharp { exponent, .. }) => {
                let relative = self.sigma_m / (exponent * self.range_m);
                Noise::Volts { variance_v2: relative * relative, volts: 1.0, scale_m: self.range_m, exponent }
            }
            _ => Noise::Metres { noise_m: self.sigma_m, noise_rel: 0.0 },
        };
        Reading { range_m: self.range_m, before_v: 0.0, noise }
    }

    /// As a beam in the map.
    fn in_map(&self, Moment { map, reckoned }: &Moment) -> Sighting {
        let (s, c) = sin_cos(wrap(map.theta_rad - reckoned.theta_rad));
        let rotate = |[x, y]: [f32; 2]| [c * x - s * y, s * x + c * y];
        let arm = rotate([self.origin_m[0] - reckoned.x_m, self.origin_m[1] - reckoned.y_m]);
        let origin = [map.x_m + arm[0], map.y_m + arm[1]];
        Sighting { beam: Beam { arm, origin, direction: rotate(self.direction) }, seen: *self }
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::pose::Pose;
    use crate::jolts::recent::{STEPS, Seen};

    #[test]
    fn steps_come_round_and_what_is_later_stays_later() {
        let seen = |step: u32| Seen {
            made: step << 4 | 3,
            from: Pose::ORIGIN,
            origin_m: [0.0; 2],
            direction: [1.0, 0.0],
            range_m: 1.0,
            sigma_m: 0.01,
        };
        for step in [20, STEPS - 5, STEPS, STEPS + 1, 5 * STEPS + 7, u32::MAX - 5] {
            assert!(
                seen(step).is_since(step) && seen(step + 5).is_since(step) && !seen(step - 1).is_since(step),
                "{step}"
            );
            assert!(!seen(step - 20).is_since(step) && seen(step).sensor() == 3);
        }
    }
}
