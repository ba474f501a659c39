//! What the filter saw of its walls: each reading that it used, and on which wall of the end it is.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

use slam_core::{Outcome, RangeModel, RangeSensor, WallView};

use crate::recording::{MapSnapshot, Recording, wrap};

/// Relief of built walls where sensors report metres, and of those that an analogue sensor sees, metres, as the estimator has
/// them.
const RELIEF_M: f64 = 0.015;
const SURFACE_M: f64 = 0.003;

/// Of so many readings of a sensor that reports metres, which say the same, one is one: as the estimator finds on real logs,
/// three to five. An analogue sensor's noise is new each time.
const ALIKE: f64 = 4.0;

/// One reading: where it ended in its keyframe's frame, and on which wall.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// The keyframe.
    pub key: usize,
    /// The wall.
    pub wall: usize,
    /// Where it ended, metres.
    pub end_m: [f64; 2],
    /// How sure that is.
    pub noise: Noise,
}

/// A reading's standard deviation, metres, and of how many it is one.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// 1-sigma, metres.
    pub sigma_m: f64,
    /// Of so many that say the same it is one.
    pub alike: f64,
}

impl Noise {
    /// Of a reading at this range.
    pub fn of(sensor: &RangeSensor, range_m: f64) -> Self {
        match sensor.model {
            RangeModel::Metric { noise_m, noise_rel } => {
                let own_m = f64::from(noise_m).hypot(f64::from(noise_rel) * range_m);
                Self { sigma_m: own_m.hypot(RELIEF_M), alike: ALIKE }
            }
            RangeModel::Sharp { scale_m, exponent, noise_v } => {
                let volts = (range_m / f64::from(scale_m)).powf(1.0 / f64::from(exponent));
                let own_m = f64::from(exponent) * range_m / volts * f64::from(noise_v);
                Self { sigma_m: own_m.hypot(SURFACE_M), alike: 1.0 }
            }
        }
    }
}

/// A line through points by least squares across it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fit {
    n: f64,
    sum: [f64; 2],
    squares: [f64; 3],
    beams: [f64; 2],
}

impl Fit {
    /// Adds a point that a beam of this direction met.
    pub fn add(&mut self, [x, y]: [f64; 2], beam: [f64; 2]) {
        self.n += 1.0;
        self.sum = [self.sum[0] + x, self.sum[1] + y];
        self.squares = [self.squares[0] + x * x, self.squares[1] + x * y, self.squares[2] + y * y];
        self.beams = [self.beams[0] + beam[0], self.beams[1] + beam[1]];
    }

    /// Offset and direction of the normal, which points along the beams.
    pub fn line(&self) -> (f64, f64) {
        let mean = self.sum.map(|sum| sum / self.n);
        let xx = self.squares[0] / self.n - mean[0] * mean[0];
        let xy = self.squares[1] / self.n - mean[0] * mean[1];
        let yy = self.squares[2] / self.n - mean[1] * mean[1];
        let along = 0.5 * (2.0 * xy).atan2(xx - yy);
        let beta = along + FRAC_PI_2;
        let faces = self.beams[0] * beta.cos() + self.beams[1] * beta.sin() > 0.0;
        let beta = if faces { beta } else { along - FRAC_PI_2 };
        (mean[0] * beta.cos() + mean[1] * beta.sin(), wrap(beta))
    }
}

/// Every reading that the filter used: step, sensor, wall, end point.
pub fn met(recording: &Recording) -> impl Iterator<Item = (usize, usize, u16, [f64; 2])> + '_ {
    (0..recording.steps.len()).flat_map(move |step| {
        let readings = recording.readings(step).iter().enumerate();
        readings.filter_map(move |(sensor, reading)| match (reading.outcome, reading.hit_m) {
            (Outcome::Updated { wall, .. }, Some(hit_m)) if hit_m.iter().all(|metres| metres.is_finite()) => {
                Some((step, sensor, wall, hit_m.map(f64::from)))
            }
            _ => None,
        })
    })
}

/// Which wall each merged one became part of: one beside it that has its readings from then on.
pub fn mergers(maps: &[MapSnapshot]) -> BTreeMap<u16, u16> {
    let mut became = BTreeMap::new();
    for pair in maps.windows(2) {
        let [before, after] = pair else { continue };
        let ids: BTreeSet<u16> = after.walls.iter().map(|wall| wall.id).collect();
        for gone in before.walls.iter().filter(|wall| !ids.contains(&wall.id)) {
            let grown = |wall: &&WallView| {
                let had = before.walls.iter().find(|old| old.id == wall.id).map_or(0, |old| old.updates);
                let covers = wall.lo_m - 0.1 < gone.lo_m && wall.hi_m + 0.1 > gone.hi_m;
                let turned = wrap(f64::from(wall.beta_rad - gone.beta_rad));
                turned.abs() < 0.15 && covers && wall.updates >= had + gone.updates
            };
            let nearest = |a: &&WallView, b: &&WallView| {
                let off = |wall: &WallView| (wall.rho_m - gone.rho_m).abs();
                off(a).total_cmp(&off(b))
            };
            if let Some(kept) = after.walls.iter().filter(grown).min_by(nearest) {
                became.insert(gone.id, kept.id);
            }
        }
    }
    became
}
