//! From a range sensor's input to a reading: checks at the door, and the sensor's curve.

use crate::report::Refusal;
use crate::rig::{Adc, RangeModel, RangeSensor};
use crate::sample::RangeInput;
use crate::sensing::output_noise::{OutputNoise, Outputs};

/// A Sharp sensor makes a new reading every 38.3 +- 9.6 ms (GP2Y0A21YK0F data sheet, timing chart) and holds it.
pub const SHARP_HOLD_S: f32 = 0.0383;
/// Longest time for which it may hold one, from the same chart.
pub const SHARP_HOLD_MAX_S: f32 = 0.0479;

/// An output that steps by more than this share of itself, and by more than its noise, went from one surface to another:
/// light of both is in it, and what the board's filter kept of the first.
const SURFACE_STEP: f32 = 0.25;

/// Number of standard deviations of noise that such a step exceeds, too.
const STEP_SIGMAS: f32 = 4.0;

/// A wall's surface and a sensor's mount are true to this, metres (1-sigma): plaster, wallpaper, screws. It keeps a
/// sensor that is precise at close range from knowing more than there is to know.
pub const SURFACE_M: f32 = 0.003;

/// Share above a sensor's minimum range from which readings are used: the curve bends before it folds back, and a folded
/// reading looks like one just above the minimum.
pub const NEAR_SHARE: f32 = 0.15;

/// Under its minimum range an analogue sensor's output falls to about a third of its peak (GP2Y0A21YK0F and GP2Y0A02YK0F data sheets, output
/// over distance), which reads like so many times that range.
const FOLDED: f32 = 3.0;

/// Whether an analogue sensor is so near to a surface, for which it would report this, metres, that what it reports is folded back.
pub fn is_folded(sensor: &RangeSensor, expected_m: f32, range_m: f32) -> bool {
    let is_near = expected_m < (1.0 + NEAR_SHARE) * sensor.min_m && range_m < FOLDED * sensor.min_m;
    is_near && matches!(sensor.model, RangeModel::Sharp { .. })
}

/// A reading that passed the checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// What the sensor reports, metres: gain times true range.
    pub range_m: f32,
    /// The voltage that it read before on this surface, V, none where that is zero: the noise is the one of a reading there.
    pub before_v: f32,
    /// The noise as the sensor makes it.
    pub noise: Noise,
}

/// Noise of a reading, as a function of the range that was to be read.
///
/// The variance must not depend on the reading itself: readings that came out short would be trusted more than those
/// that came out long, and every wall would be pulled towards the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Constant in volts.
    Volts {
        /// Variance, V^2.
        variance_v2: f32,
        /// The voltage read, V.
        volts: f32,
        /// Range at one volt in the sensor's curve, metres.
        scale_m: f32,
        /// Power of the voltage in it; negative.
        exponent: f32,
    },
    /// A constant part and one proportional to range, in quadrature.
    Metres {
        /// Standard deviation, metres.
        noise_m: f32,
        /// Standard deviation per metre.
        noise_rel: f32,
    },
}

/// Measured minus predicted, and the noise variance at the prediction, both in metres of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted, metres.
    pub value_m: f32,
    /// Noise variance, m^2.
    pub noise_m2: f32,
}

impl Reading {
    /// Standard deviation at the reading itself, metres.
    pub fn sigma_m(&self) -> f32 {
        float::sqrtf(self.innovation(self.range_m).noise_m2)
    }

    /// Standard deviation where the surface was before, metres: for points that are weighed by it.
    #[inline(never)]
    pub fn sigma_about_m(&self) -> f32 {
        float::sqrtf(self.innovation(self.about_m()).noise_m2)
    }

    /// What the sensor reported before on this surface, metres, or else this.
    #[inline(never)]
    fn about_m(&self) -> f32 {
        match self.noise {
            Noise::Volts { scale_m, exponent, .. } if self.before_v > 0.0 => {
                scale_m * float::powf(self.before_v, exponent)
            }
            _ => self.range_m,
        }
    }

    /// The range without what noise adds to it on average, metres: the curve bends, so that the range of a voltage that is as often too
    /// high as too low is too long.
    pub fn mean_m(&self) -> f32 {
        match self.noise {
            Noise::Volts { variance_v2, volts, exponent, .. } => {
                self.range_m * (1.0 - 0.5 * exponent * (exponent - 1.0) * variance_v2 / (volts * volts))
            }
            Noise::Metres { .. } => self.range_m,
        }
    }

    /// Whether of readings of this surface only the short ones come, since the long ones are beyond the sensor's largest range, metres.
    pub fn is_cut_off(&self, max_m: f32) -> bool {
        matches!(self.noise, Noise::Volts { .. }) && self.about_m() + 2.0 * self.sigma_about_m() > max_m
    }

