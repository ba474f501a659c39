//! Readings that repeat one another.
//!
//! Where a sensor that reports metres is off, it is mostly the surface that is: door frames, panels and skirting boards are
//! not the plane that the map has. The next reading on the same stretch of wall is off by the same, whichever sensor makes
//! it, and so is every reading of a robot that stands still. As independent ones they would make the filter sure of what
//! one surface happened to be. How much of the error is the surface's is learned from the innovations: a sensor's own noise
//! is new each time, the surface's is not.

use core::ops::{Deref, DerefMut};

use crate::sensing::bend::Bends;

/// Correlation length of a wall's departure from its plane, metres: the width of a door frame, a pilaster or a panel.
pub const LENGTH_M: f32 = 0.25;

/// Number of steps within which a sensor that met a wall counts as on that wall.
const RECENT: u32 = 10;

/// Largest distance between two hits that are compared, metres: farther ones say little of each other.
const PAIRED_M: f32 = 0.3;

/// Least distance between two hits that are compared, metres: at one place the map is wrong for both.
const APART_M: f32 = 0.01;

/// Pairs that what is believed before any is worth, and over how many the mean is taken at most.
const PRIOR_PAIRS: f32 = 50.0;
const MOST_PAIRS: f32 = 2000.0;

/// Half of the error is the sensor's own at least. Innovations that go together show a filter that lags behind, too: taken
/// for the surface's without limit they would make it lag more.
const MOST_SHARE: f32 = 0.5;

/// Largest number of readings that one repeats: a robot that stands still learns next to nothing new.
const MOST: f32 = 200.0;

/// A reading that was used.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Identifier of the wall.
    pub wall: u16,
    /// Where on the wall, metres.
    pub along_m: f32,
    /// The step it was made in, from 1.
    pub step: u32,
    /// Innovation over its standard deviation.
    pub normalised: f32,
}

/// What is known of how readings repeat one another: [`SurfaceCorrelation`] with its storage, [`SurfaceCorrelationView`]
/// without its size.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceCorrelationInner<L: ?Sized> {
    /// What is common to many readings of a wall, where it is not straight.
    pub bends: Bends,
    pairs: f32,
    /// Mean product of neighbouring normalised innovations, as it would be at the same place.
    product: f32,
    /// Their mean square.
    square: f32,
    /// The last hit of each sensor.
    last: L,
}

/// What is known of `S` sensors.
pub type SurfaceCorrelation<const S: usize> = SurfaceCorrelationInner<[Hit; S]>;

/// What is known of however many sensors.
pub type SurfaceCorrelationView = SurfaceCorrelationInner<[Hit]>;

impl<const S: usize> SurfaceCorrelation<S> {
    /// Nothing seen yet.
    pub const NEW: Self = Self {
        bends: Bends::NONE,
        pairs: 0.0,
        product: 0.0,
        square: 0.0,
        last: [Hit { wall: 0, along_m: 0.0, step: 0, normalised: 0.0 }; S],
    };
}

impl<const S: usize> Deref for SurfaceCorrelation<S> {
    type Target = SurfaceCorrelationView;
    fn deref(&self) -> &SurfaceCorrelationView {
        self
    }
}

impl<const S: usize> DerefMut for SurfaceCorrelation<S> {
    fn deref_mut(&mut self) -> &mut SurfaceCorrelationView {
        self
    }
}

impl SurfaceCorrelationView {
    /// Share of the error that is the surface's: the most until readings tell.
    pub fn share(&self) -> f32 {
        let product = self.product * self.pairs + MOST_SHARE * PRIOR_PAIRS;
        let square = self.square * self.pairs + PRIOR_PAIRS;
        (product / square.max(f32::MIN_POSITIVE)).clamp(0.0, MOST_SHARE)
    }

    /// Effective number of readings that share the error of this stretch of wall, at least 1.
    pub fn count(&self, sensor: usize, wall: u16, along_m: f32, step: u32) -> f32 {
        let is_recent = |hit: &&Hit| hit.step > 0 && hit.wall == wall && step.wrapping_sub(hit.step) < RECENT;
        let sensors = self.last.iter().filter(is_recent).count().max(1) as f32;
        let spacing_m = self.last.get(sensor).filter(is_recent).map_or(LENGTH_M, |hit| (along_m - hit.along_m).abs());
        1.0 + self.share() * (sensors * LENGTH_M / spacing_m.max(1e-4)).min(MOST)
    }

    /// Takes note of a reading that was used.
    pub fn note(&mut self, sensor: usize, hit: Hit) {
        let Some(last) = self.last.get_mut(sensor) else { return };
        let apart_m = (hit.along_m - last.along_m).abs();
        let follows = last.step > 0 && last.wall == hit.wall && hit.step.wrapping_sub(last.step) <= 2;
        if follows && apart_m > APART_M && apart_m < PAIRED_M {
            self.pairs = (self.pairs + 1.0).min(MOST_PAIRS);
            let weight = 1.0 / self.pairs;
            let product = hit.normalised * last.normalised * libm::expf(apart_m / LENGTH_M);
            let square = 0.5 * (hit.normalised * hit.normalised + last.normalised * last.normalised);
            self.product += (product - self.product) * weight;
            self.square += (square - self.square) * weight;
        }
        *last = hit;
    }
}
