//! The ring buffer of readings that fit no wall (Rousse & Qiu 3.3).

use crate::motion::dead_reckoning::{ByFactor, DeadReckoning};
use heapless::Deque;

/// A reading that fitted no wall, in the frame of dead reckoning, which never jumps.
#[derive(Clone, Copy, Debug)]
pub struct Outlier {
    /// Index of the sensor.
    pub sensor: u8,
    /// Where the beam ended, in the odometry frame, metres.
    pub hit_m: [f32; 2],
    /// Unit vector of the beam, in the odometry frame.
    pub direction: [f32; 2],
    /// Derivatives of the hit by the drive's calibration factors, metres.
    pub by_factor: ByFactor,
    /// Derivative of the hit by the age of its reading, metres per second.
    pub by_latency: [f32; 2],
    /// What the sensor reported, metres.
    pub range_m: f32,
    /// Standard deviation of that, metres.
    pub sigma_m: f32,
    /// The step it was made in; it wraps.
    pub step: u16,
    /// Standard deviation of the hit across the beam, metres: the beam swept on while the reading was made.
    pub sweep_m: f32,
    /// Variance of the dead-reckoned position then, since the start, each axis, m^2.
    pub position_variance: f32,
    /// Variance of the dead-reckoned heading then, since the start, rad^2.
    pub heading_variance: f32,
}

/// At most `B` outliers, the oldest first; a new one overwrites the oldest.
#[derive(Clone, Debug, Default)]
pub struct OutlierBuffer<const B: usize> {
    points: Deque<Outlier, B>,
}

impl<const B: usize> OutlierBuffer<B> {
    /// No outliers.
    pub const EMPTY: Self = Self { points: Deque::new() };

    /// Forgets every outlier.
    pub fn clear(&mut self) {
        self.points.clear();
    }

    /// Adds an outlier; true where the oldest had to go.
    pub fn push(&mut self, outlier: Outlier) -> bool {
        let full = self.points.is_full() && self.points.pop_front().is_some();
        // There is room now, unless B is zero.
        let _ = self.points.push_back(outlier);
        full
    }

    /// Readings are so many times as noisy as was said.
    pub fn widen(&mut self, times: f32) {
        self.points.iter_mut().for_each(|point| point.sigma_m *= times);
    }

    /// Path, noise and calibration of dead reckoning are counted anew from where they have come to so far.
    pub fn count_anew(&mut self, so_far: &DeadReckoning) {
        for point in &mut self.points {
            point.position_variance -= so_far.position_variance;
            point.heading_variance -= so_far.heading_variance;
            let by_factor = so_far.by_factor(point.hit_m);
            for (own, so_far) in point.by_factor.iter_mut().flatten().zip(by_factor.as_flattened()) {
                *own -= so_far;
            }
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// The points, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Outlier> + Clone {
        let (older, newer) = self.points.as_slices();
        older.iter().chain(newer)
    }

    /// The point at a position, counted from the oldest.
    pub fn get(&self, position: usize) -> Option<&Outlier> {
        let (older, newer) = self.points.as_slices();
        older.get(position).or_else(|| newer.get(position - older.len()))
    }

    /// The newest point of a sensor, and its position.
    pub fn newest_of(&self, sensor: u8) -> Option<(usize, &Outlier)> {
        let position = self.len().checked_sub(1 + self.iter().rev().position(|p| p.sensor == sensor)?)?;
        self.get(position).map(|point| (position, point))
    }

    /// Keeps the points for which `keep` of their position in the buffer and themselves is true.
    pub fn retain(&mut self, mut keep: impl FnMut(usize, &Outlier) -> bool) {
        let mut kept = 0;
        for i in 0..self.points.len() {
            let Some(point) = self.points.get(i).filter(|point| keep(i, point)).copied() else { continue };
            if kept < i
                && let Some(slot) = self.points.get_mut(kept)
            {
                *slot = point;
            }
            kept += 1;
        }
        self.points.truncate(kept);
    }
}
