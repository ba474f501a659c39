//! Scan-matching SLAM after Diosi and Kleeman 2005: a Kalman filter over the pose and the poses of stored scans, each observed by
//! matching. When scans are stored and matched is ours.

use nalgebra::Matrix3;

use crate::ekf::Ekf;
use crate::features::{add_pose, stored_pose};
use crate::geometry::{Point, Pose, Segment, perp, rotation};
use crate::psm::{Matched, Scan};
use crate::{Input, Output, Relative};

/// A scan is stored where none is nearer than this, metres and radians.
const STORE: (f64, f64) = (1.0, 1.0);
/// Way or turn between two matches, metres and radians.
const EVERY: (f64, f64) = (0.1, 0.1);
/// Stored scans that each scan is matched with.
const NEIGHBOURS: usize = 2;
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

    /// The stored scans by distance from the robot, the nearest first.
    fn near(&self) -> Vec<(f64, f64, usize)> {
        let pose = self.ekf.pose();
        let off = |(i, (at, _)): (usize, &(usize, Scan))| {
            let between = self.pose_of(*at).relative(&pose);
            (between.at.norm(), between.theta.abs(), i)
        };
        let mut near: Vec<_> = self.stored.iter().enumerate().map(off).collect();
        // A radian apart is as far as a metre: less of two scans is the same.
        near.sort_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1)));
        near
    }

    fn take(&mut self, scan: Scan, mount: Point) {
        let near = self.near();
        for (_, _, i) in near.iter().take(NEIGHBOURS).filter(|near| near.0 < 2.0 * STORE.0 && near.1 < 1.5) {
            let (at, reference) = &self.stored[*i];
            let laser = Pose { at: mount, theta: 0.0 };
            let inverse = Pose { at: -mount, theta: 0.0 };
            let guess = inverse.compose(&self.pose_of(*at).relative(&self.ekf.pose())).compose(&laser);
            let Some(Matched { pose, covariance }) = reference.find(&scan, &guess) else { continue };
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
        if near.first().is_none_or(|near| near.0 > STORE.0 || near.1 > STORE.1) {
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
