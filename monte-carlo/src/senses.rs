//! With what a variant senses: the rig's own sensors, or a scanner that looked along the same true path.

use hal_sim::scanner::{Scanner, ScannerKind};
use hal_sim::{Frame, MAX_SENSORS};
use relatives::Beam;
use relatives::geometry::Point;
use slam_core::{Mount, RangeInput, RangeModel, RangeSensor, Sample};

use lab::input::rig_file::Robot;

use crate::unit::Driven;

/// With what a variant senses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Senses {
    /// The sensors of the rig.
    #[default]
    Rig,
    /// This scanner instead.
    Scanner(ScannerKind),
}

/// A drive as it was sensed by a scanner.
pub struct Scanned {
    /// What the scanner is.
    pub kind: ScannerKind,
    /// One scan a frame, where there was one.
    pub scans: Vec<Option<Vec<f32>>>,
}

impl Scanned {
    /// Looks along the true path of a drive.
    pub fn of(driven: &Driven, kind: ScannerKind, seed: u64) -> Self {
        let mut scanner = Scanner::new(kind, &driven.plan, seed);
        let mut next_s = 0.0;
        let look = |frame: &Frame| {
            let time_s = frame.sample.time_us as f64 * 1e-6;
            (time_s >= next_s).then(|| {
                next_s = time_s + kind.period_s() - 1e-6;
                scanner.scan(&frame.truth, time_s)
            })
        };
        Self { kind, scans: driven.frames.iter().map(look).collect() }
    }

    /// A robot with these rays as its range sensors, and what it senses; none where a sample has no room for so many.
    pub fn as_rig(&self, robot: &Robot, frames: &[Frame]) -> Option<(Robot, Vec<Frame>)> {
        let n = self.kind.len();
        if n > MAX_SENSORS {
            return None;
        }
        let mut robot = robot.clone();
        robot.rig.sensors = (0..n).map(|i| self.sensor(i)).collect();
        robot.names = (0..n).map(|i| format!("ray{i}")).collect();
        let sensed = frames.iter().zip(&self.scans).map(|(frame, scan)| {
            let mut ranges = [RangeInput::Missing; MAX_SENSORS];
            for (range, metres) in ranges.iter_mut().zip(scan.iter().flatten()) {
                *range = if metres.is_nan() { RangeInput::Missing } else { RangeInput::Metres(*metres) };
            }
            Frame { sample: Sample { ranges, ..frame.sample }, ..*frame }
        });
        Some((robot, sensed.collect()))
    }

    fn sensor(&self, index: usize) -> RangeSensor {
        RangeSensor {
            mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: self.kind.bearing_rad(index) as f32 },
            min_m: 0.05,
            max_m: self.kind.reach_m() as f32,
            max_incidence_rad: 80f32.to_radians(),
            gain_sigma: 0.0,
            model: RangeModel::Metric { noise_m: self.kind.sigma_m() as f32, noise_rel: 0.0 },
        }
    }
}

/// A scan as single readings of a relative.
pub fn beams_of(kind: ScannerKind, ranges: &[f32]) -> Vec<Option<Beam>> {
    let beam = |(i, range): (usize, &f32)| {
        (!range.is_nan()).then(|| Beam {
            origin: Point::zeros(),
            bearing: kind.bearing_rad(i),
            opening: kind.opening_rad(),
            range: f64::from(*range),
            sigma: kind.sigma_m(),
        })
    };
    ranges.iter().enumerate().map(beam).collect()
}
