//! What is near the robot: where the beams of the last seconds ended and what the bumper felt, to the millimetre.
//!
//! A sensor does not see what touches the body beside it, but it saw that before the robot came there.

use slam_core::Pose;

use crate::pilot::beam::Beam;

/// Points that are kept.
const POINTS: usize = 64;

/// Points nearer to each other than this are one, metres.
const SAME_M: f32 = 0.022;

/// Where a point is differs by this from one reading of it to the next for other reasons than noise, metres: other places of one thing, and the
/// pose. What readings with more noise say of a point is a mean of several.
const STRAYS_M: f32 = 0.009;

/// Farther away nothing matters, metres.
const REACH_M: f32 = 0.45;

/// What is this near to the body when the bumper is pressed is what presses it, metres.
const SLACK_M: f32 = 0.035;

/// The body is led past what is so much within its side, metres: points are not known better.
const BESIDE_M: f32 = 0.012;

/// A point that a beam ended at is kept so long, microseconds.
const SEEN_US: u64 = 8_000_000;

/// A point, in the frame of the floor job.
#[derive(Clone, Copy, Debug)]
struct Point {
    at_m: [f32; 2],
    /// Until when it is kept, in [`Tick`]s.
    until: Tick,
}

impl Point {
    /// One that is over.
    const NONE: Self = Self { at_m: [0.0; 2], until: 0 };
}

/// Sixteenths of a second, about: as 32 bits they last for eight years.
type Tick = u32;

fn tick(time_us: u64) -> Tick {
    (time_us >> 16) as Tick
}

/// The points near the robot.
#[derive(Clone, Debug)]
pub(super) struct Near {
    points: [Point; POINTS],
}

impl Near {
    pub(super) const fn new() -> Self {
        Self { points: [Point::NONE; POINTS] }
    }

    /// A beam ended that was read where the robot was `then`.
    pub(super) fn see(&mut self, beam: &Beam, then: &Pose, pose: &Pose, now_us: u64) {
        let at_m = then.transform(beam.point_m(beam.range_m));
        let noise_m = [0, 1].map(|axis| beam.noise_m() * beam.direction[axis]);
        let turned = Pose::new(0.0, 0.0, then.theta_rad);
        self.add(at_m, turned.transform(noise_m), now_us.saturating_add(SEEN_US), pose, now_us);
    }

    /// Something is here (metres, frame of the job) until then at least, by a reading with noise of this 1-sigma along its beam (a vector in the
    /// same frame, metres).
    pub(super) fn add(&mut self, mut at_m: [f32; 2], noise_m: [f32; 2], until_us: u64, pose: &Pose, now_us: u64) {
        let dot = |a: [f32; 2], b: [f32; 2]| a[0] * b[0] + a[1] * b[1];
        let between = |a: [f32; 2], b: [f32; 2]| [a[0] - b[0], a[1] - b[1]];
        let square = |a: [f32; 2]| dot(a, a);
        let here_m = [pose.x_m, pose.y_m];
        let (until, now) = (tick(until_us), tick(now_us));
        if square(between(at_m, here_m)) > REACH_M * REACH_M {
            return;
        }
        // Along the beam points are one up to four sigma: of two readings of one place one pair in two hundred differs by more.
        let same_m2 = SAME_M * SAME_M;
        let noise_m2 = square(noise_m);
        let along = (1.0 - same_m2 / (16.0 * noise_m2).max(same_m2)) / noise_m2.max(f32::MIN_POSITIVE);
        let share = STRAYS_M * STRAYS_M / (STRAYS_M * STRAYS_M + noise_m2);
        let mut place = 0;
        let mut worst = -1.0_f32;
        for (index, point) in self.points.iter().enumerate() {
            let off_m = between(at_m, point.at_m);
            let off_along_m2 = dot(off_m, noise_m);
            if point.until > now && square(off_m) - along * off_along_m2 * off_along_m2 < same_m2 {
                at_m = [0, 1].map(|axis| point.at_m[axis] + share * off_m[axis]);
                (place, worst) = (index, f32::INFINITY);
                break;
            }
            // One that is over goes first, then the farthest.
            let badness = if point.until <= now { f32::INFINITY } else { square(between(point.at_m, here_m)) };
            if badness > worst {
                (place, worst) = (index, badness);
            }
        }
        let is_nearer = worst > square(between(at_m, here_m));
        if let Some(point) = self.points.get_mut(place).filter(|_| is_nearer) {
            *point = Point { at_m, until };
        }
    }

