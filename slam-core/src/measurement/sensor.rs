//! A range sensor as the filter knows it.

use crate::filter::ekf::EkfView;
use crate::geometry::angle::sin_cos;
use crate::measurement::beam::FixedMount;
use crate::rig::{RangeModel, RangeSensor};
use crate::sensing::latency::Timing;
use crate::sensing::range::FrontEnd;

/// What is kept of a sensor.
#[derive(Clone, Copy, Debug)]
pub struct SensorState {
    mount: FixedMount,
    /// Cosine of the largest incidence at which it is trusted.
    pub min_cos: f32,
    /// Index of the state that is its gain; none where that is known.
    gain: Option<u16>,
    /// What its inputs were so far.
    pub front_end: FrontEnd,
}

impl SensorState {
    /// For an estimator that has not started.
    pub const NONE: Self = Self { mount: FixedMount::NONE, min_cos: 0.0, gain: None, front_end: FrontEnd::NEW };

    /// At the start.
    pub fn new(sensor: &RangeSensor, gain: Option<usize>) -> Self {
        Self {
            mount: FixedMount::new(&sensor.mount),
            min_cos: sin_cos(sensor.max_incidence_rad).1,
            gain: gain.map(|i| i as u16),
            front_end: FrontEnd::NEW,
        }
    }

    /// Index of the state that is its gain; none where that is known.
    pub fn gain_state(&self) -> Option<usize> {
        self.gain.map(usize::from)
    }

    /// Its gain as it is estimated.
    pub fn gain(&self, ekf: &EkfView) -> f32 {
        self.gain_state().map_or(1.0, |i| ekf.mean(i))
    }

    /// Whether it looks so nearly along the way ahead or back that it does not see a wall beside it.
    pub fn looks_along(&self) -> bool {
        self.mount.sin().abs() < self.min_cos
    }

    /// How far along its beam a range ends beyond a point so far to the left of the axle's centre, all metres.
    pub fn past_axle_m(&self, range_m: f32, left_m: f32) -> f32 {
        range_m + self.mount.along_m(left_m)
    }

    /// The mount as it was when the reading was made.
    pub fn mount_then(&self, model: &RangeModel, timing: &Timing, ekf: &EkfView) -> FixedMount {
        match timing.motion_since(model, ekf) {
            Some(moved) => self.mount.lagging([moved.forward_m, moved.left_m], moved.turn_rad),
            None => self.mount,
        }
    }
}

/// One sensor of the rig.
#[derive(Clone, Copy, Debug)]
pub struct Sensor<'a> {
    /// Its place in the rig's list.
    pub index: usize,
    /// What the rig says of it.
    pub limits: &'a RangeSensor,
    /// What is kept of it.
    pub state: &'a SensorState,
}
