//! Candidates for new walls: the readings that fit none, which of them are to be clustered, and lines in doubt.

use crate::births::buffer::{Outlier, OutlierBuffer};
use crate::births::verdict::Doubts;
use crate::filter::ekf::EkfView;
use crate::geometry::angle::sin_cos;
use crate::geometry::pose::length;
use crate::measurement::beam::Beam;
use crate::measurement::sensor::Sensor;
use crate::motion::dead_reckoning::DeadReckoning;
use crate::sensing::latency::Timing;
use crate::sensing::range::Reading;

/// Least length of a wall that can be told from a chair leg, metres. The buffer's room per sensor covers twice this length.
pub const SHORTEST_WALL_M: f32 = 0.25;

/// At most `B` readings that fit no wall.
#[derive(Clone, Debug)]
pub struct Candidates<const B: usize> {
    /// The readings.
    pub buffer: OutlierBuffer<B>,
    /// The last line that was not judged with certainty.
    pub doubts: Doubts,
    /// Sensors with a buffered point that has not been clustered yet, a bit each.
    pending: u16,
    /// The sensor whose points were clustered last.
    last_clustered: u8,
}

/// What became of a reading that fits no wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// Its sensor's last one ended at the same place.
    No,
    /// It is in the buffer.
    Yes,
    /// It is, in the place of the oldest.
    ForOldest,
}

impl<const B: usize> Candidates<B> {
    /// No candidates.
    pub const NONE: Self = Self { buffer: OutlierBuffer::EMPTY, doubts: Doubts::NONE, pending: 0, last_clustered: 0 };

    /// Forgets every candidate.
    pub fn clear(&mut self) {
        self.buffer.clear();
        self.doubts = Doubts::NONE;
        self.pending = 0;
        self.last_clustered = 0;
    }

    /// Path, noise and calibration of dead reckoning are counted anew from where they have come to so far.
    pub fn count_anew(&mut self, so_far: &DeadReckoning) {
        self.buffer.count_anew(so_far);
        self.doubts.count_anew(so_far.path_m);
    }

    /// Distance between buffered hits of one sensor at which the buffer holds a stretch twice as long as the shortest
    /// wall for every one of so many sensors at once, metres.
    pub fn spacing_m(sensors: usize) -> f32 {
        2.0 * SHORTEST_WALL_M * sensors as f32 / B as f32
    }

    /// Puts an outlier into the buffer, unless it ended within `spacing_m` of its sensor's last one across the beam: along
    /// it, noise alone moves the hit. Nor is a surface drawn by its short readings alone.
    pub fn keep(&mut self, outlier: &Unexplained, spacing_m: f32) -> Kept {
        if outlier.reading.is_cut_off(outlier.sensor.limits.max_m) {
            return Kept::No;
        }
        let (beam, hit_m) = outlier.hit();
        let sensor = outlier.sensor.index as u8;
        if let Some((_, last)) = self.buffer.newest_of(sensor) {
            let d = [hit_m[0] - last.hit_m[0], hit_m[1] - last.hit_m[1]];
            let across_m = d[1] * beam.direction[0] - d[0] * beam.direction[1];
            if across_m.abs() < spacing_m {
                return Kept::No;
            }
        }
        self.pending |= 1 << (sensor & 15);
        if self.buffer.push(outlier.with_hit(&beam, hit_m)) { Kept::ForOldest } else { Kept::Yes }
    }

    /// The next sensor in turn, of so many, with a buffered point that has not been clustered yet.
    pub fn next_pending(&mut self, sensors: usize) -> Option<usize> {
        for offset in 1..=sensors {
            let sensor = (usize::from(self.last_clustered) + offset) % sensors.max(1);
            let bit = 1 << (sensor & 15);
            if self.pending & bit != 0 {
                self.pending &= !bit;
                self.last_clustered = sensor as u8;
                return Some(sensor);
            }
        }
        None
    }
}

/// A reading that fits no wall.
pub struct Unexplained<'a> {
    /// The sensor that made it.
    pub sensor: &'a Sensor<'a>,
    /// The reading.
    pub reading: &'a Reading,
    /// When it was made.
    pub timing: Timing<'a>,
    /// The robot's motion so far.
    pub odometry: &'a DeadReckoning,
    /// The state.
    pub ekf: &'a EkfView,
    /// Number of the step that it was made in.
    pub number: u32,
}

impl Unexplained<'_> {
    /// The beam, and where it ended, in the frame of dead reckoning.
    fn hit(&self) -> (Beam, [f32; 2]) {
        let pose = &self.odometry.pose;
        let mount = self.sensor.state.mount_then(&self.sensor.limits.model, &self.timing, self.ekf);
        let beam = mount.beam([pose.x_m, pose.y_m], sin_cos(pose.theta_rad));
        (beam, beam.at(self.reading.mean_m() / self.sensor.state.gain(self.ekf)))
    }

    fn with_hit(&self, beam: &Beam, hit_m: [f32; 2]) -> Outlier {
        let Self { sensor, reading, timing, odometry, .. } = self;
        let model = &sensor.limits.model;
        // The beam swept on while the reading was made.
        let i = timing.step.increment;
        let moved_m = length(i.forward_m, i.left_m) + (i.turn_rad * reading.range_m).abs();
        Outlier {
            sensor: sensor.index as u8,
            hit_m,
            direction: beam.direction,
            by_factor: odometry.by_factor(hit_m),
            by_latency: timing.latency.by_age(model, &odometry.pose, hit_m),
            range_m: reading.range_m,
            sigma_m: reading.sigma_about_m(),
            step: self.number as u16,
            sweep_m: moved_m * timing.uncertain_share(model),
            position_variance: odometry.position_variance,
            heading_variance: odometry.heading_variance,
        }
    }
}