    /// The innovation against a predicted report (gain times range), metres.
    ///
    /// For a voltage the comparison is made in volts, where the noise is Gaussian and constant, and scaled back to
    /// metres at the prediction. The curve V(r) is expanded around the reading to second order, in the ratio
    /// x = predicted / read - 1.
    #[inline(never)]
    pub fn innovation(&self, predicted_m: f32) -> Innovation {
        match self.noise {
            Noise::Volts { variance_v2, volts, exponent, .. } => {
                // V(r) / V = (1 + x)^p with p = 1 / exponent.
                let p = 1.0 / exponent;
                let x = (predicted_m / self.range_m - 1.0).clamp(-0.5, 0.5);
                let curvature = 0.5 * (p - 1.0);
                let drop = p * x * (1.0 + curvature * x * (1.0 + (p - 2.0) * (1.0 / 3.0) * x));
                let slope = p * (1.0 + (p - 1.0) * x * (1.0 + (p - 2.0) * 0.5 * x));
                // dV/dr at the prediction, V/m; negative.
                let volts_per_m = volts * slope / self.range_m;
                let value_m = -volts * drop / volts_per_m;
                Innovation { value_m, noise_m2: variance_v2 / (volts_per_m * volts_per_m) }
            }
            Noise::Metres { noise_m, noise_rel } => {
                let proportional = noise_rel * predicted_m;
                Innovation {
                    value_m: self.range_m - predicted_m,
                    noise_m2: noise_m * noise_m + proportional * proportional,
                }
            }
        }
    }
}

/// Most times that an output is counted.
const MOST_TIMES: u8 = 100;

/// What one sensor's inputs were so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrontEnd {
    last_counts: u16,
    /// How often it came though the sensor had time for another one; none where nothing was read.
    times: u8,
    /// What it says stays the same, whatever the robot does.
    pub is_frozen: bool,
    /// Time since `last_counts` was first seen, seconds.
    age_s: f32,
    /// Last accepted range, none where that is zero, and the path length then, metres.
    last_m: (f32, f32),
    /// Path length at which the output was seen to fold back, metres; none where that is zero.
    folded_at_m: f32,
    outputs: Outputs,
}

impl FrontEnd {
    /// Nothing read yet.
    pub const NEW: Self = Self {
        last_counts: 0,
        times: 0,
        is_frozen: false,
        age_s: 0.0,
        last_m: (0.0, 0.0),
        folded_at_m: 0.0,
        outputs: Outputs::NONE,
    };

    /// How often the last output came again, give or take a count, though the sensor had time for another one.
    pub fn repeats(&self) -> u8 {
        self.times.saturating_sub(1)
    }

    /// Checks one input and converts it.
    ///
    /// `path_m` is the robot's path length so far.
    ///
    /// # Errors
    /// Why it is no reading.
    pub fn read(
        &mut self,
        sensor: &RangeSensor,
        adc: Option<&Adc>,
        input: RangeInput,
        dt_s: f32,
        path_m: f32,
        noise: &mut OutputNoise,
    ) -> Result<Reading, Refusal> {
        if self.is_frozen {
            return Err(Refusal::Frozen);
        }
        match (input, &sensor.model, adc) {
            (RangeInput::Counts(counts), &RangeModel::Sharp { scale_m, exponent, noise_v }, Some(adc)) => {
                let volts = self.new_output(adc, counts, dt_s)?;
                let range_m = scale_m * float::powf(volts, exponent);
                let before = self.outputs;
                let (variance_v2, is_step) = self.output_variance(sensor, adc, volts, range_m, noise_v, noise)?;
                let before_v = before.mean().unwrap_or(0.0);
                let reading =
                    Reading { range_m, before_v, noise: Noise::Volts { variance_v2, volts, scale_m, exponent } };
                if let Err(refusal) = self.check_fold(sensor, &reading, path_m) {
                    // No surface is where that seems to be: nothing can have stepped from it.
                    self.outputs = Outputs::NONE;
                    return Err(refusal);
                }
                self.last_m = (range_m, path_m);
                if is_step { Err(Refusal::Ambiguous) } else { Ok(reading) }
            }
            (RangeInput::Metres(range_m), &RangeModel::Metric { noise_m, noise_rel }, _) => {
                if !range_m.is_finite() || range_m < 0.0 {
                    return Err(Refusal::Invalid);
                }
                in_limits(sensor, range_m)?;
                Ok(Reading { range_m, before_v: 0.0, noise: Noise::Metres { noise_m, noise_rel } })
            }
            _ => Err(Refusal::Invalid),
        }
    }

