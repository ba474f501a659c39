//! The floor: how well the same readings locate the robot when map and calibration are given.
//!
//! A three-state EKF in the plan's frame. It knows every wall, every sensor's true gain, both wheels' true scales and
//! the true track; what is left are the noises and the readings' unknown age. No estimator that has to find all that out
//! can do better on the same drive.

use hal_sim::world::World;
use hal_sim::{Frame, Plan, Pose2, TrueCalibration};
use slam_core::{Adc, DriveModel, Motion, RangeInput, RangeModel, RangeSensor, Ticks};

use crate::track::Track;
use lab::input::rig_file::Robot;
use lab::recording::Step;

/// Mean time for which an analogue sensor holds a reading, and its 1-sigma from unit to unit, seconds.
const HOLD_S: (f64, f64) = (0.0383, 0.0055);

/// Gate: 99.9 % of a chi-square distribution with one degree of freedom.
const GATE: f64 = 10.83;

/// A beam is used when its neighbours this far to both sides meet the same wall, radians.
const ALONE_RAD: f64 = 0.02;

/// Localises the robot of a drive.
pub fn localise(plan: &Plan, robot: &Robot, calibration: &TrueCalibration, frames: &[Frame]) -> Track {
    let mut floor = Floor {
        world: World::new(plan),
        plan,
        robot,
        calibration,
        pose: plan.start,
        covariance: [[0.0; 3]; 3],
        ticks: None,
        increment: [0.0; 2],
        dt_s: 0.0,
        last_counts: vec![None; robot.rig.sensors.len()],
        track: Track::default(),
    };
    let mut nis_sum = 0.0;
    let mut last_us = None;
    for frame in frames {
        let time_us = frame.sample.time_us;
        floor.dt_s = (time_us - last_us.replace(time_us).unwrap_or(time_us)) as f64 * 1e-6;
        if let Motion::Ticks(ticks) = frame.sample.motion {
            floor.predict(ticks);
        }
        for sensor in 0..robot.rig.sensors.len() {
            if let Some(z) = floor.observe(sensor, frame.sample.ranges[sensor]) {
                nis_sum += z * z;
                floor.track.innovations.push((time_us as f64 * 1e-6, z));
            }
        }
        let step = floor.step(time_us as f64 * 1e-6);
        floor.track.steps.push(step);
    }
    let mut track = floor.track;
    let used = track.innovations.len();
    track.mean_nis = (used > 0).then(|| nis_sum / used as f64);
    track.reveal(frames);
    track
}

type Matrix = [[f64; 3]; 3];

struct Floor<'a> {
    world: World,
    plan: &'a Plan,
    robot: &'a Robot,
    calibration: &'a TrueCalibration,
    /// In the plan's frame.
    pose: Pose2,
    covariance: Matrix,
    ticks: Option<Ticks>,
    /// Last step: forward (metres) and turn (radians).
    increment: [f64; 2],
    dt_s: f64,
    last_counts: Vec<Option<u16>>,
    track: Track,
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed(a: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[j][i]))
}

