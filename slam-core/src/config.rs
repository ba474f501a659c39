//! How the estimator works: the settings of its stages, whose defaults work.

use crate::births::BirthSettings;
use crate::measurement::MeasurementSettings;
use crate::motion::MotionSettings;
use crate::rig::{RangeModel, Rig, RigError};
use crate::sensing::SensingSettings;
use crate::walls::WallSettings;

/// Settings of the estimator, by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// How motion is predicted.
    pub motion: MotionSettings,
    /// What is learned of the errors of readings.
    pub sensing: SensingSettings,
    /// What walls are like, and what they hold.
    pub walls: WallSettings,
    /// How readings are associated with walls, and what they are worth.
    pub measurement: MeasurementSettings,
    /// How new walls are found.
    pub births: BirthSettings,
    /// What a look back finds while the robot drives is taken over. Walls hold the map frame then, whatever `walls` says: each
    /// hand-over turns the map about the start.
    pub hand_overs: bool,
}

impl Config {
    /// Of an estimator that has not started: every byte is zero.
    pub(crate) const IDLE: Self = Self {
        motion: MotionSettings::IDLE,
        sensing: SensingSettings::IDLE,
        walls: WallSettings::IDLE,
        measurement: MeasurementSettings::IDLE,
        births: BirthSettings::IDLE,
        hand_overs: false,
    };

    /// For rooms as they are built, where there is room for two states a wall.
    pub fn real_rooms() -> Self {
        Self {
            motion: MotionSettings::real_rooms(),
            sensing: SensingSettings::real_rooms(),
            walls: WallSettings::real_rooms(),
            measurement: MeasurementSettings::default(),
            births: BirthSettings::default(),
            hand_overs: false,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first that cannot be.
    pub fn validate(&self) -> Result<(), RigError> {
        let error = |key, allowed| Err(RigError { sensor: None, key, allowed });
        if !(1.0..=100.0).contains(&self.measurement.gate) {
            return error("gate", "a squared innovation of 1 to 100 times its variance");
        }
        if !(0.0..=0.5).contains(&self.walls.relief_m) {
            return error("relief_m", "a number from 0 to 0.5");
        }
        Ok(())
    }

    /// The same beside a back end: what that finds is taken over.
    #[must_use]
    pub fn with_hand_overs(self) -> Self {
        Self { hand_overs: true, ..self }
    }

    /// What suits the sensors: those that report metres see how walls stand off the grid, which the noise of an analogue
    /// one hides.
    pub fn for_rig<const S: usize>(rig: &Rig<S>) -> Self {
        let sees_it = rig.sensors.iter().any(|sensor| matches!(sensor.model, RangeModel::Metric { .. }));
        if sees_it { Self::real_rooms() } else { Self::default() }
    }
}
