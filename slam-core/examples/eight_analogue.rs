//! Eight analogue triangulation sensors and encoder ticks: a robot turns on the spot in a room of 1.6 m by 1.2 m.
//!
//! Run with `cargo run -p slam-core --example eight_analogue`.

use std::f32::consts::FRAC_PI_4;

use slam_core::{
    Adc, DriveModel, Motion, Mount, RangeInput, RangeModel, RangeSensor, Rig, RigError, RobotSlam, Sample, Ticks,
};

const TRACK_M: f32 = 0.2;
const METRES_PER_TICK: f32 = 1e-4;
const ADC: Adc = Adc { bits: 12, vref_v: 3.3 };

/// A Sharp GP2Y0A02YK every 45 degrees, 6 cm from the axle's centre.
fn rig() -> Rig<8> {
    let sensor = |i: u8| {
        let bearing_rad = f32::from(i) * FRAC_PI_4;
        RangeSensor {
            mount: Mount { x_m: 0.06 * bearing_rad.cos(), y_m: 0.06 * bearing_rad.sin(), bearing_rad },
            min_m: 0.2,
            max_m: 1.5,
            max_incidence_rad: 1.0,
            gain_sigma: 0.03,
            model: RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 },
        }
    };
    let drive = DriveModel::Wheels {
        track_m: TRACK_M,
        track_sigma: 0.01,
        metres_per_tick: METRES_PER_TICK,
        scale_sigma: 0.01,
        noise_m2_per_m: 1e-6,
    };
    Rig { drive, adc: Some(ADC), sensors: (0..8).map(sensor).collect() }
}

/// What the converter reads where the sensor is so far from a wall.
fn counts(range_m: f32) -> u16 {
    let volts = (range_m / 0.6).powf(-1.0 / 1.16);
    (volts / ADC.vref_v * 4095.0) as u16
}

/// The range from a mount on a robot at the room's centre, along a bearing.
fn range_m(bearing_rad: f32) -> f32 {
    let (s, c) = bearing_rad.sin_cos();
    let [x, y] = [0.06 * c, 0.06 * s];
    let to = |from: f32, speed: f32, half: f32| {
        if speed.abs() < 1e-6 { f32::MAX } else { (half.copysign(speed) - from) / speed }
    };
    to(x, c, 0.8).min(to(y, s, 0.6))
}

fn main() -> Result<(), RigError> {
    let mut slam = RobotSlam::new(rig())?;
    let mut turned_ticks = 0;
    for step in 0..500_u64 {
        turned_ticks += 40;
        let theta = 2.0 * turned_ticks as f32 * METRES_PER_TICK / TRACK_M;
        let motion = Motion::Ticks(Ticks { left: -turned_ticks, right: turned_ticks });
        let ranges =
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i: u8| RangeInput::Counts(counts(range_m(theta + f32::from(i) * FRAC_PI_4))));
        slam.step(&Sample { time_us: step * 40_000, motion, ranges });
    }
    let sigma_rad = slam.estimate().covariance[(2, 2)].max(0.0).sqrt();
    println!("heading known to {:.2} degrees", sigma_rad.to_degrees());
    for wall in slam.walls() {
        println!("wall {}: {:.2} m from the centre, met by {} readings", wall.id, wall.rho_m, wall.updates);
    }
    println!("{:?}", slam.counters());
    Ok(())
}
