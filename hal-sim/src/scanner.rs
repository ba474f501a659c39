//! Scanners beside a rig's sensors: a laser with many rays, and a ring of sonar cones.
//!
//! A drive is recorded with the rig's own sensors; a scanner then looks along its true path. So another sensor sees the very
//! same drive, and nothing of the drive changes.

use core::f64::consts::{PI, TAU};

use crate::plan::Plan;
use crate::pose::Pose2;
use crate::rng::Rng;
use crate::world::World;

/// What a scanner is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScannerKind {
    /// So many rays over the half circle ahead, as a SICK LMS with 181 has; up to 8 m, 2 cm.
    Laser(usize),
    /// A ring of 16 ultrasonic cones of 25 degrees (Polaroid), up to 4 m, 1 cm. A wall answers where a part of the cone
    /// meets it within 20 degrees of its normal; an edge always does; the nearest answer counts.
    Sonar,
}

/// Cones of the sonar ring, and their full opening, radians.
const CONES: usize = 16;
const CONE_RAD: f64 = 25.0 * PI / 180.0;
/// Rays that stand for a cone.
const RAYS_PER_CONE: usize = 9;
/// Largest angle from a wall's normal at which it answers, radians.
const MIRROR_RAD: f64 = 20.0 * PI / 180.0;
/// An edge is hidden by what is nearer than it by more than this, metres.
const HIDDEN_M: f64 = 0.02;

impl ScannerKind {
    /// Number of ranges in a scan.
    pub fn len(&self) -> usize {
        match *self {
            Self::Laser(rays) => rays,
            Self::Sonar => CONES,
        }
    }

    /// Whether a scan has no ranges.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Direction of a range in the robot's frame, radians.
    pub fn bearing_rad(&self, index: usize) -> f64 {
        match *self {
            Self::Laser(rays) => -0.5 * PI + self.step_rad() * index as f64 + if rays < 2 { 0.5 * PI } else { 0.0 },
            Self::Sonar => index as f64 * self.step_rad(),
        }
    }

    /// Angle from one range to the next, radians.
    pub fn step_rad(&self) -> f64 {
        match *self {
            Self::Laser(rays) => PI / (rays.max(2) - 1) as f64,
            Self::Sonar => TAU / CONES as f64,
        }
    }

    /// Full opening of a range's cone, radians; zero for a ray.
    pub fn opening_rad(&self) -> f64 {
        if *self == Self::Sonar { CONE_RAD } else { 0.0 }
    }

    /// Longest range, metres.
    pub fn reach_m(&self) -> f64 {
        if *self == Self::Sonar { 4.0 } else { 8.0 }
    }

    /// 1-sigma of a range, metres.
    pub fn sigma_m(&self) -> f64 {
        if *self == Self::Sonar { 0.01 } else { 0.02 }
    }

    /// Time between two scans, seconds.
    pub fn period_s(&self) -> f64 {
        if *self == Self::Sonar { 0.32 } else { 0.2 }
    }
}

/// A scanner in a home.
#[derive(Clone, Debug)]
pub struct Scanner {
    kind: ScannerKind,
    world: World,
    start: Pose2,
    edges_m: Vec<[f64; 2]>,
    noise: Rng,
}

impl Scanner {
    /// A scanner in this home; its noise follows from the seed.
    pub fn new(kind: ScannerKind, plan: &Plan, seed: u64) -> Self {
        let edges_m = plan.faces.iter().flat_map(|face| [face.from_m, face.to_m]).collect();
        let noise = Rng::stream(seed, "scanner", 0);
        Self { kind, world: World::new(plan), start: plan.start, edges_m, noise }
    }

    /// The scan from a pose in the start frame at a time (seconds), metres; not a number where nothing comes back.
    pub fn scan(&mut self, pose: &Pose2, time_s: f64) -> Vec<f32> {
        self.world.set_time(time_s);
        let pose = self.start.compose(pose);
        let range = |i: usize| {
            let direction_rad = pose.theta_rad + self.kind.bearing_rad(i);
            match self.kind {
                ScannerKind::Laser(_) => self.ray(&pose, direction_rad).map(|hit| hit.0),
                ScannerKind::Sonar => self.cone(&pose, direction_rad),
            }
        };
        let ranges: Vec<Option<f64>> = (0..self.kind.len()).map(range).collect();
        let noisy = |range_m: Option<f64>| match range_m.filter(|range_m| *range_m <= self.kind.reach_m()) {
            Some(range_m) => (range_m + self.kind.sigma_m() * self.noise.gaussian()).max(0.0) as f32,
            None => f32::NAN,
        };
        ranges.into_iter().map(noisy).collect()
    }

