//! Other systems for sparse range sensors, as baselines behind one trait.
//!
//! Each row of [`Kind`] is written anew from its equations; what a source does not say is ours and named so. A relative gets
//! what a robot senses and gives a pose: no truth can reach it, for this crate does not know the simulator. It runs on a desk:
//! double precision, heap.
//!
//! Frames: a relative's poses and walls are in the frame of its start pose; [`Input`] is in the robot's frame.

#![forbid(unsafe_code)]

pub mod ekf;
pub mod features;
pub mod fit;
pub mod front;
pub mod geometry;
pub mod graph;
pub mod hough;
mod kind;
pub mod known;
pub mod matcher;
pub mod psm;
pub mod random;
pub mod rows;
pub mod tbf;
pub mod window;

pub use kind::{Kind, Setup};

use geometry::{Point, Pose, Segment, unit};
use nalgebra::Matrix3;

/// One reading of a range sensor that passed the front end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where the beam starts in the robot's frame, metres.
    pub origin: Point,
    /// Direction in the robot's frame, radians.
    pub bearing: f64,
    /// Full opening of a cone, radians; zero for a beam.
    pub opening: f64,
    /// The range, metres.
    pub range: f64,
    /// Its 1-sigma, metres.
    pub sigma: f64,
}

impl Beam {
    /// Where the beam ends, robot's frame, metres.
    pub fn end(&self) -> Point {
        self.origin + unit(self.bearing) * self.range
    }
}

/// A whole scan of evenly spaced beams.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dense<'a> {
    /// Where it is taken in the robot's frame, metres.
    pub origin: Point,
    /// Direction of the first beam, radians.
    pub first: f64,
    /// Angle from one beam to the next, radians.
    pub step: f64,
    /// The ranges, metres; not a number, or beyond `reach`: nothing came back.
    pub ranges: &'a [f32],
    /// Longest range that is a reading, metres.
    pub reach: f64,
}

/// What the robot sensed in one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Input<'a> {
    /// Motion since the last step by the rig's nominal calibration, in the robot's frame of then.
    pub motion: Pose,
    /// Covariance of that motion by the rig's noise model.
    pub motion_cov: Matrix3<f64>,
    /// The range sensors, in the rig's order; none where there is no reading.
    pub beams: &'a [Option<Beam>],
    /// A whole scan, where the robot has a scanner.
    pub dense: Option<Dense<'a>>,
}

/// What a relative makes of it.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// The pose in the frame of the start pose.
    pub pose: Pose,
    /// Its covariance; none where the system has none.
    pub covariance: Option<Matrix3<f64>>,
}

/// A system that follows a robot's pose.
pub trait Relative {
    /// Takes in one step.
    fn step(&mut self, input: &Input<'_>) -> Output;
    /// The walls of its map; empty where it has none.
    fn walls(&self) -> Vec<Segment>;
    /// The whole path as it knows it now, one pose a step; none where it does not correct the past.
    fn path(&self) -> Option<Vec<Pose>> {
        None
    }
    /// Memory that its state takes, bytes.
    fn bytes(&self) -> usize;
}
