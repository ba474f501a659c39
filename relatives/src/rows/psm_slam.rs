//! Scan-matching SLAM after Diosi and Kleeman 2005: a Kalman filter over the pose and the poses of stored scans, each observed by
//! matching. When scans are stored and matched is ours.

use nalgebra::Matrix3;

use crate::ekf::Ekf;
use crate::features::{add_pose, stored_pose};
use crate::geometry::{Point, Pose, Segment, perp, rotation};
use crate::psm::{Matched, Scan, VALID};
use crate::{Input, Output, Relative};

/// A scan is stored where none is nearer than this, metres and radians.
const STORE: (f64, f64) = (1.0, 1.0);
/// Way or turn between two matches, metres and radians.
const EVERY: (f64, f64) = (0.1, 0.1);
/// Stored scans farther away are not looked at, metres: what a laser reaches.
const FAR: f64 = 8.0;
/// 99 % of a chi-square distribution with three degrees of freedom.
const GATE: f64 = 11.34;

/// The filter and the stored scans, each with its place in it.
#[derive(Default)]
pub struct PsmSlam {
    ekf: Ekf,
    stored: Vec<(usize, Scan)>,
    since: (f64, f64),
}

impl PsmSlam {
    fn pose_of(&self, at: usize) -> Pose {
        let state = self.ekf.states::<3>(at);
        Pose::new(state[0], state[1], state[2])
    }

    /// Matches a scan with the stored one that shares most with it, so that little drifts, and with the oldest that shares enough,
    /// so that loops are closed: past the middle of a corridor that one may look the other way.
    fn take(&mut self, scan: Scan, mount: Point) {
        let (laser, inverse) = (Pose { at: mount, theta: 0.0 }, Pose { at: -mount, theta: 0.0 });
        let guess = |pose: Pose| inverse.compose(&pose).compose(&laser);
        let off: Vec<Pose> = self.stored.iter().map(|(at, _)| self.pose_of(*at).relative(&self.ekf.pose())).collect();
        let near = off.iter().enumerate().filter(|(_, off)| off.at.norm() < FAR);
        let shares: Vec<(usize, f64)> =
            near.map(|(i, off)| (i, self.stored[i].1.shared(&scan, &guess(*off)))).collect();
        let most = shares.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|most| most.0);
        let oldest =
            shares.iter().find(|(_, share)| *share > VALID).map(|oldest| oldest.0).filter(|i| Some(*i) != most);
        for i in most.into_iter().chain(oldest) {
            let (at, reference) = &self.stored[i];
            let between = self.pose_of(*at).relative(&self.ekf.pose());
            let Some(Matched { pose, covariance }) = reference.find(&scan, &guess(between)) else { continue };
            let pose = laser.compose(&pose).compose(&inverse);
            // The stored pose as the robot sees it, and its derivative by the match.
            let seen = pose.relative(&Pose::default());
            let mut by = -Matrix3::identity();
            by.fixed_view_mut::<2, 2>(0, 0).copy_from(&-rotation(-pose.theta));
            let arm = perp(seen.at);
            by[(0, 2)] = -arm.x;
            by[(1, 2)] = -arm.y;
            let observation = stored_pose(&self.ekf, *at, &seen, by * covariance * by.transpose());
            if self.ekf.distance(&observation) < GATE {
                self.ekf.update(&observation);
            }
        }
        if off.iter().all(|off| off.at.norm() > STORE.0 || off.theta.abs() > STORE.1) {
            let at = add_pose(&mut self.ekf);
            self.stored.push((at, scan));
        }
    }
}

impl Relative for PsmSlam {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.ekf.predict(&input.motion, &input.motion_cov);
        self.since = (self.since.0 + input.motion.at.norm(), self.since.1 + input.motion.theta.abs());
        if let Some(dense) = &input.dense
            && (self.stored.is_empty() || self.since.0 >= EVERY.0 || self.since.1 >= EVERY.1)
        {
            self.since = (0.0, 0.0);
            self.take(Scan::new(dense), dense.origin);
        }
        Output { pose: self.ekf.pose(), covariance: Some(self.ekf.pose_covariance()) }
    }

    fn walls(&self) -> Vec<Segment> {
        Vec::new()
    }

    fn bytes(&self) -> usize {
        self.ekf.bytes() + self.stored.iter().map(|(_, scan)| scan.bytes()).sum::<usize>()
    }
}
