//! A home to sweep: a room and two others far from it, at either side, with the corridors between them: larger than the picture of the home,
//! which has to follow, and to be left. It is exact and without noise; the job's work does not depend on that.

use robot::{Condition, Contacts, PilotConfig, Senses, WheelSpeeds};
use slam_core::{Pose, Rig};

/// Walls as the coordinates of both ends, metres: along an axis each.
const WALLS: [[f32; 4]; 23] = [
    // The room of the start.
    [-1.0, -1.0, 1.0, -1.0],
    [-1.0, -1.0, -1.0, -0.45],
    [-1.0, 0.45, -1.0, 1.0],
    [-1.0, 1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0, -0.45],
    [1.0, 0.45, 1.0, 1.0],
    // The corridor.
    [1.0, -0.45, 6.0, -0.45],
    [1.0, 0.45, 6.0, 0.45],
    // The other room, and a box in it.
    [6.0, -1.2, 6.0, -0.45],
    [6.0, 0.45, 6.0, 1.2],
    [6.0, -1.2, 8.4, -1.2],
    [6.0, 1.2, 8.4, 1.2],
    [8.4, -1.2, 8.4, 1.2],
    [7.2, 0.5, 7.6, 0.5],
    [7.2, 0.5, 7.2, 1.2],
    // The corridor and the room on the other side.
    [-6.0, -0.45, -1.0, -0.45],
    [-6.0, 0.45, -1.0, 0.45],
    [-6.0, -1.2, -6.0, -0.45],
    [-6.0, 0.45, -6.0, 1.2],
    [-8.4, -1.2, -6.0, -1.2],
    [-8.4, 1.2, -6.0, 1.2],
    [-8.4, -1.2, -8.4, 1.2],
    [-7.6, -0.1, -7.0, -0.1],
];
const PERIOD_S: f32 = 0.04;
const PERIOD_US: u64 = 40_000;

/// A robot in it.
pub struct FloorHome {
    rig: Rig<8>,
    size: PilotConfig,
    pose: Pose,
    time_us: u64,
}

impl FloorHome {
    /// At the start.
    pub fn new(rig: Rig<8>) -> Self {
        Self { rig, size: PilotConfig::default(), pose: Pose::ORIGIN, time_us: 0 }
    }

    /// Drives for a period, and senses.
    pub fn next(&mut self, speeds: WheelSpeeds) -> Senses<8> {
        let forward_m = 0.5 * (speeds.left_mps + speeds.right_mps) * PERIOD_S;
        let turn_rad = (speeds.right_mps - speeds.left_mps) / self.size.track_m * PERIOD_S;
        self.pose = self.pose.compose(&Pose::new(0.0, 0.0, 0.5 * turn_rad));
        self.pose = self.pose.compose(&Pose::new(forward_m, 0.0, 0.5 * turn_rad));
        let contacts = self.collide();
        self.time_us += PERIOD_US;
        let mut ranges_m = [None; 8];
        for (range_m, sensor) in ranges_m.iter_mut().zip(&self.rig.sensors) {
            let mount = &sensor.mount;
            let true_m =
                self.cast(self.pose.transform([mount.x_m, mount.y_m]), self.pose.theta_rad + mount.bearing_rad);
            *range_m = Some(true_m).filter(|true_m| (sensor.min_m..sensor.max_m).contains(true_m));
        }
        Senses { time_us: self.time_us, pose: self.pose, ranges_m, contacts, condition: Condition::default() }
    }

    /// Walls push the body out and press the bumper.
    fn collide(&mut self) -> Contacts {
        let mut contacts = Contacts::default();
        for [x0, y0, x1, y1] in WALLS {
            let [dx, dy] = [self.pose.x_m - self.pose.x_m.clamp(x0, x1), self.pose.y_m - self.pose.y_m.clamp(y0, y1)];
            let away_m = slam_core::pose::length(dx, dy).max(1e-6);
            let depth_m = self.size.radius_m - away_m;
            if depth_m <= 0.0 {
                continue;
            }
            (self.pose.x_m, self.pose.y_m) =
                (self.pose.x_m + depth_m * dx / away_m, self.pose.y_m + depth_m * dy / away_m);
            let bearing_rad = slam_core::angle::wrap(libm::atan2f(-dy, -dx) - self.pose.theta_rad);
            contacts.bump_left |= (-0.3..1.4).contains(&bearing_rad);
            contacts.bump_right |= (-1.4..0.3).contains(&bearing_rad);
        }
        contacts
    }

    /// Distance to the first wall, metres.
    fn cast(&self, [x_m, y_m]: [f32; 2], bearing_rad: f32) -> f32 {
        let (s, c) = slam_core::angle::sin_cos(bearing_rad);
        let mut nearest_m = f32::INFINITY;
        for [x0, y0, x1, y1] in WALLS {
            let range_m = if x0 == x1 { (x0 - x_m) / c } else { (y0 - y_m) / s };
            let at_m = if x0 == x1 { y_m + range_m * s } else { x_m + range_m * c };
            let is_on = if x0 == x1 { (y0..=y1).contains(&at_m) } else { (x0..=x1).contains(&at_m) };
            if range_m > 0.0 && is_on {
                nearest_m = nearest_m.min(range_m);
            }
        }
        nearest_m
    }
}
