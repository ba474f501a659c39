//! A Sharp triangulation sensor (GP2Y0A family): what its output shows, and when.
//!
//! Timing. The sensor measures in cycles of 38.3 ms, 9.6 ms more or less from one unit to the next (each unit draws its
//! own period and phase), with a millisecond of jitter from cycle to cycle. During a cycle it integrates light; at the
//! cycle's end its output jumps to the new reading and holds it through the next cycle. A reading therefore shows
//! where the robot was in the middle of its cycle: when it is sampled it is half a period to one and a half periods
//! old.
//!
//! Output. The reported range is gain x true range; the voltage is the inverse of the rig's power law. Under the
//! minimum range the output falls again instead of rising (fold-back), so that a near wall reads like a far one. Far
//! walls, and walls met beyond the incidence limit, which return nothing, read as the floor voltage. Noise is constant
//! in volts and drawn once per reading. Supply spikes hit single conversions and only go up.

use slam_core::{Adc, RangeModel, RangeSensor};

use crate::options::SharpOptions;
use crate::rng::Rng;

/// The static curve of one sensor: true range in, volts out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpCurve {
    scale_m: f64,
    inverse_exponent: f64,
    fold_m: f64,
    floor_v: f64,
    gain: f64,
}

impl SharpCurve {
    /// The curve of a rig's sensor with its true gain; none when the sensor is not an analogue one.
    pub fn new(sensor: &RangeSensor, gain: f64, options: &SharpOptions) -> Option<Self> {
        let RangeModel::Sharp { scale_m, exponent, .. } = sensor.model else { return None };
        let mut curve = Self {
            scale_m: f64::from(scale_m),
            inverse_exponent: 1.0 / f64::from(exponent),
            fold_m: f64::from(sensor.min_m),
            floor_v: 0.0,
            gain,
        };
        curve.floor_v =
            options.floor_v.unwrap_or_else(|| curve.law(f64::from(sensor.max_m) * SharpOptions::FLOOR_RANGE_RATIO));
        Some(curve)
    }

    fn law(&self, range_m: f64) -> f64 {
        libm::pow(range_m / self.scale_m, self.inverse_exponent)
    }

    /// Output voltage, without noise, for a true range (metres); none: no light comes back.
    pub fn volts(&self, range_m: Option<f64>) -> f64 {
        let Some(range_m) = range_m else { return self.floor_v };
        let volts = if range_m < self.fold_m {
            let peak = self.law(self.gain * self.fold_m);
            peak * (0.35 + 0.65 * (range_m / self.fold_m).max(0.0))
        } else {
            self.law(self.gain * range_m)
        };
        volts.max(self.floor_v)
    }
}

/// Converter counts for a voltage.
pub fn counts(adc: Adc, volts: f64) -> u16 {
    let share = (volts / f64::from(adc.vref_v)).clamp(0.0, 1.0);
    libm::round(share * f64::from(adc.full_scale())) as u16
}

/// A first-order low-pass between a sensor and its converter, as a board has against the sensor's supply ripple.
#[derive(Clone, Debug)]
pub struct LowPass {
    time_constant_s: f64,
    volts: Option<f64>,
}

impl LowPass {
    /// With this time constant, seconds; zero: it passes everything.
    pub fn new(time_constant_s: f64) -> Self {
        Self { time_constant_s, volts: None }
    }

    /// The input was this for so long, seconds.
    pub fn follow(&mut self, input_v: f64, for_s: f64) {
        let share = if self.time_constant_s > 0.0 { 1.0 - libm::exp(-for_s / self.time_constant_s) } else { 1.0 };
        self.volts = Some(self.volts.map_or(input_v, |volts| volts + share * (input_v - volts)));
    }

    /// What the converter gets while the input is this.
    pub fn output_v(&self, input_v: f64) -> f64 {
        if self.time_constant_s > 0.0 { self.volts.unwrap_or(input_v) } else { input_v }
    }
}

/// The measuring cycle of one sensor.
#[derive(Clone, Debug)]
pub struct SharpCycle {
    period_s: f64,
    jitter_s: f64,
    middle_s: f64,
    end_s: f64,
    pending_v: Option<f64>,
    output_v: f64,
}

/// What the cycle needs next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CycleEvent {
    /// The middle of the integration, at this time (seconds): hand the light's voltage to [`SharpCycle::integrate`].
    Middle(f64),
    /// The output changed.
    Output,
}

impl SharpCycle {
    /// A sensor that was switched on long ago, in a random phase, still showing `output_v`.
    pub fn new(options: &SharpOptions, rng: &mut Rng, output_v: f64) -> Self {
        let period_s = options.period_s + rng.uniform(-1.0, 1.0) * options.period_spread_s;
        let begin_s = -rng.unit() * period_s;
        let end_s = begin_s + period_s;
        // A middle that lies before the start is integrated at the start.
        let middle_s = (begin_s + 0.5 * period_s).max(0.0);
        Self { period_s, jitter_s: options.jitter_s, middle_s, end_s, pending_v: None, output_v }
    }

    /// The next event up to `until_s`, if any.
    pub fn poll(&mut self, until_s: f64, rng: &mut Rng) -> Option<CycleEvent> {
        if self.pending_v.is_none() && self.middle_s <= until_s {
            return Some(CycleEvent::Middle(self.middle_s));
        }
        if self.end_s > until_s {
            return None;
        }
        let begin_s = self.end_s;
        if let Some(volts) = self.pending_v.take() {
            self.output_v = volts;
        }
        let period_s = (self.period_s + self.jitter_s * rng.gaussian()).max(0.5 * self.period_s);
        self.middle_s = begin_s + 0.5 * period_s;
        self.end_s = begin_s + period_s;
        Some(CycleEvent::Output)
    }

    /// The voltage that this cycle's light makes, noise included.
    pub fn integrate(&mut self, volts: f64) {
        self.pending_v = Some(volts);
    }

    /// Shows at once what was integrated last: for the start of a run.
    pub fn show_pending(&mut self) {
        if let Some(volts) = self.pending_v.take() {
            self.output_v = volts;
        }
    }

    /// The output now, volts.
    pub fn output_v(&self) -> f64 {
        self.output_v
    }

    /// When the output changes next, seconds.
    pub fn end_s(&self) -> f64 {
        self.end_s
    }
}
