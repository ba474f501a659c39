//! A home with more walls than the map holds: a corridor that goes in stairs, one step to the right and one up in turn.
//! It is exact and without noise; the estimator's work does not depend on that.

use slam_core::{Adc, DriveModel, Motion, Mount, Pose, RangeInput, RangeModel, RangeSensor, Rig, Sample, Ticks};

/// Length of a step of the stairs, metres.
const STEP_M: f32 = 0.7;
/// Half the corridor's width, metres.
const HALF_M: f32 = 0.32;
const METRES_PER_TICK: f32 = 0.000_445;
const TRACK_M: f32 = 0.235;
const SCALE_M: f32 = 0.60374;
const EXPONENT: f32 = -1.16;
const FULL_SCALE: f32 = 4095.0;
const VREF_V: f32 = 3.3;
const PERIOD_US: u64 = 40_000;
const SPEED_M: f32 = 0.02;
const TURN_RAD: f32 = 0.06;

/// Eight Sharp sensors an eighth turn apart, two encoders.
pub fn rig() -> Rig<8> {
    let sensor = |i: usize| RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: i as f32 * core::f32::consts::FRAC_PI_4 },
        min_m: 0.155,
        max_m: 1.5,
        max_incidence_rad: 1.22,
        gain_sigma: 0.01,
        model: RangeModel::Sharp { scale_m: SCALE_M, exponent: EXPONENT, noise_v: 0.012 },
    };
    Rig {
        drive: DriveModel::Wheels {
            track_m: TRACK_M,
            track_sigma: 0.01,
            metres_per_tick: METRES_PER_TICK,
            scale_sigma: 0.005,
            noise_m2_per_m: 1e-5,
        },
        adc: Some(Adc { bits: 12, vref_v: VREF_V }),
        sensors: (0..8).map(sensor).collect(),
    }
}

/// A robot that drives up the stairs' middle and turns at every corner.
pub struct Drive {
    time_us: u64,
    pose: Pose,
    travelled_m: [f32; 2],
    corner: i32,
    direction: i32,
}

impl Drive {
    /// At the foot of the stairs.
    pub fn new() -> Self {
        Self { time_us: 0, pose: Pose::default(), travelled_m: [0.0; 2], corner: 1, direction: 1 }
    }

    /// Back the way it came.
    pub fn turn_back(&mut self) {
        self.direction = -self.direction;
        self.corner += self.direction;
    }

    /// Moves for one period. What the sensors show is the view before it: their outputs are a measuring cycle old.
    /// With `clutter` it is things of any distance instead.
    pub fn next(&mut self, clutter: bool) -> Sample<8> {
        let mut ranges = [RangeInput::Missing; 8];
        for (i, range) in ranges.iter_mut().enumerate() {
            let beam_rad = self.pose.theta_rad + i as f32 * core::f32::consts::FRAC_PI_4;
            let range_m = if clutter { self.thing(i) } else { self.cast(beam_rad) };
            *range = RangeInput::Counts(counts(range_m, self.time_us, i));
        }
        self.advance();
        let ticks = self.travelled_m.map(|metres| libm::roundf(metres / METRES_PER_TICK) as i32);
        let motion = Motion::Ticks(Ticks { left: ticks[0], right: ticks[1] });
        Sample { time_us: self.time_us, motion, ranges }
    }

    /// Distance to something, another one each time, metres.
    fn thing(&self, sensor: usize) -> f32 {
        let hash = (self.time_us as u32).wrapping_add(sensor as u32 * 7_919).wrapping_mul(2_654_435_761);
        0.25 + (hash >> 16) as f32 * (1.0 / 65_536.0)
    }

    fn advance(&mut self) {
        let goal = corner(self.corner);
        let (dx, dy) = (goal[0] - self.pose.x_m, goal[1] - self.pose.y_m);
        let bearing = slam_core::angle::wrap(libm::atan2f(dy, dx) - self.pose.theta_rad);
        if slam_core::pose::length(dx, dy) < SPEED_M {
            self.corner += self.direction;
        }
        let (forward_m, turn_rad) =
            if bearing.abs() > 0.1 { (0.0, bearing.clamp(-TURN_RAD, TURN_RAD)) } else { (SPEED_M, 0.5 * bearing) };
        self.pose = self.pose.compose(&Pose::new(0.0, 0.0, 0.5 * turn_rad));
        self.pose = self.pose.compose(&Pose::new(forward_m, 0.0, 0.5 * turn_rad));
        self.travelled_m[0] += forward_m - 0.5 * TRACK_M * turn_rad;
        self.travelled_m[1] += forward_m + 0.5 * TRACK_M * turn_rad;
        self.time_us += PERIOD_US;
    }

    /// Distance to the first wall, metres.
    fn cast(&self, beam_rad: f32) -> f32 {
        let (s, c) = slam_core::angle::sin_cos(beam_rad);
        let mut nearest = f32::INFINITY;
        for i in self.corner - 4..self.corner + 4 {
            for side in [-HALF_M, HALF_M] {
                let ([ax, ay], [bx, by]) = (edge(i, side), edge(i + 1, side));
                let along_x = (bx - ax).abs() > (by - ay).abs();
                let range = if along_x { (ay - self.pose.y_m) / s } else { (ax - self.pose.x_m) / c };
                let hit = if along_x { self.pose.x_m + range * c } else { self.pose.y_m + range * s };
                let (low, high) = if along_x { (ax.min(bx), ax.max(bx)) } else { (ay.min(by), ay.max(by)) };
                if range > 0.0 && range < nearest && (low..=high).contains(&hit) {
                    nearest = range;
                }
            }
        }
        nearest
    }
}

/// Corner `i` of the corridor's middle line.
fn corner(i: i32) -> [f32; 2] {
    let (x, y) = ((i + 1).div_euclid(2), i.div_euclid(2));
    [x as f32 * STEP_M, y as f32 * STEP_M]
}

/// Corner `i` of the wall on one side.
fn edge(i: i32, side: f32) -> [f32; 2] {
    let [x, y] = corner(i);
    [x + side, y - side]
}

/// What the converter shows: the sensor's law, and a count of dither so that no two readings look held.
fn counts(range_m: f32, time_us: u64, sensor: usize) -> u16 {
    let volts = libm::powf(range_m.min(1.8) / SCALE_M, 1.0 / EXPONENT);
    let dither = ((time_us / PERIOD_US + sensor as u64) % 3) as f32 * 3.0;
    (volts / VREF_V * FULL_SCALE + dither).clamp(0.0, FULL_SCALE) as u16
}
