//! How noisy the outputs of analogue sensors are.
//!
//! A data sheet says 12 mV, a real sensor has 65, and with a noise stated five times too small no wall is straight and no
//! reading fits. The outputs tell by themselves, before there is a wall: three readings that follow one another lie on a
//! line but for noise, and the second difference of white noise has six times its variance. Steps from one surface to
//! another are left out where they show; those that do not are few: so it is the median that is followed, by stochastic approximation (Robbins and Monro 1951).

/// Median of a squared standard normal variable.
const MEDIAN: f32 = 0.4549;

/// Changes of the factor by one reading: as many divided by the number of readings, between these.
const FIRST_CHANGES: f32 = 4.0;
const MOST_CHANGE: f32 = 0.2;
const LEAST_CHANGE: f32 = 0.005;

/// Readings after which the factor is known, to a third: twice as many as those that change it most.
const KNOWN_AFTER: u16 = 2 * (FIRST_CHANGES / MOST_CHANGE) as u16;

/// Largest factor of the stated noise, 1-sigma: a rig is assumed to state at least a sixth of the true one.
const MOST: f32 = 36.0;

/// The factor that is believed before it is known: by its logarithm in the middle, between that and what is stated.
const BELIEVED: f32 = 6.0;

/// Factor of the stated variance of outputs, for all sensors together.
#[derive(Clone, Copy, Debug)]
pub struct OutputNoise {
    /// The factor over what is believed, less one.
    above: f32,
    readings: u16,
    is_known: bool,
}

impl OutputNoise {
    /// Before any reading.
    pub const UNKNOWN: Self = Self { above: 0.0, readings: 0, is_known: false };

    /// Whether readings have begun to tell, and not told enough. A line through points that were taken for better than they are lies where the
    /// first few of them do, and is surer of its direction than it may be: until then no line is drawn.
    pub fn is_settling(&self) -> bool {
        self.readings > 0 && !self.is_known
    }

    /// The readings of a step were taken in. By how many times the standard deviations of earlier ones are larger than was said of
    /// them, once that is known.
    pub fn settle(&mut self) -> Option<f32> {
        if self.is_known || self.readings < KNOWN_AFTER {
            return None;
        }
        self.is_known = true;
        Some(float::sqrtf(self.factor() / BELIEVED))
    }

    /// The factor. It is never less than one: what a board's filter smooths does not become more certain, since the
    /// readings that follow are off by the same.
    pub fn factor(&self) -> f32 {
        if self.is_known { self.true_factor().max(1.0) } else { BELIEVED }
    }

    /// The factor as it is, less than one where readings that follow one another are smoother than stated.
    pub fn true_factor(&self) -> f32 {
        BELIEVED * (1.0 + self.above)
    }

    /// Takes note of a second difference of one sensor's outputs, volts, where that variance of an output is stated, V^2.
    pub fn note(&mut self, bend_v: f32, stated_v2: f32) {
        self.readings = self.readings.saturating_add(1);
        let change = (FIRST_CHANGES / f32::from(self.readings)).clamp(LEAST_CHANGE, MOST_CHANGE);
        let factor = self.true_factor();
        let is_more = bend_v * bend_v > MEDIAN * 6.0 * stated_v2 * factor;
        let factor = factor * if is_more { 1.0 + change } else { 1.0 - change };
        self.above = factor.clamp(1.0 / MOST, MOST) / BELIEVED - 1.0;
    }
}

/// The last outputs of one sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs {
    /// The latest and the one before, volts.
    last_v: [f32; 2],
    /// How many of them follow one another.
    count: u8,
}

impl Outputs {
    /// None yet.
    pub const NONE: Self = Self { last_v: [0.0; 2], count: 0 };

    /// The first one of a surface, volts.
    pub fn starting_at(volts: f32) -> Self {
        Self { last_v: [volts, 0.0], count: 1 }
    }

    /// How far the next output is from the last one, volts; none where there was none.
    pub fn step_to(&self, volts: f32) -> Option<f32> {
        (self.count >= 1).then_some(volts - self.last_v[0])
    }

    /// Their mean, volts; none where there was none.
    pub fn mean(&self) -> Option<f32> {
        let [last, before] = self.last_v;
        match self.count {
            0 => None,
            1 => Some(last),
            _ => Some(0.5 * (last + before)),
        }
    }

    /// Takes in the next output; its second difference, volts, where two came before it.
    pub fn push(&mut self, volts: f32) -> Option<f32> {
        let [last, before] = self.last_v;
        let bend_v = (self.count >= 2).then_some(volts - 2.0 * last + before);
        self.last_v = [volts, last];
        self.count = (self.count + 1).min(2);
        bend_v
    }
}
