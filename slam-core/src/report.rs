//! What became of each reading, and counts of everything refused.

/// Why a reading was not used by the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// Not a number, negative, over the converter's full scale, or of the wrong kind for the sensor.
    Invalid,
    /// Shorter than the sensor's minimum.
    TooNear,
    /// Longer than the sensor's maximum.
    TooFar,
    /// The floor voltage of an analogue sensor that sees nothing.
    Floor,
    /// The same reading as before, held by an analogue sensor.
    Held,
    /// Under the minimum range, folded back to a longer one.
    FoldBack,
    /// Meets a wall at an angle the sensor does not support.
    Incidence,
    /// Two walls explain it equally well, or it is near a wall's end and neither fits nor is clear of it. Or an analogue output has gone from one
    /// surface to another.
    Ambiguous,
    /// The innovation variance is not a positive number.
    Degenerate,
    /// The sensor is frozen: its output stays the same, whatever the robot does ([`Slam::is_frozen`](crate::Slam::is_frozen)).
    Frozen,
}

impl Refusal {
    /// Number of reasons.
    pub const COUNT: usize = 10;

    /// Every reason, in the order of [`Counters::refused`].
    pub const ALL: [Refusal; Self::COUNT] = [
        Self::Invalid,
        Self::TooNear,
        Self::TooFar,
        Self::Floor,
        Self::Held,
        Self::FoldBack,
        Self::Incidence,
        Self::Ambiguous,
        Self::Degenerate,
        Self::Frozen,
    ];
}

/// How the estimator is.
///
/// All but [`Health::Well`] and [`Health::Unexplained`] have begun the map anew ([`Counters::restarts`]). They last until
/// readings fit walls again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Health {
    /// Nothing speaks against the estimate.
    #[default]
    Well,
    /// Over 20 m of path no reading of hundreds fitted a wall.
    Unexplained,
    /// Over metres of path most readings were not of the wall that they should have met.
    Contradicted,
    /// The heading against the map is not known to a radian.
    Disoriented,
    /// A variance was not a positive number.
    Degenerate,
}

/// Why a hand-over was not taken over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotTaken {
    /// The filter was started anew, or took another one over, since its record began.
    Outdated,
    /// This filter cannot take one over: its walls have snapped directions, or there are too many.
    Unsupported,
    /// A number that is none, or a variance that is not positive.
    Unsound,
    /// Most walls in view lie to the robot otherwise than the filter sees them.
    Apart,
    /// The filter knows better than it where the robot is: by what was seen of walls that are new.
    LessSure,
}

impl NotTaken {
    /// Number of reasons.
    pub const COUNT: usize = 5;

    /// Every reason, in the order of [`Counters::not_taken`].
    pub const ALL: [NotTaken; Self::COUNT] =
        [Self::Outdated, Self::Unsupported, Self::Unsound, Self::Apart, Self::LessSure];
}

/// What became of one sensor's input in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// There was none.
    #[default]
    Missing,
    /// Refused at the door, or by association without being kept.
    Refused(Refusal),
    /// Used: one scalar update with this wall.
    Updated {
        /// Identifier of the wall.
        wall: u16,
        /// Innovation, metres.
        innovation_m: f32,
        /// Innovation variance, m^2.
        variance_m2: f32,
        /// Variance of the noise with which it was taken, m^2.
        noise_m2: f32,
    },
    /// Met this wall but fell outside the gate; kept in the outlier buffer.
    Gated {
        /// Identifier of the wall.
        wall: u16,
        /// Innovation, metres.
        innovation_m: f32,
        /// Innovation variance, m^2.
        variance_m2: f32,
    },
    /// Met no wall; kept in the outlier buffer.
    Unexplained,
}

/// One sensor's part of a [`StepReport`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReadingReport {
    /// What became of it.
    pub outcome: Outcome,
    /// The range, metres, corrected by the sensor's estimated gain, where the input was a valid one.
    pub range_m: Option<f32>,
    /// Where the beam ended in the map frame, metres, with the pose after the step.
    pub hit_m: Option<[f32; 2]>,
}

/// What one step did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport<const S: usize> {
    /// Time since the sample before, seconds; nought for the first.
    pub dt_s: f32,
    /// The readings, in the rig's order.
    pub readings: [ReadingReport; S],
    /// Walls born in this step.
    pub births: u8,
    /// Pairs of walls merged in this step.
    pub merges: u8,
    /// Walls removed in this step.
    pub prunes: u8,
    /// How the estimator is after it.
    pub health: Health,
}

/// What a stage did to the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Walls born.
    pub births: u8,
    /// Births refused because the map was full.
    pub refused: u8,
    /// Pairs of walls merged.
    pub merges: u8,
    /// Walls removed.
    pub prunes: u8,
}

impl<const S: usize> StepReport<S> {
    /// A step that did nothing.
    pub const NOTHING: Self = Self {
        dt_s: 0.0,
        readings: [ReadingReport { outcome: Outcome::Missing, range_m: None, hit_m: None }; S],
        births: 0,
        merges: 0,
        prunes: 0,
        health: Health::Well,
    };

    /// Readings that updated the estimate.
    pub(crate) fn updates(&self) -> u32 {
        self.readings.iter().filter(|reading| matches!(reading.outcome, Outcome::Updated { .. })).count() as u32
    }