    /// Range and cosine of the incidence of what a ray meets.
    fn ray(&self, pose: &Pose2, direction_rad: f64) -> Option<(f64, f64)> {
        let (s, c) = libm::sincos(direction_rad);
        self.world.cast([pose.x_m, pose.y_m], [c, s]).map(|hit| (hit.range_m, hit.cos_incidence))
    }

    fn cone(&self, pose: &Pose2, axis_rad: f64) -> Option<f64> {
        let mirror = libm::cos(MIRROR_RAD);
        let rays = (0..RAYS_PER_CONE).map(|i| axis_rad + CONE_RAD * (i as f64 / (RAYS_PER_CONE - 1) as f64 - 0.5));
        let walls = rays.filter_map(|ray_rad| self.ray(pose, ray_rad)).filter(|hit| hit.1 >= mirror).map(|hit| hit.0);
        let edges = self.edges_m.iter().filter_map(|edge| {
            let [dx, dy] = [edge[0] - pose.x_m, edge[1] - pose.y_m];
            let (range_m, direction_rad) = (libm::hypot(dx, dy), libm::atan2(dy, dx));
            let is_inside = crate::pose::wrap(direction_rad - axis_rad).abs() <= 0.5 * CONE_RAD;
            let is_near = range_m <= self.kind.reach_m();
            let is_free = || self.ray(pose, direction_rad).is_none_or(|hit| hit.0 > range_m - HIDDEN_M);
            (is_inside && is_near && is_free()).then_some(range_m)
        });
        walls.chain(edges).reduce(f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> Plan {
        crate::plan_file::load("room").expect("a built-in plan")
    }

    #[test]
    fn a_laser_sees_the_walls_that_it_should() {
        let plan = room();
        let mut scanner = Scanner::new(ScannerKind::Laser(181), &plan, 1);
        let scan = scanner.scan(&Pose2::default(), 0.0);
        assert_eq!(scan.len(), 181);
        // The ray ahead, against the distance to the nearest face along it by hand.
        let (s, c) = libm::sincos(plan.start.theta_rad);
        let hit = World::new(&plan).cast([plan.start.x_m, plan.start.y_m], [c, s]).expect("a wall");
        assert!((f64::from(scan[90]) - hit.range_m).abs() < 0.1, "{} {hit:?}", scan[90]);
    }

    #[test]
    fn a_cone_answers_from_the_nearest_wall_it_meets_squarely_and_from_edges() {
        let face = |from_m: [f64; 2], to_m: [f64; 2]| crate::plan::Face { from_m, to_m, two_sided: true };
        let mut plan = room();
        plan.start = Pose2::default();
        plan.rounds.clear();
        // A wall ahead 1 m off that is turned by 50 degrees, its end outside the cone; behind it one that is square.
        let tilt = 50f64.to_radians();
        let along = [libm::sin(tilt), libm::cos(tilt)];
        plan.faces = vec![
            face([1.0 - 2.0 * along[0], -2.0 * along[1]], [1.0 + 2.0 * along[0], 2.0 * along[1]]),
            face([-1.5, -9.0], [-1.5, 9.0]),
        ];
        let mut scanner = Scanner::new(ScannerKind::Sonar, &plan, 1);
        let scan = scanner.scan(&Pose2::default(), 0.0);
        assert!(scan[0].is_nan(), "a mirror: {}", scan[0]);
        assert!((scan[8] - 1.5).abs() < 0.05, "{}", scan[8]);
        // A post's edge answers at any angle.
        plan.faces = vec![face([1.0, 0.05], [1.2, 0.1])];
        let scan = Scanner::new(ScannerKind::Sonar, &plan, 1).scan(&Pose2::default(), 0.0);
        assert!((scan[0] - 1.0).abs() < 0.05, "{}", scan[0]);
    }
}
