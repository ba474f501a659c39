//! The estimator's side: what one step of the filter writes down.

use slam_core::hand_over::MOST_GAINS;
use slam_core::{
    BUILT_RELIEF_M, Displaced, Increment, JOLT, Outcome, Pose, RangeModel, RangeSensor, ReadingReport, SURFACE_M, Slam,
    StepReport,
};

use crate::diary::{Diary, Hit};
use crate::frame::{Frame, relative};
use crate::keyframe::Keyframe;
use crate::power::power;

/// Of so many readings of a sensor that reports metres, which say the same, one is one: as the estimator finds on real logs,
/// three to five. An analogue sensor's noise is new each time.
const ALIKE: f32 = 4.0;

/// Two readings of a sensor in a row that differ by less than this share are of one surface.
const SAME_SURFACE: f32 = 0.25;

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// Writes down what a filter's last step sensed, and what became of it. Where a look back `waits` for the last keyframe to be
    /// closed, the next one begins.
    pub fn record<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &Slam<S, WALLS, O, ROWS>,
        report: &StepReport<S>,
        waits: bool,
    ) {
        let moved = slam.last_motion();
        self.travel(&Increment { forward_m: moved.x_m, left_m: moved.y_m, turn_rad: moved.theta_rad });
        self.pass(slam, report.dt_s);
        match slam.lost_motion() {
            Some(by) => self.lose_motion(by, &slam.filter_pose()),
            None if waits || self.is_due() => self.begin_keyframe(&slam.filter_pose()),
            None => {}
        }
        if let Some(alpha_rad) = slam.filter_alpha() {
            self.grid(alpha_rad);
        }
        // One wall a step.
        self.asked = match slam.standing(self.asked.into()) {
            Some((id, standing)) => {
                self.stand(id, standing);
                self.asked.wrapping_add(1)
            }
            None => 0,
        };
        let robot = Frame::of(&slam.pose());
        for (number, (sensor, reading)) in slam.rig().sensors.iter().zip(&report.readings).enumerate() {
            let last_m = self.ranges_m.get_mut(number).map_or(0.0, |last_m| {
                let before_m = *last_m;
                *last_m = reading.range_m.unwrap_or(before_m);
                before_m
            });
            let known = Known { gain: slam.gain(number), last_m, output_level: slam.output_level() };
            if let Some(hit) = hit(&robot, &known, number as u8, sensor, reading) {
                self.hit(&hit);
            }
        }
    }
}

/// How well a robot knows where it was found, held or in a kept map: metres and radians, 1-sigma, over all motions in doubt. Left open
/// altogether, all that comes later could slide along the walls of before.
pub(crate) const FOUND: [f32; 2] = [0.5, 0.5];

/// By how much a jolt moves a robot beside what its wheels do: metres and radians, 1-sigma, over all motions in doubt.
const JOLTED_BY: [f32; 2] = [JOLT[0], JOLT[2]];

/// Whoever moved the robot, or held it while its wheels turned, is found out within such a path, metres.
const FOUND_OUT_M: f32 = 0.5;

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// The motion of the last step was lost: the robot, whose pose the filter has, is off by so much, 1-sigma, metres and radians. What was
    /// seen before it was seen from where the robot was.
    pub(crate) fn lose_motion(&mut self, by: [f32; 2], filter: &Pose) {
        self.drop_ahead();
        if let Some(last) = self.keyframes.last_mut() {
            last.lose(by);
        }
        self.begin_keyframe(filter);
    }

    /// The robot was found elsewhere in the same map: how it came there the odometry did not sense, nor what it did before that was
    /// found out. `filter` is the filter's pose there.
    pub(crate) fn go_on_elsewhere(&mut self, filter: &Pose, displaced: Displaced) {
        self.drop_ahead();
        let turned_rad = relative(&self.filter, filter).theta_rad - self.robot.pose().theta_rad;
        self.begin_keyframe(filter);
        self.revision = self.revision.wrapping_add(1);
        let here = self.keyframes.len().saturating_sub(1);
        if displaced == Displaced::Jolted && self.leave_wing(turned_rad, here) {
            return;
        }
        let Self { keyframes, calibration, .. } = self;
        let Some((here, before)) = keyframes.split_last_mut() else { return };
        let mut path_m = 0.0;
        let is_doubted = |key: &&Keyframe| {
            let is_near = path_m <= FOUND_OUT_M;
            path_m += key.path_m;
            is_near
        };
        let doubted = before.iter().rev().take_while(is_doubted).count();
        // Their variances add up to its own.
        let each = |sigmas: [f32; 2]| sigmas.map(|sigma| sigma / float::sqrtf(doubted as f32));
        let mut next = here.pose;
        for key in before.iter_mut().rev().take(doubted) {
            match displaced {
                // The readings by which it was found are in the diary, too: told twice, a jolt that was none would stay one.
                Displaced::Jolted => key.jolt(each(JOLTED_BY)),
                Displaced::Held => key.part_from(&next, calibration, each(FOUND)),
            }
            next = key.pose;
        }
    }
}

