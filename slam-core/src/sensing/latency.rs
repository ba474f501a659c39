//! When a reading was made: how the robot moved between then and now.
//!
//! An analogue sensor's reading is half a hold old when it comes out, and has been held for half a sampling period, or hold,
//! on average. A time-of-flight sensor measures for a while and waits to be asked; a log's rows are stamped when they are
//! written. The age of readings that come in metres is a state: what is older shows less of the robot's motion.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::geometry::angle::sin_cos;
use crate::geometry::pose::Pose;
use crate::motion::mean_motion::MeanMotion;
use crate::motion::step::Step;
use crate::rig::RangeModel;
use crate::sample::Increment;
use crate::sensing::range::SHARP_HOLD_S;

/// How late a reading may be before any tells, 1-sigma, seconds: time-of-flight sensors measure for 20 to 100 ms, and wait
/// to be asked.
pub const PRIOR_SIGMA_S: f32 = 0.05;

/// What a late reading saw of the robot's motion is an average over this time, seconds: as long as readings may be late.
const PACE_S: f32 = 0.2;

/// Of the typical time between samples each new one is so much.
const TYPICAL_SHARE: f32 = 1.0 / 32.0;

/// An age that is known better than this has been settled, seconds.
const SETTLED_S: f32 = 1e-4;

/// How late the readings of sensors that report metres are.
#[derive(Clone, Copy, Debug)]
pub struct Latency {
    /// Index of the state that is their age, seconds; none where they are taken to be of the moment.
    pub state: Option<usize>,
    /// Motion over the time that a reading may be late.
    pace: MeanMotion,
    /// Time between two samples, as a rule, seconds.
    typical_dt_s: f32,
}

impl Latency {
    /// Of the moment.
    pub const NONE: Self = Self { state: None, pace: MeanMotion::STILL, typical_dt_s: 0.0 };

    /// The state that is the age of this sensor's readings, if it reports metres and that is estimated.
    pub fn of(&self, model: &RangeModel) -> Option<usize> {
        self.state.filter(|_| matches!(model, RangeModel::Metric { .. }))
    }

    /// The motion that a late reading misses, per second of its age.
    pub fn rate(&self) -> Increment {
        self.pace.over(1.0)
    }

    /// Takes in the last step's motion and time.
    pub fn follow(&mut self, moved: Increment, dt_s: f32) {
        if self.state.is_none() {
            return;
        }
        self.pace.follow(moved, dt_s, PACE_S);
        // A pause is no typical step.
        let is_known = self.typical_dt_s > 0.0;
        let dt_s = if is_known { dt_s.min(2.0 * self.typical_dt_s) } else { dt_s };
        let share = if is_known { TYPICAL_SHARE } else { 1.0 };
        self.typical_dt_s += share * (dt_s - self.typical_dt_s);
    }

    /// Derivative of a hit in the odometry frame by the age of its reading, metres per second: the robot's motion, backwards.
    pub fn by_age(&self, model: &RangeModel, pose: &Pose, hit_m: [f32; 2]) -> [f32; 2] {
        if self.of(model).is_none() {
            return [0.0; 2];
        }
        let i = self.rate();
        let (s, c) = sin_cos(pose.theta_rad);
        let arm = [hit_m[0] - pose.x_m, hit_m[1] - pose.y_m];
        let moved_m = [
            c * i.forward_m - s * i.left_m - i.turn_rad * arm[1],
            s * i.forward_m + c * i.left_m + i.turn_rad * arm[0],
        ];
        moved_m.map(|m| -m)
    }

    /// Readings that are surely younger than half a step are of the moment, once that is known to a quarter of it. Within a
    /// step nobody stamped them; and since readings are taken for a wall's by what the filter expects, a small age finds
    /// readings that agree with it.
    pub fn settle(&self, ekf: &mut EkfView) {
        let (Some(latency), half_step_s) = (self.state, 0.5 * self.typical_dt_s) else { return };
        let sigma_s = libm::sqrtf(ekf.covariance(latency, latency).max(0.0));
        let is_known = sigma_s < 0.25 * half_step_s && ekf.mean(latency).abs() + 2.0 * sigma_s < half_step_s;
        if !is_known || sigma_s < SETTLED_S {
            return;
        }
        let mut jacobian = Jacobian::new();
        let _ = jacobian.push((latency, 1.0));
        // What is numerically impossible leaves the age as it is.
        if ekf.update(-ekf.mean(latency), &jacobian, 0.1 * SETTLED_S * SETTLED_S).is_ok() {
            ekf.set_mean(latency, 0.0);
        }
    }
}

/// When the readings of one step were made.
#[derive(Clone, Copy, Debug)]
pub struct Timing<'a> {
    /// Time since the last sample, seconds.
    pub dt_s: f32,
    /// What the robot did in it.
    pub step: &'a Step,
    /// How late readings in metres are.
    pub latency: &'a Latency,
}

impl Timing<'_> {
    /// An analogue sensor holds its readings, and there was time for it.
    fn holds(&self, model: &RangeModel) -> bool {
        matches!(model, RangeModel::Sharp { .. }) && self.dt_s > 0.0
    }

    /// The motion since a sensor's reading was made, in the robot's present frame; none where it is of the moment.
    pub fn motion_since(&self, model: &RangeModel, ekf: &EkfView) -> Option<Increment> {
        if let Some(age) = self.latency.of(model) {
            return Some(self.latency.pace.over(ekf.mean(age)));
        }
        if !self.holds(model) {
            return None;
        }
        let age_s = 0.5 * (SHARP_HOLD_S + self.dt_s.min(SHARP_HOLD_S));
        let Increment { forward_m, left_m, turn_rad } = self.step.increment;
        let share = age_s / self.dt_s;
        Some(Increment { forward_m: share * forward_m, left_m: share * left_m, turn_rad: share * turn_rad })
    }

    /// 1-sigma of the time at which an analogue reading was made, as a share of the last step: uniform within a sampling
    /// period or hold. Zero for a sensor that reports metres.
    pub fn uncertain_share(&self, model: &RangeModel) -> f32 {
        if !self.holds(model) {
            return 0.0;
        }
        const UNIFORM: f32 = 0.288_675_13; // 1 / sqrt(12)
        UNIFORM * self.dt_s.min(SHARP_HOLD_S) / self.dt_s
    }
}
