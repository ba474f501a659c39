//! What a reading says: which wall a beam met, what it should have read there, and the update (Rousse & Qiu eqs. 1, 3 and 5).

pub mod beam;
pub mod data_association;
pub mod derivatives;
pub mod first_estimates;
pub mod line_of_sight;
pub mod observe;
pub mod sensor;
pub mod slippage;

use first_estimates::Linearisation;

/// How readings are associated with walls, and what they are worth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MeasurementSettings {
    /// Association gate: largest squared innovation over its variance (chi-square with one degree of freedom).
    pub gate: f32,
    /// A reading near a wall may be of something else: it counts by the odds that it is the wall's.
    pub clutter: bool,
    /// At which estimates the models are differentiated.
    pub linearisation: Linearisation,
}

impl MeasurementSettings {
    pub(crate) const IDLE: Self = Self { gate: 0.0, clutter: false, linearisation: Linearisation::Latest };
}

impl Default for MeasurementSettings {
    fn default() -> Self {
        // 99.9 % of a chi-square distribution with one degree of freedom.
        Self { gate: 10.83, clutter: true, linearisation: Linearisation::default() }
    }
}
