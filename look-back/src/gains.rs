//! The gains of the range sensors: what they report is gain times range.

use slam_core::Rig;
use slam_core::hand_over::MOST_GAINS;

use crate::group::Group;

/// Variance of a gain that is known.
const KNOWN: f32 = 1e-10;

/// What is known of each gain beforehand, and where it is likeliest.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// At present.
    pub values: [f32; MOST_GAINS],
    /// 1-sigma beforehand; nought where a gain is known.
    sigmas: [f32; MOST_GAINS],
}

impl Gains {
    /// Of no sensors; every byte is zero.
    pub const NONE: Self = Self { values: [0.0; MOST_GAINS], sigmas: [0.0; MOST_GAINS] };

    /// All known.
    pub const KNOWN: Self = Self { values: [1.0; MOST_GAINS], sigmas: [0.0; MOST_GAINS] };

    /// Of a rig's sensors.
    pub fn of_rig<const S: usize>(rig: &Rig<S>) -> Self {
        let mut gains = Self::KNOWN;
        for (sigma, sensor) in gains.sigmas.iter_mut().zip(&rig.sensors) {
            *sigma = sensor.gain_sigma;
        }
        gains
    }

    /// The gain of this sensor, and which of the unknown ones it is; none where it is known.
    pub fn of(&self, sensor: u8) -> Option<(usize, f32)> {
        let number = usize::from(sensor);
        let is_unknown = self.sigmas.get(number).is_some_and(|sigma| *sigma > 0.0);
        is_unknown.then(|| Some((number, *self.values.get(number)?)))?
    }

    /// Whether two groups' hits can be put together: those of one sensor, or of sensors whose gains are known.
    pub fn go_together(&self, a: &Group, b: &Group) -> bool {
        a.is_by_sensor_of(b) || (self.of(b.sensor()).is_none() && self.of(a.sensor()).is_none())
    }

    /// A group where its hits are by the present gains.
    pub fn correct(&self, group: &Group) -> Group {
        let Some((_, gain)) = self.of(group.sensor()) else { return *group };
        let inverse = 1.0 / gain;
        let [x, y] = [0, 1].map(|i| group.from_m[i] + inverse * (group.mean_m[i] - group.from_m[i]));
        let mut corrected = *group;
        corrected.mean_m = [x, y];
        corrected
    }

    /// A group as another sensor would have reported it: from then on it goes with that one's gain, and what it was to the own gain is
    /// what that is known to be at present.
    pub fn told_by(&self, sensor: u8, group: &Group) -> Group {
        let gain = |sensor| self.of(sensor).map_or(1.0, |(_, gain)| gain);
        let ratio = gain(sensor) / gain(group.sensor());
        let mean_m = [0, 1].map(|i| group.from_m[i] + ratio * (group.mean_m[i] - group.from_m[i]));
        let mut told = group.by_sensor(sensor);
        told.mean_m = mean_m;
        told
    }

    /// Weight and residual of what is known of each beforehand.
    pub fn prior(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        let weight = |sigma: f32| 1.0 / (sigma * sigma).max(KNOWN);
        self.values.iter().zip(self.sigmas).map(move |(value, sigma)| (weight(sigma), value - 1.0))
    }
}
