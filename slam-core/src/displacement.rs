//! Moving the pose where the motion that it was predicted by turns out to have been another.

use crate::filter::ekf::{LEADING, MotionJacobian};
use crate::filter::layout::{self, THETA, X, Y};
use crate::geometry::angle::{sin_cos, wrap};
use crate::geometry::pose::Pose;
use crate::holds::claim::Correction;
use crate::jolts::Jolts;
use crate::jolts::recent::Moment;
use crate::jolts::search::{ELSE, Scene};
use crate::rig::DriveModel;
use crate::sample::RangeInput;
use crate::slam::Slam;
use crate::walls::map::Displaced;

/// The motion Jacobian of a robot that stays.
const UNMOVED: MotionJacobian = {
    let mut rows = [[0.0; LEADING]; 3];
    rows[X][X] = 1.0;
    rows[Y][Y] = 1.0;
    rows[THETA][THETA] = 1.0;
    rows
};

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Where the ranges tell that the robot drove the other way since it stopped, it is where that leads.
    pub(crate) fn turn_round(&mut self, inputs: &[RangeInput; S]) {
        if let Some(moved_m) = self.sign.tell(&self.rig.sensors, inputs) {
            self.displace(moved_m, [0.0; 2]);
        }
    }

    /// Where the readings tell that something moved the robot besides its wheels, it is there. What was seen meanwhile was
    /// seen from elsewhere and is forgotten as far as it waits to become a wall; the map is of another epoch. The search's variables are on the stack
    /// only while it runs.
    #[inline(never)]
    pub(crate) fn recover_from_jolt(&mut self, updated: bool, turns: usize) {
        let moment = Moment { map: layout::pose(&self.ekf), reckoned: self.drive.dead_reckoning.pose };
        let scene = Scene { ekf: &self.ekf, map: &self.map, sensors: &self.rig.sensors, others: self.jolts.others() };
        let Some(found) = self.jolts.search(&scene, &moment, updated, turns) else { return };
        // What moves a robot changes its readings.
        if self.finds_holds() && self.holds.is_unturned() {
            return;
        }
        let [x_m, y_m, turn_rad] = found.by;
        let Pose { x_m: x, y_m: y, theta_rad } = moment.map;
        let pose = Pose { x_m: x + x_m, y_m: y + y_m, theta_rad: theta_rad + turn_rad };
        self.put(pose, &found.covariance);
        self.holds.forget();
        self.map.begin_epoch_elsewhere(Displaced::Jolted);
        self.counters.add_jolt();
    }

    /// Whether holds are looked for: by the turning of wheels.
    fn finds_holds(&self) -> bool {
        self.config.motion.find_holds && matches!(self.rig.drive, DriveModel::Wheels { .. })
    }

    /// Where the readings tell that the robot does not move with its wheels, or does so again, it is where that leads.
    pub(crate) fn recover_from_hold(&mut self) {
        if !self.finds_holds() {
            return;
        }
        let confirmed = if self.holds.is_claimed() { self.confirm_hold() } else { None };
        let judged = || self.holds.judge(layout::pose(&self.ekf), self.counters.steps);
        let Some(found) = confirmed.or_else(judged) else { return };
        self.put(found.pose, &found.covariance());
        self.map.begin_epoch_elsewhere(Displaced::Held);
        self.jolts = Jolts::NONE;
        self.counters.add_hold(found.is_held);
    }

    /// Goes on with the confirmation of a hold.
    #[cold]
    fn confirm_hold(&mut self) -> Option<Correction> {
        let moment = Moment { map: layout::pose(&self.ekf), reckoned: self.drive.dead_reckoning.pose };
        let scene = Scene { ekf: &self.ekf, map: &self.map, sensors: &self.rig.sensors, others: ELSE };
        self.holds.confirm(&scene, self.jolts.recent(), &moment)
    }

    /// Puts the robot elsewhere in the map, as well known as before but for this covariance.
    fn put(&mut self, pose: Pose, covariance: &[[f32; 3]; 3]) {
        self.ekf.predict([pose.x_m, pose.y_m, pose.theta_rad], &UNMOVED, covariance);
        self.first.pose = pose;
        self.candidates.clear();
    }

    /// Moves the pose and the dead reckoning, and makes both less certain by a 1-sigma vector, both metres, in the frame of dead
    /// reckoning. Where they move, what waited to become a wall was seen from elsewhere, and is forgotten.
    pub(crate) fn displace(&mut self, moved_m: [f32; 2], sigma_m: [f32; 2]) {
        let pose = layout::pose(&self.ekf);
        let (s, c) = sin_cos(wrap(pose.theta_rad - self.drive.dead_reckoning.pose.theta_rad));
        let [moved, sigma] = [moved_m, sigma_m].map(|[x, y]| [c * x - s * y, s * x + c * y]);
        let pose = Pose { x_m: pose.x_m + moved[0], y_m: pose.y_m + moved[1], ..pose };
        let mut noise = [[0.0; 3]; 3];
        for (row, i) in noise.iter_mut().zip(sigma) {
            for (entry, j) in row.iter_mut().zip(sigma) {
                *entry = i * j;
            }
        }
        self.ekf.predict([pose.x_m, pose.y_m, pose.theta_rad], &UNMOVED, &noise);
        self.first.pose = pose;
        self.drive.displace(moved_m, sigma_m);
        if moved_m != [0.0; 2] {
            self.candidates.clear();
        }
        self.holds.forget();
    }
}
