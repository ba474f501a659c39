//! When a reading was made: how the robot moved between then and now.
//!
//! An analogue sensor's reading is half a hold old when it comes out, and has been held for half a sampling period, or hold,
//! on average; a board's filter adds to that. A time-of-flight sensor measures for a while and waits to be asked; a log's rows
//! are stamped when they are written. So the age of readings is a state: what is older shows less of the robot's motion.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::geometry::angle::sin_cos;
use crate::geometry::pose::Pose;
use crate::motion::mean_motion::MeanMotion;
use crate::motion::step::Step;
use crate::rig::{RangeModel, Rig};
use crate::sample::Increment;
use crate::sensing::SensingSettings;
use crate::sensing::range::SHARP_HOLD_S;
use crate::sensing::stamps::Stamps;

/// How late a reading in metres may be before any tells, 1-sigma, seconds: time-of-flight sensors measure for 20 to 100 ms,
/// and wait to be asked.
const METRIC_SIGMA_S: f32 = 0.05;

/// Mean age of an analogue reading, and its 1-sigma, before any tells, seconds: uniform from 5 to 60 ms, which is a cycle of
/// the data sheet's GP2Y0A21YK0F (19 to 57 ms), one of a faster unit, or one behind a board's filter.
const ANALOGUE_S: (f32, f32) = (0.0325, 0.016);

/// What a late reading saw of the robot's motion is an average over this time, seconds: as long as readings in metres may be
/// late, and analogue ones are. The noise of encoders is too small to draw the age of those to zero.
const METRIC_PACE_S: f32 = 0.2;
const ANALOGUE_PACE_S: f32 = 0.04;

/// Weight of a new time between samples in the typical one.
const TYPICAL_SHARE: f32 = 1.0 / 32.0;

/// Sigma below which an age counts as settled, seconds.
const SETTLED_S: f32 = 1e-4;

/// How late readings are: of the sensors that report metres, where there are any, or of the analogue ones.
#[derive(Clone, Copy, Debug)]
pub struct Latency {
    /// Index of the state that is their age, seconds; none where that is not estimated.
    pub state: Option<usize>,
    /// How far each row is from that age.
    pub stamps: Stamps,
    of_metres: bool,
    /// Motion over the time that a reading may be late.
    pace: MeanMotion,
    /// Time between two samples, as a rule, seconds.
    typical_dt_s: f32,
}

impl Latency {
    /// Of the moment.
    pub const NONE: Self =
        Self { state: None, stamps: Stamps::EXACT, of_metres: false, pace: MeanMotion::STILL, typical_dt_s: 0.0 };

    /// Of this rig; `allot` adds a state, if it is wanted, with its mean and 1-sigma.
    pub fn new<const S: usize>(
        rig: &Rig<S>,
        settings: &SensingSettings,
        mut allot: impl FnMut(bool, f32, f32) -> Option<usize>,
    ) -> Self {
        let of_metres = rig.sensors.iter().any(|sensor| matches!(sensor.model, RangeModel::Metric { .. }));
        let (is_wanted, (mean_s, sigma_s)) = if of_metres {
            (settings.calibrate_latency, (0.0, METRIC_SIGMA_S))
        } else {
            (settings.calibrate_age && !rig.sensors.is_empty(), ANALOGUE_S)
        };
        let state = allot(is_wanted, mean_s, sigma_s);
        let stamps = Stamps::new(of_metres && settings.stamps && state.is_some(), allot);
        Self { state, stamps, of_metres, ..Self::NONE }
    }

    /// The state that is the age of this sensor's readings, if that is estimated.
    pub fn of(&self, model: &RangeModel) -> Option<usize> {
        self.state.filter(|_| matches!(model, RangeModel::Metric { .. }) == self.of_metres)
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
        self.pace.follow(moved, dt_s, if self.of_metres { METRIC_PACE_S } else { ANALOGUE_PACE_S });
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
    /// readings that agree with it. An analogue reading is never of the moment.
    pub fn settle(&self, ekf: &mut EkfView) {
        let (Some(latency), true, half_step_s) = (self.state, self.of_metres, 0.5 * self.typical_dt_s) else { return };
        let sigma_s = float::sqrtf(ekf.covariance(latency, latency).max(0.0));
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
    /// How late readings are.
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
            return Some(self.latency.pace.over(ekf.mean(age) + self.latency.stamps.offset_s(ekf)));
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
