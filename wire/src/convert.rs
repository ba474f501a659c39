//! Between frames and the estimator's types.

use robot::{FloorProgress, FloorState};

use crate::frames::{
    Calibration, Contacts, Estimate, Factor, Floor, Frozen, Health, Parameter, Range, SENSORS, Sample, SlamFaults,
    Wall, WallKind,
};
use slam_core::{Counters, Motion, RangeInput, Slam, Ticks, WallView};

impl Sample {
    /// The frame of an estimator's input, with as many of its ranges as a frame carries and no contact; none of one without encoder counts.
    pub fn of<const S: usize>(sample: &slam_core::Sample<S>) -> Option<Self> {
        let Motion::Ticks(Ticks { left, right }) = sample.motion else { return None };
        let ranges = sample.ranges.iter().take(SENSORS).map(|range| (*range).into()).collect();
        Some(Self {
            time_us: sample.time_us,
            left_ticks: left,
            right_ticks: right,
            ranges,
            contacts: Contacts::default(),
        })
    }

    /// The estimator's input. Sensors that the frame does not carry have no reading, and none has one of a robot that tilts or is off the floor.
    pub fn to_slam(&self) -> slam_core::Sample<SENSORS> {
        let mut ranges = [RangeInput::Missing; SENSORS];
        ranges.iter_mut().zip(&self.ranges).for_each(|(input, range)| *input = (*range).into());
        let motion = Motion::Ticks(Ticks { left: self.left_ticks, right: self.right_ticks });
        let sample = slam_core::Sample { time_us: self.time_us, motion, ranges };
        if self.contacts.lifted { sample.without_ranges() } else { sample }
    }
}

impl From<RangeInput> for Range {
    fn from(input: RangeInput) -> Self {
        match input {
            RangeInput::Missing => Self::Missing,
            RangeInput::Counts(counts) => Self::Counts(counts),
            RangeInput::Metres(metres) => Self::Metres(metres),
        }
    }
}

impl From<Range> for RangeInput {
    fn from(range: Range) -> Self {
        match range {
            Range::Missing => Self::Missing,
            Range::Counts(counts) => Self::Counts(counts),
            Range::Metres(metres) => Self::Metres(metres),
        }
    }
}

impl Estimate {
    /// What the estimator holds after the sample taken at this time, on time.
    pub fn of<const S: usize, const W: usize, const B: usize, const ROWS: usize>(
        slam: &Slam<S, W, B, ROWS>,
        time_us: u64,
    ) -> Self {
        let (slam_core::Estimate { pose, covariance: p }, dead_reckoning) = (slam.estimate(), slam.dead_reckoning());
        Self {
            time_us,
            pose: [pose.x_m, pose.y_m, pose.theta_rad],
            covariance: [p.m11, p.m12, p.m13, p.m22, p.m23, p.m33],
            alpha: slam.alpha().map(|(alpha_rad, sigma_rad)| [alpha_rad, sigma_rad]),
            dead_reckoning: [dead_reckoning.x_m, dead_reckoning.y_m, dead_reckoning.theta_rad],
            walls: u8::try_from(slam.walls().count()).unwrap_or(u8::MAX),
            health: slam.health().into(),
            epoch: slam.epoch(),
            late_us: 0,
        }
    }

    /// Whether every bit of the estimate is the same, whenever it was made; unlike `==` this also holds for values that are not numbers.
    pub fn same_bits(&self, other: &Self) -> bool {
        let bits =
            |e: &Self| (e.pose.map(f32::to_bits), e.covariance.map(f32::to_bits), e.dead_reckoning.map(f32::to_bits));
        let alpha = |e: &Self| e.alpha.map(|alpha| alpha.map(f32::to_bits));
        self.time_us == other.time_us
            && (self.walls, self.health, self.epoch) == (other.walls, other.health, other.epoch)
            && bits(self) == bits(other)
            && alpha(self) == alpha(other)
    }
}

impl From<FloorProgress> for Floor {
    fn from(progress: FloorProgress) -> Self {
        let FloorProgress { state, swept_m2, left_m2, seconds_in, .. } = progress;
        Self { state: state as u8, swept_m2, left_m2, seconds: seconds_in.into_iter().map(u32::from).sum() }
    }
}

impl Floor {
    /// What the robot is doing; none where it is newer than this program.
    pub fn state(&self) -> Option<FloorState> {
        FloorState::ALL.get(usize::from(self.state)).copied()
    }

    /// Share of the floor seen so far that is swept, 0 to 1.
    pub fn share(&self) -> f32 {
        let all_m2 = self.swept_m2 + self.left_m2;
        if all_m2 > 0.0 { self.swept_m2 / all_m2 } else { 0.0 }
    }
}

