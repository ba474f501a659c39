//! How late the readings of sensors that report metres are.
//!
//! A time-of-flight sensor measures for a while and waits to be asked; a log's rows are stamped when they are written. The
//! age of the readings is a state: what is older shows less of the robot's motion.

use crate::filter::ekf::Jacobian;
use crate::geometry::angle::sin_cos;
use crate::rig::RangeModel;
use crate::slam::Slam;

/// What a late reading saw of the robot's motion is an average over this time, seconds: as long as readings may be late.
const PACE_S: f32 = 0.2;

/// Of the typical time between samples each new one is so much.
const TYPICAL_SHARE: f32 = 1.0 / 32.0;

/// An age that is known better than this has been settled, seconds.
const SETTLED_S: f32 = 1e-4;

impl<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> Slam<S, W, B, NB, BLOCKS> {
    /// The state that is the age of this sensor's readings, if it reports metres and that is estimated.
    pub(crate) fn latency_of(&self, sensor: usize) -> Option<usize> {
        let reports_metres = matches!(self.rig.sensors.get(sensor)?.model, RangeModel::Metric { .. });
        self.layout.latency.filter(|_| reports_metres)
    }

    /// Takes in the last step's motion and time.
    pub(crate) fn keep_pace(&mut self) {
        if self.layout.latency.is_none() {
            return;
        }
        self.pace.follow(self.last_step.increment, self.dt_s, PACE_S);
        // A pause is no typical step.
        let dt_s = if self.typical_dt_s > 0.0 { self.dt_s.min(2.0 * self.typical_dt_s) } else { self.dt_s };
        let share = if self.typical_dt_s > 0.0 { TYPICAL_SHARE } else { 1.0 };
        self.typical_dt_s += share * (dt_s - self.typical_dt_s);
    }

    /// Derivative of a hit in the odometry frame by the age of its reading, metres per second: the robot's motion, backwards.
    pub(crate) fn by_latency(&self, sensor: usize, hit_m: [f32; 2]) -> [f32; 2] {
        if self.latency_of(sensor).is_none() {
            return [0.0; 2];
        }
        let (pose, i) = (self.odometry.pose, self.pace.over(1.0));
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
    pub(crate) fn settle_latency(&mut self) {
        let (Some(latency), half_step_s) = (self.layout.latency, 0.5 * self.typical_dt_s) else { return };
        let sigma_s = libm::sqrtf(self.ekf.covariance(latency, latency).max(0.0));
        let is_known = sigma_s < 0.25 * half_step_s && self.ekf.mean(latency).abs() + 2.0 * sigma_s < half_step_s;
        if !is_known || sigma_s < SETTLED_S {
            return;
        }
        let mut jacobian = Jacobian::new();
        let _ = jacobian.push((latency, 1.0));
        // What is numerically impossible leaves the age as it is.
        if self.ekf.update(-self.ekf.mean(latency), &jacobian, 0.1 * SETTLED_S * SETTLED_S).is_ok() {
            self.ekf.set_mean(latency, 0.0);
        }
    }
}