impl Floor<'_> {
    fn predict(&mut self, ticks: Ticks) {
        let Some(last) = self.ticks.replace(ticks) else { return };
        let DriveModel::Wheels { track_m, metres_per_tick, noise_m2_per_m, .. } = self.robot.rig.drive else { return };
        let drive = &self.calibration.drive;
        let travel =
            |from: i32, to: i32, scale: f64| f64::from(to.wrapping_sub(from)) * f64::from(metres_per_tick) * scale;
        let left_m = travel(last.left, ticks.left, drive.scale_left);
        let right_m = travel(last.right, ticks.right, drive.scale_right);
        let track_m = f64::from(track_m) * drive.track;
        let forward_m = 0.5 * (left_m + right_m);
        let turn_rad = (right_m - left_m) / track_m;
        let (s, c) = (self.pose.theta_rad + 0.5 * turn_rad).sin_cos();
        self.increment = [forward_m, turn_rad];
        self.pose =
            Pose2::new(self.pose.x_m + forward_m * c, self.pose.y_m + forward_m * s, self.pose.theta_rad + turn_rad);
        let jacobian = [[1.0, 0.0, -forward_m * s], [0.0, 1.0, forward_m * c], [0.0, 0.0, 1.0]];
        self.covariance = times(&times(&jacobian, &self.covariance), &transposed(&jacobian));
        for (travel_m, side) in [(left_m, -1.0), (right_m, 1.0)] {
            let variance_m2 = f64::from(noise_m2_per_m) * travel_m.abs();
            let bend = side * 0.5 * forward_m / track_m;
            let by_travel = [0.5 * c - bend * s, 0.5 * s + bend * c, side / track_m];
            for i in 0..3 {
                for j in 0..3 {
                    self.covariance[i][j] += variance_m2 * by_travel[i] * by_travel[j];
                }
            }
        }
    }

    /// Updates with one reading; its innovation in standard deviations where it was used.
    fn observe(&mut self, index: usize, input: RangeInput) -> Option<f64> {
        let sensor = self.robot.rig.sensors[index];
        let gain = self.calibration.gains.get(index).copied()?;
        let reading = self.read(index, &sensor, input)?;
        let (age_s, age_sigma_s) = match sensor.model {
            RangeModel::Metric { .. } => (0.0, 0.0),
            RangeModel::Sharp { .. } => {
                let held_s = self.dt_s.min(HOLD_S.0);
                (0.5 * (HOLD_S.0 + held_s), (held_s * held_s / 12.0 + HOLD_S.1 * HOLD_S.1).sqrt())
            }
        };
        let (range_m, by_pose) = self.predicted(&sensor, age_s)?;
        let (innovation, slope, noise) = reading.compare(gain, range_m);
        let sigma_m = noise.sqrt() / slope.abs();
        let (min_m, max_m) = (f64::from(sensor.min_m), f64::from(sensor.max_m));
        if range_m * gain < min_m + (2.0 * sigma_m).max(0.15 * min_m) || range_m * gain > max_m - 2.0 * sigma_m {
            return None;
        }
        let row = by_pose.map(|derivative| slope * derivative);
        let [forward_m, turn_rad] = self.increment;
        let (s, c) = self.pose.theta_rad.sin_cos();
        let rate = if self.dt_s > 0.0 { 1.0 / self.dt_s } else { 0.0 };
        let drift = rate * (row[0] * forward_m * c + row[1] * forward_m * s + row[2] * turn_rad) * age_sigma_s;
        let gains: [f64; 3] = [0, 1, 2].map(|i| (0..3).map(|j| self.covariance[i][j] * row[j]).sum());
        let variance = (0..3).map(|i| row[i] * gains[i]).sum::<f64>() + noise + drift * drift;
        if innovation * innovation > GATE * variance {
            return None;
        }
        let [dx, dy, dtheta] = gains.map(|gain| gain * innovation / variance);
        self.pose = Pose2::new(self.pose.x_m + dx, self.pose.y_m + dy, self.pose.theta_rad + dtheta);
        for i in 0..3 {
            for j in 0..3 {
                self.covariance[i][j] -= gains[i] * gains[j] / variance;
            }
        }
        Some(innovation / variance.sqrt())
    }

    fn read(&mut self, index: usize, sensor: &RangeSensor, input: RangeInput) -> Option<Reading> {
        match (input, sensor.model) {
            (RangeInput::Counts(counts), RangeModel::Sharp { scale_m, exponent, noise_v }) => {
                let is_held = self.last_counts[index].replace(counts) == Some(counts);
                let Adc { bits, vref_v } = self.robot.rig.adc?;
                let volts = f64::from(counts) / ((1_u32 << bits.min(16)) - 1) as f64 * f64::from(vref_v);
                (!is_held && volts > 0.0).then_some(Reading::Volts {
                    volts,
                    scale_m: scale_m.into(),
                    exponent: exponent.into(),
                    noise_v: noise_v.into(),
                })
            }
            (RangeInput::Metres(metres), RangeModel::Metric { noise_m, noise_rel }) => {
                Some(Reading::Metres { metres: metres.into(), noise_m: noise_m.into(), noise_rel: noise_rel.into() })
            }
            _ => None,
        }
    }

    /// The true map's range for this sensor as it was `age_s` ago, and its derivatives by x, y and heading.
    fn predicted(&self, sensor: &RangeSensor, age_s: f64) -> Option<(f64, [f64; 3])> {
        let share = if self.dt_s > 0.0 { age_s / self.dt_s } else { 0.0 };
        let [forward_m, turn_rad] = self.increment.map(|motion| motion * share);
        let then = Pose2::new(0.0, 0.0, self.pose.theta_rad - turn_rad);
        let (s, c) = (self.pose.theta_rad - 0.5 * turn_rad).sin_cos();
        let arm_m = then.transform([sensor.mount.x_m.into(), sensor.mount.y_m.into()]);
        let origin_m = [self.pose.x_m - forward_m * c + arm_m[0], self.pose.y_m - forward_m * s + arm_m[1]];
        let bearing_rad = then.theta_rad + f64::from(sensor.mount.bearing_rad);
        let cast = |offset_rad: f64| {
            let (s, c) = (bearing_rad + offset_rad).sin_cos();
            self.world.cast(origin_m, [c, s])
        };
        let hit = cast(0.0)?;
        let face = hit.face?;
        let same = |offset_rad: f64| cast(offset_rad).and_then(|hit| hit.face) == Some(face);
        let steep = hit.cos_incidence < f64::from(sensor.max_incidence_rad).cos();
        if steep || !same(-ALONE_RAD) || !same(ALONE_RAD) {
            return None;
        }
        let n = self.plan.faces[face].normal();
        let (s, c) = bearing_rad.sin_cos();
        let along = c * n[0] + s * n[1];
        let across = c * n[1] - s * n[0];
        let arm = arm_m[0] * n[1] - arm_m[1] * n[0];
        Some((hit.range_m, [-n[0] / along, -n[1] / along, -(hit.range_m * across + arm) / along]))
    }

    /// The estimate in the start frame.
    fn step(&self, t_s: f64) -> Step {
        let start = self.plan.start;
        let pose = start.relative(&self.pose);
        let (s, c) = start.theta_rad.sin_cos();
        let turn = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]];
        let covariance = times(&times(&turn, &self.covariance), &transposed(&turn));
        Step { t_s, pose, covariance: covariance.map(|row| row.map(|value| value as f32)), ..Step::default() }
    }
}

