//! The drive of the robot: from a sample's motion input to the step that it made.

use crate::filter::ekf::EkfView;
use crate::geometry::angle::{sin_cos, wrap};
use crate::geometry::pose::Pose;
use crate::motion::dead_reckoning::DeadReckoning;
use crate::motion::mean_motion::MeanMotion;
use crate::motion::step::{self, Factor, Factors, STEADY_S, Step};
use crate::motion::travel::{Encoders, Travel};
use crate::motion::{MotionSettings, Slip};
use crate::rig::DriveModel;
use crate::sample::Motion;

/// Time over which the motion that factors multiply is averaged, seconds. The longer it is, the later the filter sees a turn that a
/// factor is to explain: for wheels, as long as they keep their speed. The noise of logged poses is up to a fifteenth of a step's square,
/// ten times a second: over a second it lowers the scales by a hundredth (tests/paces.rs).
const fn travel_s(model: &DriveModel) -> f32 {
    match model {
        DriveModel::Wheels { .. } => STEADY_S,
        DriveModel::Odometry { .. } => 1.0,
    }
}

/// Indices of the states that are a drive's calibration; a factor without one is known exactly.
#[derive(Clone, Copy, Debug)]
pub struct DriveStates {
    /// Scale of the left wheel, or of distance.
    pub first_scale: Option<u16>,
    /// Scale of the right wheel, or of turning.
    pub second_scale: Option<u16>,
    /// Factor of the track, or the veer.
    pub third: Option<u16>,
}

impl DriveStates {
    /// All factors known.
    pub const NONE: Self = Self { first_scale: None, second_scale: None, third: None };

    /// In the order of [`Step::by_factor`].
    pub fn in_order(&self) -> [Option<usize>; 3] {
        [self.first_scale, self.second_scale, self.third].map(|state| state.map(usize::from))
    }

    /// The factors as they are estimated.
    fn factors(&self, model: &DriveModel, ekf: &EkfView) -> Factors {
        let known = Factors::nominal(model);
        let factor =
            |state: Option<usize>, known: Factor| state.map_or(known, |i| Factor { value: ekf.mean(i), state });
        let [first, second, third] = self.in_order();
        Factors {
            first: factor(first, known.first),
            second: factor(second, known.second),
            third: factor(third, known.third),
        }
    }
}

/// How the wheels' motion is the robot's.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// The ranges tell that it is the other way.
    pub is_reversed: bool,
    /// The ranges tell that something holds the robot.
    pub is_held: bool,
    /// Factor of the variance of its noise, as it was learned.
    pub noise: f32,
}

/// The motion of the robot so far.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Which states its calibration is.
    pub states: DriveStates,
    encoders: Encoders,
    /// Mean motion as the wheels or the odometry say it, before the scales.
    travelled: MeanMotion,
    /// The last step.
    pub step: Step,
    /// The pose by the motion input alone, with the nominal calibration.
    pub nominal: Pose,
    /// The last step by the motion input and the nominal calibration, the way that the ranges tell, in the frame of where it began; with
    /// it what earlier ones turn out to have been otherwise.
    pub last_motion: Pose,
    /// The same, whether or not something holds the robot.
    pub turned: Pose,
    /// The pose by the motion input, with the calibration as estimated.
    pub dead_reckoning: DeadReckoning,
}

impl Drive {
    /// At the start.
    pub const START: Self = Self {
        states: DriveStates::NONE,
        encoders: Encoders::NEW,
        travelled: MeanMotion::STILL,
        step: Step::STILL,
        nominal: Pose::ORIGIN,
        last_motion: Pose::ORIGIN,
        turned: Pose::ORIGIN,
        dead_reckoning: DeadReckoning::START,
    };

    /// The travel since the last sample; none where the input is not a motion of this drive.
    pub fn travel(&mut self, model: &DriveModel, motion: &Motion, dt_s: f32) -> Option<Travel> {
        self.encoders.travel(model, motion, dt_s)
    }

    /// Moves on by a travel as it was logged, or by one that is lost, and returns the factors that the step was made with.
    pub fn advance(
        &mut self,
        model: &DriveModel,
        settings: &MotionSettings,
        logged: Option<Travel>,
        way: Way,
        dt_s: f32,
        ekf: &EkfView,
    ) -> Factors {
        let factors = self.states.factors(model, ekf);
        let driven = if way.is_reversed { logged.map(|travel| travel.reversed()) } else { logged };
        let step = match &driven {
            Some(travel) => {
                let step = self.real_step(model, settings, travel, dt_s, &factors);
                Step { noise: step.noise.map(|row| row.map(|entry| way.noise * entry)), ..step }
            }
            // However much wheels slip, a robot whose motion is not known goes no faster.
            None => self.step.lost(dt_s),
        };
        // What holds it gives way by what the wheels' noise is.
        let step = if way.is_held { Step { noise: step.noise, ..Step::STILL } } else { step };
        self.dead_reckoning.advance(&step);
        self.step = step;
        let nominal = |travel: Travel| step::step(model, &travel, &Factors::nominal(model));
        if let Some(travel) = logged {
            self.nominal = nominal(travel).applied_to(&self.nominal);
        }
        self.turned = driven.map_or(Pose::ORIGIN, |travel| nominal(travel).applied_to(&Pose::ORIGIN));
        self.last_motion = if way.is_held { Pose::ORIGIN } else { self.turned };
        factors
    }

    /// There is no motion in this step.
    pub fn rest(&mut self) {
        (self.step, self.last_motion) = (Step::STILL, Pose::ORIGIN);
    }

    /// The motion so far turns out to have been another: moves the dead reckoning by so much, metres, in its frame, as part of the last
    /// step, and makes it less certain by a 1-sigma vector.
    pub fn displace(&mut self, moved_m: [f32; 2], sigma_m: [f32; 2]) {
        self.dead_reckoning.displace(moved_m, sigma_m);
        let (s, c) = sin_cos(wrap(self.dead_reckoning.pose.theta_rad - self.last_motion.theta_rad));
        let Pose { x_m, y_m, theta_rad } = self.last_motion;
        let [x, y] = moved_m;
        self.last_motion = Pose { x_m: x_m + c * x + s * y, y_m: y_m + c * y - s * x, theta_rad };
    }

    /// The step that was travelled, as real floors and odometry make it.
    fn real_step(
        &mut self,
        model: &DriveModel,
        settings: &MotionSettings,
        travel: &Travel,
        dt_s: f32,
        factors: &Factors,
    ) -> Step {
        let mut step = step::step(model, travel, factors);
        if settings.slip == Slip::OfFloors {
            step = step.slipping();
        }
        if settings.mean_travel {
            let (now, memory_s) = (travel.of_body(model), travel_s(model));
            let before = self.travelled.expected(now, dt_s, memory_s);
            self.travelled.follow(now, dt_s, memory_s);
            // What is wrong with a logged pose goes on to the next: a mean without the present one has as much of it, and is later.
            let mean = match travel {
                Travel::Wheels { .. } => before,
                Travel::Body(_) => self.travelled.over(dt_s),
            };
            step.by_factor = step::step(model, &Travel::from_body(mean, model), factors).by_factor;
        }
        match travel {
            Travel::Wheels { .. } => step.unsteady(dt_s),
            Travel::Body(_) => step,
        }
    }
}
