//! Four time-of-flight sensors and a dead-reckoned pose: a robot drives a square in a room of 4 m by 3 m.
//!
//! Run with `cargo run -p slam-core --example four_tof`.

use std::f32::consts::{FRAC_PI_2, TAU};

use slam_core::{
    DriveModel, Increment, Motion, Mount, RangeInput, RangeModel, RangeSensor, Rig, RigError, Sample, Slam, slam_type,
};

/// Four sensors, up to 32 walls, 64 readings that fit none.
type MySlam = slam_type!(sensors: 4, walls: 32, outliers: 64);

/// Ahead, left, behind, right.
fn rig() -> Rig<4> {
    let sensor = |i: u8| RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: f32::from(i) * FRAC_PI_2 },
        min_m: 0.05,
        max_m: 4.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.01 },
    };
    let drive = DriveModel::Odometry {
        scale_sigma: 0.02,
        veer_sigma: 0.02,
        noise_m2_per_m: 4e-4,
        noise_rad2_per_m: 1e-4,
        noise_rad2_per_rad: 1e-3,
    };
    Rig { drive, adc: None, sensors: (0..4).map(sensor).collect() }
}

/// The range from a point in the room, whose corner is at (-1, -1), along a bearing.
fn range_m([x, y]: [f32; 2], bearing_rad: f32) -> f32 {
    let (s, c) = bearing_rad.sin_cos();
    let to = |from: f32, speed: f32, low: f32, high: f32| {
        if speed.abs() < 1e-6 { f32::MAX } else { (if speed > 0.0 { high } else { low } - from) / speed }
    };
    to(x, c, -1.0, 3.0).min(to(y, s, -1.0, 2.0))
}

fn main() -> Result<(), RigError> {
    let mut slam = MySlam::new(rig())?;
    let ([mut x, mut y], mut theta) = ([0.0_f32; 2], 0.0_f32);
    for step in 0..1200_u64 {
        // Ahead for eight seconds of ten, then a quarter turn to the left. The first sample is where motion starts from.
        let (forward_m, turn_rad) = match step % 100 {
            _ if step == 0 => (0.0, 0.0),
            0..80 => (0.02, 0.0),
            _ => (0.0, FRAC_PI_2 / 20.0),
        };
        (x, y) = (x + forward_m * theta.cos(), y + forward_m * theta.sin());
        theta = (theta + turn_rad) % TAU;
        let motion = Motion::Increment(Increment { forward_m, left_m: 0.0, turn_rad });
        let ranges = [0.0, 1.0, 2.0, 3.0].map(|i| RangeInput::Metres(range_m([x, y], theta + i * FRAC_PI_2)));
        slam.step(&Sample { time_us: step * 100_000, motion, ranges });
    }
    let estimate = slam.estimate();
    println!("robot at {:.2} m, {:.2} m; true {x:.2} m, {y:.2} m", estimate.pose.x_m, estimate.pose.y_m);
    print_walls(&slam);
    Ok(())
}

fn print_walls<const S: usize, const W: usize, const B: usize, const ROWS: usize>(slam: &Slam<S, W, B, ROWS>) {
    for wall in slam.walls() {
        let (from, to, beta) = (wall.lo_m, wall.hi_m, wall.beta_rad.to_degrees());
        println!("wall {}: {:.2} m off, facing {beta:.0} degrees, from {from:.2} m to {to:.2} m", wall.id, wall.rho_m);
    }
}