    /// The path is counted anew from what it is by now, metres; a fold from here.
    pub fn count_anew(&mut self, path_m: f32) {
        self.last_m.1 -= path_m;
        self.folded_at_m = self.folded_at_m.min(f32::MIN_POSITIVE);
    }

    /// The output of a sensor that holds its readings, volts, where it is a new one.
    fn new_output(&mut self, adc: &Adc, counts: u16, dt_s: f32) -> Result<f32, Refusal> {
        if u32::from(counts) > adc.full_scale() {
            return Err(Refusal::Invalid);
        }
        // One count of converter noise on a held output is still the same reading.
        let repeats = self.times > 0 && counts.abs_diff(self.last_counts) <= 1;
        self.age_s += dt_s;
        if !repeats {
            self.times = 0;
        } else if self.age_s < SHARP_HOLD_MAX_S {
            return Err(Refusal::Held);
        }
        self.times = (self.times + 1).min(MOST_TIMES);
        self.last_counts = counts;
        self.age_s = 0.0;
        if counts == 0 { Err(Refusal::Floor) } else { Ok(f32::from(counts) * adc.lsb_v()) }
    }

    /// Variance of an output, V^2, where it is one of a surface within the sensor's limits, and whether that is another one
    /// than the last output's.
    fn output_variance(
        &mut self,
        sensor: &RangeSensor,
        adc: &Adc,
        volts: f32,
        range_m: f32,
        noise_v: f32,
        noise: &mut OutputNoise,
    ) -> Result<(f32, bool), Refusal> {
        // An output under that of twice the maximum range carries no range at all.
        let is_floor = range_m > 2.0 * sensor.max_m;
        if let Err(refusal) = if is_floor { Err(Refusal::Floor) } else { in_limits(sensor, range_m) } {
            self.outputs = Outputs::NONE;
            return Err(refusal);
        }
        // A quantisation step adds a uniform error.
        let stated_v2 = noise_v * noise_v + adc.lsb_v() * adc.lsb_v() * (1.0 / 12.0);
        let largest_v = STEP_SIGMAS * float::sqrtf(2.0 * noise.factor() * stated_v2) + SURFACE_STEP * volts;
        let is_step = self.outputs.step_to(volts).is_some_and(|step_v| step_v.abs() > largest_v);
        if is_step {
            self.outputs = Outputs::starting_at(volts);
        } else if let Some(bend_v) = self.outputs.push(volts) {
            noise.note(bend_v, stated_v2);
        }
        Ok((noise.factor() * stated_v2, is_step))
    }

    /// Under its minimum range the output falls again and reads like a longer range. One sample cannot tell: the way
    /// there can. The range had come so near that the robot's motion could have taken it under the minimum, and then it
    /// grew by more than that motion explains. It is believed again once it has come down to where it left, or once the
    /// robot is far enough for anything to have changed.
    #[inline(never)]
    fn check_fold(&mut self, sensor: &RangeSensor, reading: &Reading, path_m: f32) -> Result<(), Refusal> {
        let noise_m = 3.0 * reading.sigma_m();
        if self.folded_at_m > 0.0 {
            let near = reading.range_m <= sensor.min_m + noise_m;
            if !near && path_m - self.folded_at_m < 2.0 * sensor.min_m {
                return Err(Refusal::FoldBack);
            }
            self.folded_at_m = 0.0;
        } else if self.last_m.0 > 0.0 {
            let (last_m, last_path_m) = self.last_m;
            let motion_m = path_m - last_path_m;
            let could_be_under = last_m - motion_m - noise_m < sensor.min_m;
            if could_be_under && reading.range_m > last_m + motion_m + noise_m {
                // Zero is none.
                self.folded_at_m = path_m + f32::MIN_POSITIVE;
                return Err(Refusal::FoldBack);
            }
        }
        Ok(())
    }
}

fn in_limits(sensor: &RangeSensor, range_m: f32) -> Result<(), Refusal> {
    if range_m < sensor.min_m {
        Err(Refusal::TooNear)
    } else if range_m > sensor.max_m {
        Err(Refusal::TooFar)
    } else {
        Ok(())
    }
}

impl Adc {
    /// Counts at the reference voltage.
    pub fn full_scale(&self) -> u32 {
        (1u32 << self.bits.min(16)) - 1
    }

    /// Volts of so many counts.
    pub fn volts(&self, counts: u16) -> f32 {
        f32::from(counts) * self.lsb_v()
    }

    /// Volts of one count.
    fn lsb_v(&self) -> f32 {
        self.vref_v / self.full_scale() as f32
    }
}