/// What one sensor said.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reading {
    Volts { volts: f64, scale_m: f64, exponent: f64, noise_v: f64 },
    Metres { metres: f64, noise_m: f64, noise_rel: f64 },
}

impl Reading {
    /// Innovation against a predicted true range (metres), its derivative by that range, and the noise variance: in volts
    /// where the reading is in volts, since there the noise is constant.
    fn compare(&self, gain: f64, range_m: f64) -> (f64, f64, f64) {
        match *self {
            Self::Volts { volts, scale_m, exponent, noise_v } => {
                let expected_v = (gain * range_m / scale_m).powf(1.0 / exponent);
                (volts - expected_v, expected_v / (exponent * range_m), noise_v * noise_v)
            }
            Self::Metres { metres, noise_m, noise_rel } => {
                let sigma_m = noise_m.hypot(noise_rel * range_m);
                (metres - gain * range_m, gain, sigma_m * sigma_m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setting::Setting;

    fn floor<'a>(plan: &'a Plan, robot: &'a Robot, calibration: &'a TrueCalibration, pose: Pose2) -> Floor<'a> {
        Floor {
            world: World::new(plan),
            plan,
            robot,
            calibration,
            pose,
            covariance: [[0.0; 3]; 3],
            ticks: None,
            increment: [0.0; 2],
            dt_s: 0.04,
            last_counts: vec![None; robot.rig.sensors.len()],
            track: Track::default(),
        }
    }

    #[test]
    fn derivatives_are_those_of_the_cast_range() {
        let plan = hal_sim::plan_file::load("flat").expect("a built-in plan");
        let robot = Setting::default().robot().expect("a robot");
        let drive = hal_sim::TrueDrive { scale_left: 1.0, scale_right: 1.0, track: 1.0 };
        let calibration = TrueCalibration { gains: vec![1.0; 8], drive, scale_distance: 1.0, scale_turn: 1.0 };
        let at = Pose2::new(1.3, 0.9, 0.4);
        let range_m = |pose: Pose2, sensor: usize| {
            floor(&plan, &robot, &calibration, pose).predicted(&robot.rig.sensors[sensor], 0.0)
        };
        let mut compared = 0;
        for sensor in 0..8 {
            let Some((_, by_pose)) = range_m(at, sensor) else { continue };
            for (axis, derivative) in by_pose.into_iter().enumerate() {
                let moved = |by: f64| {
                    let mut step = [0.0; 3];
                    step[axis] = by;
                    let pose = Pose2::new(at.x_m + step[0], at.y_m + step[1], at.theta_rad + step[2]);
                    range_m(pose, sensor).expect("the same wall").0
                };
                let numeric = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((derivative - numeric).abs() < 1e-5, "{sensor} {axis}: {derivative} {numeric}");
                compared += 1;
            }
        }
        assert!(compared >= 12, "{compared}");
    }
}