    /// The points in the robot's frame, metres.
    pub(super) fn seen_from(&self, pose: &Pose, now_us: u64) -> impl Iterator<Item = [f32; 2]> + '_ {
        let (s, c) = slam_core::angle::sin_cos(pose.theta_rad);
        let [x_m, y_m] = [pose.x_m, pose.y_m];
        let now = tick(now_us);
        self.points.iter().filter(move |point| point.until > now).map(move |point| {
            let [dx, dy] = [point.at_m[0] - x_m, point.at_m[1] - y_m];
            [c * dx + s * dy, c * dy - s * dx]
        })
    }

    /// The body (radius in metres) touches something within this sector of its front (radians from straight ahead): what is known
    /// to be there stands so near; whether anything is.
    pub(super) fn touch(&mut self, sector_rad: [f32; 2], radius_m: f32, pose: &Pose, now_us: u64) -> bool {
        let back = pose.inverse();
        let now = tick(now_us);
        let mut is_known = false;
        for point in self.points.iter_mut().filter(|point| point.until > now) {
            let [x_m, y_m] = back.transform(point.at_m);
            let distance_m = slam_core::pose::length(x_m, y_m);
            let bearing_rad = libm::atan2f(y_m, x_m);
            if distance_m < radius_m + SLACK_M && (sector_rad[0]..=sector_rad[1]).contains(&bearing_rad) {
                let share = (radius_m / distance_m.max(0.01)).min(1.0);
                point.at_m = pose.transform([share * x_m, share * y_m]);
                is_known = true;
            }
        }
        is_known
    }

    /// Whether something known stands in the blind zone of a beam from here (robot's frame, metres) in this direction: what the
    /// sensor shows is folded back then.
    pub(super) fn is_blinded(&self, beam: &Beam, pose: &Pose, now_us: u64) -> bool {
        self.seen_from(pose, now_us).any(|[x_m, y_m]| {
            let [dx, dy] = [x_m - beam.mount_m[0], y_m - beam.mount_m[1]];
            let along_m = dx * beam.direction[0] + dy * beam.direction[1];
            let aside_m = dy * beam.direction[0] - dx * beam.direction[1];
            let is_in_zone = along_m > 0.0 && along_m < beam.min_m - 0.015 && aside_m.abs() < 0.03;
            // Just beyond the blind zone a reading may be folded back: what is known to be nearer tells.
            let may_be_folded = beam.range_m < beam.min_m + 0.04;
            let is_nearer = along_m > 0.0 && along_m < beam.range_m - 0.001 && aside_m.abs() < 0.02;
            is_in_zone || may_be_folded && is_nearer
        })
    }

    /// Nothing is known any more.
    pub(super) fn clear(&mut self) {
        self.points.fill(Point::NONE);
    }

    /// The frame turned by so much (radians): all points are elsewhere in it now.
    pub(super) fn turn(&mut self, by_rad: f32) {
        let frame = Pose::new(0.0, 0.0, by_rad).inverse();
        self.points.iter_mut().for_each(|point| point.at_m = frame.transform(point.at_m));
    }
}

/// How far a round body of this radius (metres) can go straight on among these points, metres.
pub(super) fn free_ahead_m(points: impl Iterator<Item = [f32; 2]>, radius_m: f32) -> f32 {
    let mut free_m = f32::INFINITY;
    for [x_m, y_m] in points {
        // What is just beside the body is passed along, not run into.
        if x_m > 0.0 && y_m.abs() < radius_m - BESIDE_M {
            free_m = free_m.min(x_m - float::sqrtf(radius_m * radius_m - y_m * y_m));
        }
    }
    free_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wild::Wild;

    const WALL_M: f32 = -0.2;

    /// How much nearer than the wall the nearest point beside is on a drive along it with a sensor of this noise, the mean in metres.
    fn nearer_m(noise_m: f32) -> f32 {
        const STEPS: u64 = 3000;
        let (mut near, mut wild) = (Near::new(), Wild::new());
        let mut sum_m = 0.0;
        for step in 0..STEPS {
            let (pose, now_us) = (Pose::new(0.006 * step as f32, 0.0, 0.0), 40_000 * step);
            let gaussian: f32 = (0..12).map(|_| 0.5 * wild.share()).sum();
            let at_m = [pose.x_m, WALL_M + noise_m * gaussian];
            near.add(at_m, [0.0, -noise_m], now_us + 8_000_000, &pose, now_us);
            let beside = near.seen_from(&pose, now_us).filter(|[x_m, _]| x_m.abs() < 0.14);
            sum_m += beside.map(|[_, y_m]| y_m - WALL_M).fold(-1.0, f32::max);
        }
        sum_m / STEPS as f32
    }

    #[test]
    fn a_noisy_sensor_has_a_wall_about_where_it_is() {
        // The nearest of ten single readings is nearer by one and a half sigma.
        for noise_m in [0.002, 0.005, 0.01, 0.02] {
            assert!(nearer_m(noise_m) < 1.2 * noise_m, "{noise_m}: {}", nearer_m(noise_m));
        }
    }
}