    /// Adds what a stage did.
    pub(crate) fn add(&mut self, changes: &Changes) {
        self.births = self.births.saturating_add(changes.births);
        self.merges = self.merges.saturating_add(changes.merges);
        self.prunes = self.prunes.saturating_add(changes.prunes);
    }
}

fn count(counter: &mut u32, more: impl Into<u32>) {
    *counter = counter.saturating_add(more.into());
}

impl Counters {
    /// Counts a step.
    pub(crate) fn add_step(&mut self) {
        count(&mut self.steps, 1u8);
    }

    /// Counts a map that was begun anew.
    pub(crate) fn add_restart(&mut self) {
        count(&mut self.restarts, 1u8);
    }

    /// Counts a displacement that readings told.
    pub(crate) fn add_jolt(&mut self) {
        count(&mut self.jolts, 1u8);
    }

    /// Counts a second copy of the home that was given up, by whether it was turned.
    pub(crate) fn add_second_copy(&mut self, is_turned: bool) {
        count(if is_turned { &mut self.second_copies } else { &mut self.shifted_copies }, 1u8);
    }

    /// Counts a robot that is held from now on, and not one that no longer is.
    pub(crate) fn add_hold(&mut self, is_held: bool) {
        count(&mut self.holds, u8::from(is_held));
    }

    /// Counts a sensor that was found frozen.
    pub(crate) fn add_frozen(&mut self) {
        count(&mut self.frozen, 1u8);
    }

    /// Counts a sample whose motion, or time, cannot be, where this one's cannot.
    pub(crate) fn add_motion(&mut self, is_bad: bool) {
        count(&mut self.bad_motion, is_bad);
    }

    /// Counts what became of a reading.
    pub(crate) fn add_reading(&mut self, outcome: &Outcome) {
        match *outcome {
            Outcome::Missing => {}
            Outcome::Refused(refusal) => {
                if let Some(refused) = self.refused.get_mut(refusal as usize) {
                    count(refused, 1u8);
                }
            }
            Outcome::Updated { .. } => count(&mut self.updates, 1u8),
            Outcome::Gated { .. } => count(&mut self.gated, 1u8),
            Outcome::Unexplained => count(&mut self.unexplained, 1u8),
        }
    }

    /// Counts an outlier that was kept, and one that was overwritten by it.
    pub(crate) fn add_outlier(&mut self, overwrites: bool) {
        count(&mut self.buffered, 1u8);
        count(&mut self.overwritten, overwrites);
    }

    /// Counts what a stage did to the map.
    pub(crate) fn add_changes(&mut self, changes: &Changes) {
        count(&mut self.births, changes.births);
        count(&mut self.map_full, changes.refused);
        count(&mut self.merges, changes.merges);
        count(&mut self.prunes, changes.prunes);
    }

    /// Counts a hand-over that was taken over, or why it was not.
    pub(crate) fn add_hand_over(&mut self, judged: Result<(), NotTaken>) {
        match judged {
            Ok(()) => count(&mut self.taken_over, 1u8),
            Err(reason) => {
                if let Some(not_taken) = self.not_taken.get_mut(reason as usize) {
                    count(not_taken, 1u8);
                }
            }
        }
    }

    /// All zero.
    pub const ZERO: Self = Self {
        steps: 0,
        updates: 0,
        gated: 0,
        unexplained: 0,
        refused: [0; Refusal::COUNT],
        buffered: 0,
        overwritten: 0,
        births: 0,
        map_full: 0,
        merges: 0,
        prunes: 0,
        bad_motion: 0,
        restarts: 0,
        jolts: 0,
        second_copies: 0,
        shifted_copies: 0,
        holds: 0,
        taken_over: 0,
        not_taken: [0; NotTaken::COUNT],
        frozen: 0,
    };
}

/// Counts since the start. They saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Steps taken.
    pub steps: u32,
    /// Readings used in updates.
    pub updates: u32,
    /// Readings refused, by reason, in the order of [`Refusal::ALL`].
    pub refused: [u32; Refusal::COUNT],
    /// Readings outside the gate of the wall that they should have met.
    pub gated: u32,
    /// Readings that met no wall. With the updates, the refused and the gated ones these are all readings of all steps.
    pub unexplained: u32,
    /// Readings put into the outlier buffer: those gated or unexplained that moved on since their sensor's last one.
    pub buffered: u32,
    /// Buffered readings overwritten by newer ones before they became a wall.
    pub overwritten: u32,
    /// Walls born.
    pub births: u32,
    /// Births refused because the map was full.
    pub map_full: u32,
    /// Pairs of walls merged.
    pub merges: u32,
    /// Walls removed.
    pub prunes: u32,
    /// Samples with a time that did not increase, or a motion that was not a number, of the wrong kind or impossible.
    pub bad_motion: u32,
    /// Maps begun anew, with the calibration kept, because the estimator was unwell.
    pub restarts: u32,
    /// Displacements of the robot that its wheels did not tell and its readings did.
    pub jolts: u32,
    /// Times that the home was in the map twice, turned, and the second copy given up.
    pub second_copies: u32,
    /// The same of a part of it that was shifted, and not turned.
    pub shifted_copies: u32,
    /// Times that something held the robot while its wheels turned.
    pub holds: u32,
    /// Hand-overs of look backs that were taken over.
    pub taken_over: u32,
    /// Those that were not, by reason, in the order of [`NotTaken::ALL`].
    pub not_taken: [u32; NotTaken::COUNT],
    /// Times that a sensor was found frozen.
    pub frozen: u32,
}