/// What is known of a sensor.
pub(crate) struct Known {
    /// Its gain.
    pub gain: f32,
    /// What it read last, metres.
    pub last_m: f32,
    /// Factor of the variance of its output, where it is an analogue one.
    pub output_level: f32,
}

/// What a reading ended on, seen from the robot; none where it ended on nothing.
pub(crate) fn hit(
    robot: &Frame,
    &Known { gain, last_m, output_level }: &Known,
    number: u8,
    sensor: &RangeSensor,
    reading: &ReadingReport,
) -> Option<Hit> {
    let wall = match reading.outcome {
        Outcome::Updated { wall, .. } => Some(wall),
        Outcome::Gated { .. } | Outcome::Unexplained => None,
        Outcome::Missing | Outcome::Refused(_) => return None,
    };
    let end_m = robot.seen(reading.hit_m?);
    let (variance_m2, alike) = match (reading.outcome, sensor.model) {
        // What an analogue reading is known to on its wall the filter has found: by what is learned of its output, its age and the wall's ends.
        (Outcome::Updated { noise_m2, .. }, RangeModel::Sharp { .. }) => (noise_m2, 1.0),
        _ => {
            let about_m = expected_m(sensor, reading, last_m)?;
            let (variance_m2, alike) = noise(&sensor.model, about_m, output_level);
            if wall.is_none() && is_cut_off(sensor, gain * about_m, variance_m2) {
                return None;
            }
            (variance_m2, alike)
        }
    };
    let [x, y] = [sensor.mount.x_m, sensor.mount.y_m];
    // What the sensor reported, before the filter's gain, where gains are found here, too.
    let reported = if usize::from(number) < MOST_GAINS { gain } else { 1.0 };
    let end_m = [x + reported * (end_m[0] - x), y + reported * (end_m[1] - y)];
    Some(Hit { from_m: [x, y], end_m, variance_m2, alike, sensor: number, wall })
}

/// Whether of a surface at this range only the readings of an analogue sensor that come out short are any: they would draw it near.
fn is_cut_off(sensor: &RangeSensor, range_m: f32, variance_m2: f32) -> bool {
    // Two sigmas, squared with their sign: a square root is more than the step has.
    let left_m = sensor.max_m - range_m;
    matches!(sensor.model, RangeModel::Sharp { .. }) && left_m * left_m.abs() < 4.0 * variance_m2
}

/// The range at which the noise of a reading that is of no wall is told, metres. That of an analogue one must not depend on the reading
/// itself: those that came out short would count for more than those that came out long, and every wall would be pulled towards the
/// robot. So it is what the sensor read last, on what seems to be the same surface.
pub(crate) fn expected_m(sensor: &RangeSensor, reading: &ReadingReport, last_m: f32) -> Option<f32> {
    let range_m = reading.range_m?;
    let is_analogue = matches!(sensor.model, RangeModel::Sharp { .. });
    Some(if is_analogue && (last_m - range_m).abs() < SAME_SURFACE * last_m { last_m } else { range_m })
}

/// Variance of a reading at this range, m^2, and of how many it is one.
fn noise(model: &RangeModel, range_m: f32, output_level: f32) -> (f32, f32) {
    match *model {
        RangeModel::Metric { noise_m, noise_rel } => {
            let rel_m = noise_rel * range_m;
            (noise_m * noise_m + rel_m * rel_m + BUILT_RELIEF_M * BUILT_RELIEF_M, ALIKE)
        }
        RangeModel::Sharp { scale_m, exponent, noise_v } => {
            let per_volt_m = range_m * power(range_m / scale_m, -1.0 / exponent);
            let own_m = exponent * per_volt_m * noise_v;
            (output_level * own_m * own_m + SURFACE_M * SURFACE_M, 1.0)
        }
    }
}
