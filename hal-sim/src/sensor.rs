//! One simulated range sensor: what is true of it, and when its output shows what.

use slam_core::{RangeModel, RangeSensor};

use crate::options::SimOptions;
use crate::rng::Rng;
use crate::sharp::{LowPass, SharpCurve, SharpCycle};

/// One simulated range sensor.
#[derive(Clone, Debug)]
pub(crate) struct SimSensor {
    pub sensor: RangeSensor,
    /// Cosine of the incidence beyond which nothing comes back.
    pub cos_lost: f64,
    /// Reported range = gain x true range.
    pub gain: f64,
    /// Something is over it: it sees nothing.
    pub is_covered: bool,
    pub analogue: Option<Analogue>,
    pub noise: Rng,
    pub spikes: Rng,
}

/// What an analogue sensor has beyond one that reports metres.
#[derive(Clone, Debug)]
pub(crate) struct Analogue {
    pub curve: SharpCurve,
    pub output: Output,
    /// 1-sigma of the output, volts.
    pub noise_v: f64,
}

/// When an output shows what.
#[derive(Clone, Debug)]
pub(crate) enum Output {
    /// Readings of a measuring cycle, held, behind the board's low-pass.
    Cycle(SharpCycle, LowPass),
    /// Each conversion is a reading of how things were so many seconds before.
    Late(f64),
}

impl SimSensor {
    pub(crate) fn new(sensor: &RangeSensor, index: usize, options: &SimOptions, seed: u64) -> Self {
        let draw = Rng::stream(seed, "gain", index).gaussian();
        let gain = (1.0 + options.error_ratio * f64::from(sensor.gain_sigma) * draw).clamp(0.5, 1.5);
        let lost_rad = options.lost_beyond_rad.unwrap_or(f64::from(sensor.max_incidence_rad));
        let mut noise = Rng::stream(seed, "range-noise", index);
        let stated_v = match sensor.model {
            RangeModel::Sharp { noise_v, .. } => noise_v.into(),
            RangeModel::Metric { .. } => 0.0,
        };
        let sharp = &options.sharp;
        let analogue = SharpCurve::new(sensor, gain, sharp).map(|curve| Analogue {
            curve,
            output: match sharp.age {
                Some(age) => {
                    let off = Rng::stream(seed, "age", index).uniform(-1.0, 1.0);
                    Output::Late((age.mean_s + off * age.spread_s).max(0.0))
                }
                None => {
                    Output::Cycle(SharpCycle::new(sharp, &mut noise, curve.volts(None)), LowPass::new(sharp.filter_s))
                }
            },
            noise_v: sharp.noise_v.unwrap_or(stated_v),
        });
        let spikes = Rng::stream(seed, "spike", index);
        Self { sensor: *sensor, cos_lost: libm::cos(lost_rad), gain, is_covered: false, analogue, noise, spikes }
    }

    /// A new reading of this true range, volts; zero for a sensor that reports metres.
    pub(crate) fn volts(&mut self, range_m: Option<f64>) -> f64 {
        let Some(analogue) = &self.analogue else { return 0.0 };
        analogue.curve.volts(range_m) + analogue.noise_v * self.noise.gaussian()
    }
}