impl Wall {
    /// A wall of the map, number `index` of `of`.
    pub fn of(wall: &WallView, index: u8, of: u8) -> Self {
        Self {
            index,
            of,
            id: wall.id,
            kind: wall.kind.into(),
            rho_m: wall.rho_m,
            beta_rad: wall.beta_rad,
            lo_m: wall.lo_m,
            hi_m: wall.hi_m,
            sigma_rho_m: wall.sigma_rho_m,
            updates: wall.updates,
        }
    }
}

impl From<&Wall> for WallView {
    fn from(wall: &Wall) -> Self {
        Self {
            id: wall.id,
            kind: wall.kind.into(),
            rho_m: wall.rho_m,
            beta_rad: wall.beta_rad,
            lo_m: wall.lo_m,
            hi_m: wall.hi_m,
            sigma_rho_m: wall.sigma_rho_m,
            updates: wall.updates,
        }
    }
}

impl From<slam_core::WallKind> for WallKind {
    fn from(kind: slam_core::WallKind) -> Self {
        match kind {
            slam_core::WallKind::Free => Self::Free,
            slam_core::WallKind::Snapped => Self::Snapped,
            slam_core::WallKind::Grid => Self::Grid,
        }
    }
}

impl From<WallKind> for slam_core::WallKind {
    fn from(kind: WallKind) -> Self {
        match kind {
            WallKind::Free => Self::Free,
            WallKind::Snapped => Self::Snapped,
            WallKind::Grid => Self::Grid,
        }
    }
}

impl Calibration {
    /// The estimator's calibration; factors beyond the frame's room are left out.
    pub fn of<const S: usize, const W: usize, const B: usize, const ROWS: usize>(slam: &Slam<S, W, B, ROWS>) -> Self {
        let mut calibration = Self::default();
        for (parameter, estimate, sigma) in slam.calibration() {
            let factor = Factor { parameter: parameter.into(), estimate, sigma };
            if calibration.factors.push(factor).is_err() {
                break;
            }
        }
        calibration
    }
}

impl Frozen {
    /// The estimator's frozen sensors; none where it never found one.
    pub fn of<const S: usize, const W: usize, const B: usize, const ROWS: usize>(
        slam: &Slam<S, W, B, ROWS>,
    ) -> Option<Self> {
        (slam.counters().frozen > 0).then(|| Self { sensors: slam.frozen_sensors() })
    }
}

impl From<slam_core::Parameter> for Parameter {
    fn from(parameter: slam_core::Parameter) -> Self {
        match parameter {
            slam_core::Parameter::ScaleLeft => Self::ScaleLeft,
            slam_core::Parameter::ScaleRight => Self::ScaleRight,
            slam_core::Parameter::Track => Self::Track,
            slam_core::Parameter::ScaleDistance => Self::ScaleDistance,
            slam_core::Parameter::ScaleTurn => Self::ScaleTurn,
            slam_core::Parameter::Veer => Self::Veer,
            slam_core::Parameter::Gain(sensor) => Self::Gain(sensor),
        }
    }
}

impl From<Parameter> for slam_core::Parameter {
    fn from(parameter: Parameter) -> Self {
        match parameter {
            Parameter::ScaleLeft => Self::ScaleLeft,
            Parameter::ScaleRight => Self::ScaleRight,
            Parameter::Track => Self::Track,
            Parameter::ScaleDistance => Self::ScaleDistance,
            Parameter::ScaleTurn => Self::ScaleTurn,
            Parameter::Veer => Self::Veer,
            Parameter::Gain(sensor) => Self::Gain(sensor),
        }
    }
}

impl From<slam_core::Health> for Health {
    fn from(health: slam_core::Health) -> Self {
        match health {
            slam_core::Health::Well => Self::Well,
            slam_core::Health::Unexplained => Self::Unexplained,
            slam_core::Health::Contradicted => Self::Contradicted,
            slam_core::Health::Disoriented => Self::Disoriented,
            slam_core::Health::Degenerate => Self::Degenerate,
        }
    }
}

impl From<Health> for slam_core::Health {
    fn from(health: Health) -> Self {
        match health {
            Health::Well => Self::Well,
            Health::Unexplained => Self::Unexplained,
            Health::Contradicted => Self::Contradicted,
            Health::Disoriented => Self::Disoriented,
            Health::Degenerate => Self::Degenerate,
        }
    }
}

impl From<&Counters> for SlamFaults {
    fn from(counters: &Counters) -> Self {
        Self {
            steps: counters.steps,
            updates: counters.updates,
            refused: counters.refused,
            buffered: counters.buffered,
            overwritten: counters.overwritten,
            births: counters.births,
            map_full: counters.map_full,
            merges: counters.merges,
            prunes: counters.prunes,
            bad_motion: counters.bad_motion,
            restarts: counters.restarts,
        }
    }
}
