//! From the samples of a rig to the input of a relative: the project's own checks of readings and nominal motion, so that every
//! system begins with the same ranges.
//!
//! Nothing is calibrated here: gains, scales and track are taken as the rig states them. A reading of an analogue sensor is placed
//! where the robot was half a measuring cycle and half a hold before, as the data sheet says.

use nalgebra::Matrix3;
use slam_core::front_end::{Encoders, Factors, FrontEnd, OutputNoise, SHARP_HOLD_S, step};
use slam_core::{RangeModel, RangeSensor, Rig, Sample};

use crate::geometry::{Point, Pose};
use crate::{Beam, Dense, Input};

/// Mean age of an analogue reading when it is sampled, seconds: half a measurement and half a hold.
const AGE_S: f32 = 0.85 * SHARP_HOLD_S;

/// The front end of one robot.
pub struct Front<const S: usize> {
    rig: Rig<S>,
    sensors: Vec<FrontEnd>,
    noise: OutputNoise,
    encoders: Encoders,
    last_us: Option<u64>,
    path: f32,
    beams: Vec<Option<Beam>>,
}

impl<const S: usize> Front<S> {
    /// Of a robot with this rig.
    pub fn new(rig: Rig<S>) -> Self {
        let n = rig.sensors.len();
        Self {
            rig,
            sensors: vec![FrontEnd::NEW; n],
            noise: OutputNoise::UNKNOWN,
            encoders: Encoders::NEW,
            last_us: None,
            path: 0.0,
            beams: vec![None; n],
        }
    }

    /// The readings that [`Front::read`] accepted last, in the rig's order.
    pub fn beams(&self) -> &[Option<Beam>] {
        &self.beams
    }

    /// The input of one sample; `dense` is a whole scan where the log has one.
    pub fn read<'a>(&'a mut self, sample: &Sample<S>, dense: Option<Dense<'a>>) -> Input<'a> {
        let is_first = self.last_us.is_none();
        let since_us = sample.time_us.saturating_sub(self.last_us.replace(sample.time_us).unwrap_or(sample.time_us));
        let dt_s = since_us as f32 * 1e-6;
        let travel = self.encoders.travel(&self.rig.drive, &sample.motion, dt_s).filter(|_| !is_first);
        let factors = Factors::nominal(&self.rig.drive);
        let made = travel.map(|travel| step(&self.rig.drive, &travel, &factors)).unwrap_or_default();
        self.path += made.path_m;
        let (i, noise) = (made.increment, made.noise);
        let motion = Pose::new(i.forward_m.into(), i.left_m.into(), i.turn_rad.into());
        let motion_cov = Matrix3::from_fn(|row, column| f64::from(noise[row][column]));
        let back = |share: f64| Pose::new(-share * motion.at.x, -share * motion.at.y, -share * motion.theta);
        for (index, sensor) in self.rig.sensors.iter().enumerate() {
            let input = sample.ranges[index];
            let read = self.sensors[index].read(sensor, self.rig.adc.as_ref(), input, dt_s, self.path, &mut self.noise);
            let age = if matches!(sensor.model, RangeModel::Sharp { .. }) && dt_s > 0.0 { AGE_S / dt_s } else { 0.0 };
            let from = back(f64::from(age.min(2.0)));
            self.beams[index] = read.ok().map(|reading| beam(sensor, &from, reading.range_m, reading.sigma_m()));
        }
        Input { motion, motion_cov, beams: &self.beams, dense }
    }
}

/// A reading as it was made from this pose, which is given in the robot's present frame.
fn beam(sensor: &RangeSensor, from: &Pose, range_m: f32, sigma_m: f32) -> Beam {
    let mount = sensor.mount;
    Beam {
        origin: from.transform(Point::new(mount.x_m.into(), mount.y_m.into())),
        bearing: from.theta + f64::from(mount.bearing_rad),
        opening: 0.0,
        range: range_m.into(),
        sigma: f64::from(sigma_m).max(slam_core::SURFACE_M.into()),
    }
}
