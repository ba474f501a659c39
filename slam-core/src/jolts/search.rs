//! The displacement of the robot under which its last readings fit the map best, and how likely it is.

use crate::filter::density::density;
use crate::filter::ekf::EkfView;
use crate::geometry::angle::{normal, sin_cos};
use crate::geometry::matrix::{Triangle, determinant, inverse};
use crate::geometry::pose::length;
use crate::jolts::recent::{READINGS, Seen, Sighting};
use crate::measurement::beam::{Beam, Prediction};
use crate::measurement::derivatives::by_pose_and_wall;
use crate::measurement::line_of_sight::{Candidate, first_met};
use crate::rig::RangeSensor;
use crate::sensing::range::{Innovation, SURFACE_M};
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapView;

/// How far a jolt moves a robot, each axis, metres, and turns it, radians, 1-sigma: by a foot's push or a swinging door, by
/// a rug's edge or while the wheels turn against a threshold for a second.
pub const JOLT: [f32; 3] = [0.2, 0.2, 0.25];

/// The same of a wheel that slips by one to three centimetres, and of a filter that took readings of one wall for another's.
pub const SLIP: [f32; 3] = [0.05, 0.05, 0.1];

/// Walls lie to one another as the map says, to this, metres.
const WALLS_M: f32 = 0.01;

/// Share of readings of anything else than the wall: the odds of the gate, one to two, for a third.
pub const ELSE: f32 = 0.3;

/// What a sensor's readings of one wall can say, as log odds: in one look of so many thousands it is not the robot that moved but what
/// it sees, a chair, a bin, a curtain, a door. Another sensor sees another place of the wall.
pub const WALL_SAYS: f32 = 9.0;

/// Readings that end nearer to each other are of one place, centimetres: about a chair's leg.
const PLACE_CM: f32 = 5.0;

/// Turns with which the search begins, in tenths of a radian: neighbours are half of what a beam at half its span can be off
/// and meet its wall.
const TURNS: [f32; STARTS] = [0.0, 1.2, -1.2, 2.4, -2.4, 3.6, -3.6];

/// Displacements that differ by more, metres or radians, are two.
const APART: (f32, f32) = (0.05, 0.1);

/// Number of starts.
pub const STARTS: usize = 7;

/// Standard deviations with which readings are held against walls, one after the other, metres: from what a jolt moves to
/// what sensors have (graduated non-convexity, Blake and Zisserman 1987).
const ROUNDS_M: [f32; 6] = [0.12, 0.08, 0.05, 0.02, 0.0, 0.0];

/// So many readings are held against so many walls in a turn, one with another: twenty against sixty-four, four times.
pub const STEP_HOLDS: usize = 4 * READINGS * 64;

/// The last round and the odds after it take as much as so many others.
const LAST_ROUNDS: usize = 3;

/// A wall met so little beyond its end is met.
const BEYOND_END_M: f32 = 0.05;

/// A displacement of the robot, in the map, about where it is now.
#[derive(Clone, Copy, Debug)]
pub struct Displacement {
    /// x and y, metres, and turn, radians.
    pub by: [f32; 3],
    /// Their covariance.
    pub covariance: [[f32; 3]; 3],
    /// Log of the odds for it and against none.
    pub log_odds: f32,
}

impl Displacement {
    /// The same displacement about what is so far from here in the map, metres.
    pub fn about(&mut self, [x, y]: [f32; 2]) {
        let [c, s] = normal(self.by[2]);
        self.by[0] += (c - 1.0) * x - s * y;
        self.by[1] += s * x + (c - 1.0) * y;
    }
}

/// A displacement in less memory, as it waits for its confirmation.
#[derive(Clone, Copy, Debug)]
pub struct Packed {
    by: [f32; 3],
    covariance: Triangle,
    log_odds: f32,
}

impl Packed {
    /// Of this one.
    pub fn of(&Displacement { by, covariance, log_odds }: &Displacement) -> Self {
        Self { by, covariance: Triangle::of(&covariance), log_odds }
    }

    /// The displacement.
    pub fn displacement(&self) -> Displacement {
        Displacement { by: self.by, covariance: self.covariance.matrix(), log_odds: self.log_odds }
    }
}

/// Whether two displacements, metres, metres and radians, are two: beyond what both are known to.
pub fn are_apart(a: &[f32; 3], b: &[f32; 3]) -> bool {
    let [x, y, turn] = core::array::from_fn(|i| (a[i] - b[i]).abs());
    x.max(y) > APART.0 || turn > APART.1
}

/// The search for a displacement, as far as it has come.
#[derive(Clone, Copy, Debug)]
pub struct Improvement {
    by: [f32; 3],
    round: u8,
}

impl Improvement {
    /// From this displacement on.
    pub const fn from(by: [f32; 3]) -> Self {
        Self { by, round: 0 }
    }

    /// From where a search begins for the `start`th time; none where it began as often as it does.
    pub fn from_start(start: usize) -> Option<Self> {
        TURNS.get(start).map(|turn| Self::from([0.0, 0.0, 0.1 * turn]))
    }
}

/// The beam of a robot that was displaced by so much.
fn displaced(sighting: &Sighting, by: &[f32; 3]) -> Beam {
    let [x_m, y_m, turn_rad] = *by;
    let (s, c) = sin_cos(turn_rad);
    let rotate = |[x, y]: [f32; 2]| [c * x - s * y, s * x + c * y];
    let Beam { arm, origin, direction } = sighting.beam;
    let turned = rotate(arm);
    let origin = [origin[0] - arm[0] + x_m + turned[0], origin[1] - arm[1] + y_m + turned[1]];
    Beam { arm: turned, origin, direction: rotate(direction) }
}

/// The map that readings are held against.
pub struct Scene<'a> {
    /// The state.
    pub ekf: &'a EkfView,
    /// The walls.
    pub map: &'a MapView,
    /// The robot's sensors.
    pub sensors: &'a [RangeSensor],
    /// Share of readings of anything else than the wall where the robot is where the filter has it. Of one that is elsewhere it is [`ELSE`].
    pub others: f32,
}

/// A reading held against the wall that its beam meets.
struct Held {
    met: Candidate,
    innovation_m: f32,
    /// Variance of the reading's own noise and of the surface, m^2.
    own_m2: f32,
    variance_m2: f32,
    prediction: Prediction,
}

/// What a sensor meets by one pose or the other.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Surface {
    wall: u16,
    sensor: u8,
    /// Whether a robot that is where the filter has it should see a wall there.
    is_expected: bool,
}

/// What all of a sensor's readings of one surface say.
#[derive(Clone, Copy, Default)]
struct Said {
    of: Surface,
    log_odds: f32,
    readings: f32,
    /// Number of its places that were seen, and where the last of them is, centimetres.
    places: f32,
    at_cm: [i16; 2],
}

impl Said {
    /// With one more reading of it, which ended there, metres.
    fn with(self, of: Surface, log_odds: f32, end_m: [f32; 2]) -> Self {
        let end_cm = end_m.map(|at_m| libm::roundf(100.0 * at_m) as i16);
        let [x_cm, y_cm] = [0, 1].map(|axis| f32::from(end_cm[axis]) - f32::from(self.at_cm[axis]));
        let is_there = self.readings > 0.0 && length(x_cm, y_cm) < PLACE_CM;
        let (places, at_cm) = if is_there { (self.places, self.at_cm) } else { (self.places + 1.0, end_cm) };
        Self { of, log_odds: self.log_odds + log_odds, readings: self.readings + 1.0, places, at_cm }
    }

    /// All together, those of one place as one: whatever stands there was seen once, by as many readings as came meanwhile. Where no wall
    /// was to be seen there is one that is not in the map yet: if its first reading fits by chance so do the others, so that all say what
    /// one does.
    fn together(&self) -> f32 {
        match self.of.is_expected {
            true => (self.log_odds * self.places / self.readings).clamp(-WALL_SAYS, WALL_SAYS),
            false => self.log_odds / self.readings,
        }
    }
}

impl Scene<'_> {
    /// Goes on, by so many readings that are held against so many walls, towards the displacement under which the readings fit best, by Gauss and Newton's method with each
    /// reading weighed by the probability that it is the wall's. Such displacements are of this size, 1-sigma. The displacement once it is there.
    pub fn go_on(
        &self,
        readings: &[Sighting],
        from: &mut Improvement,
        size: &[f32; 3],
        holds: usize,
    ) -> Option<Displacement> {
        let grid = ManhattanFrame::of(self.ekf);
        let of_round = readings.len() * self.map.walls().len();
        let mut left = holds.checked_div(of_round).unwrap_or(holds).max(LAST_ROUNDS);
        while let Some((&round_m, after)) = ROUNDS_M.get(usize::from(from.round)..).and_then(<[f32]>::split_first) {
            let takes = if after.is_empty() { LAST_ROUNDS } else { 1 };
            left = left.checked_sub(takes)?;
            let covariance = self.round(&grid, readings, &mut from.by, size, round_m);
            from.round += 1;
            if after.is_empty() {
                let found = Displacement { by: from.by, covariance, log_odds: 0.0 };
                return Some(Displacement { log_odds: self.log_odds(readings, readings, &found, size), ..found });
            }
        }
        None
    }

    /// Improves a displacement once, with so much more noise, metres. Its covariance.
    fn round(
        &self,
        grid: &ManhattanFrame,
        readings: &[Sighting],
        by: &mut [f32; 3],
        size: &[f32; 3],
        more_m: f32,
    ) -> [[f32; 3]; 3] {
        let mut information = prior(size);
        let mut gradient: [f32; 3] = core::array::from_fn(|i| -information[i][i] * by[i]);
        for sighting in readings {
            let Some(held) = self.hold(grid, &sighting.seen, &displaced(sighting, by), more_m) else { continue };
            let [fits, anything] = self.likelihoods(&held, sighting, ELSE);
            let weight = fits / (fits + anything) / held.variance_m2;
            let [by_x, by_y] = held.prediction.by_position;
            let slopes = [by_x, by_y, held.prediction.by_heading];
            for ((row, gradient), by_i) in information.iter_mut().zip(&mut gradient).zip(slopes) {
                *gradient += weight * by_i * held.innovation_m;
                for (entry, by_j) in row.iter_mut().zip(slopes) {
                    *entry += weight * by_i * by_j;
                }
            }
        }
        let covariance = inverse(&information);
        for (by, row) in by.iter_mut().zip(covariance) {
            *by += row[0] * gradient[0] + row[1] * gradient[1] + row[2] * gradient[2];
        }
        covariance
    }

    /// Log of the odds of a robot that saw others against one that saw what the filter takes it to have seen. It is displaced from where
    /// they have it as they fit best; such displacements are of this size, 1-sigma.
    #[inline(never)]
    pub fn rather(&self, others: &[Sighting], readings: &[Sighting], size: &[f32; 3]) -> f32 {
        let grid = ManhattanFrame::of(self.ekf);
        let mut found = Displacement { by: [0.0; 3], covariance: [[0.0; 3]; 3], log_odds: 0.0 };
        for round_m in ROUNDS_M {
            found.covariance = self.round(&grid, others, &mut found.by, size, round_m);
        }
        self.log_odds(others, readings, &found, size)
    }

    /// Log of the odds of a robot that saw others and is displaced from there, against one that saw what the filter takes it to have seen:
    /// what the readings say, what is known of such displacements, and how small a part of them all it is (Laplace's approximation).
    fn log_odds(&self, others: &[Sighting], readings: &[Sighting], found: &Displacement, size: &[f32; 3]) -> f32 {
        let known: f32 = found.by.iter().zip(size).map(|(by, size)| -0.5 * (by / size) * (by / size)).sum();
        let [a, b, c] = size.map(|size| size * size);
        let part = 0.5 * libm::logf((determinant(&found.covariance) / (a * b * c)).max(f32::MIN_POSITIVE));
        self.said(others, &found.by, readings) + known + part
    }

    /// Log of the odds of a displacement against none by what the readings say alone.
    pub fn said_of(&self, readings: &[Sighting], found: &Displacement) -> f32 {
        self.said(readings, &found.by, readings)
    }

    /// Log of the odds of a robot that saw others, displaced by so much, against one that saw what the filter takes it to have seen, by
    /// what the readings say alone.
    #[inline(never)]
    fn said(&self, others: &[Sighting], by: &[f32; 3], readings: &[Sighting]) -> f32 {
        let grid = &ManhattanFrame::of(self.ekf);
        let mut all = [Said::default(); READINGS];
        let mut count = 0;
        for (other, sighting) in others.iter().zip(readings) {
            let Some((of, [with, without])) = self.said_by(grid, sighting, &displaced(other, by)) else { continue };
            let place = all.iter().take(count).position(|said| said.of == of).unwrap_or(count);
            count = count.max(place + 1);
            if let Some(said) = all.get_mut(place) {
                *said = said.with(of, with - without, sighting.beam.at(sighting.seen.range_m));
            }
        }
        all.iter().take(count).map(Said::together).sum()
    }

    /// What one reading should have met, and the log of its density either way; none where it should have met no wall.
    fn said_by(&self, grid: &ManhattanFrame, sighting: &Sighting, other: &Beam) -> Option<(Surface, [f32; 2])> {
        let with = self.hold(grid, &sighting.seen, other, 0.0);
        let without = self.hold(grid, &sighting.seen, &sighting.beam, 0.0);
        let without = without.map(|held| self.as_known(held));
        let says = |held: &Option<Held>, others: f32| {
            let anything = others / self.span_m(&sighting.seen);
            libm::logf(held.as_ref().map_or(anything, |held| self.likelihoods(held, sighting, others).iter().sum()))
        };
        let met = with.as_ref().or(without.as_ref())?.met.index;
        let wall = self.map.walls().get(met).map_or(0, |wall| wall.id);
        let surface = Surface { wall, sensor: sighting.seen.sensor(), is_expected: without.is_some() };
        Some((surface, [says(&with, ELSE), says(&without, self.others)]))
    }

    /// Densities of a reading that is the wall's, and of one that is of anything within the sensor's span, as this share is.
    fn likelihoods(&self, held: &Held, sighting: &Sighting, others: f32) -> [f32; 2] {
        let fits = (1.0 - others) * density(held.innovation_m, held.variance_m2);
        [fits, others / self.span_m(&sighting.seen)]
    }

    /// Length of the beam on which its sensor sees something, metres.
    fn span_m(&self, seen: &Seen) -> f32 {
        self.sensors.get(usize::from(seen.sensor())).map_or(1.0, RangeSensor::span_m)
    }

    /// A reading by this beam, held against the wall that it should have met, with so much more noise.
    fn hold(&self, grid: &ManhattanFrame, seen: &Seen, beam: &Beam, more_m: f32) -> Option<Held> {
        let within_m = seen.range_m + self.span_m(seen);
        let met = first_met(self.ekf, grid, self.map.walls(), beam, 0.0, within_m, BEYOND_END_M)?;
        let prediction = beam.predict(&met.line);
        let across_m2 = WALLS_M * WALLS_M + more_m * more_m;
        let Innovation { value_m, noise_m2 } = seen.reading(self.sensors).innovation(prediction.range_m);
        let own_m2 = noise_m2 + SURFACE_M * SURFACE_M;
        let variance_m2 = own_m2 + across_m2 / (met.cos_incidence * met.cos_incidence);
        Some(Held { met, innovation_m: value_m, own_m2, variance_m2, prediction })
    }

    /// The same with the variance of a robot that is where the filter has it: as well as that is known.
    fn as_known(&self, held: Held) -> Held {
        let Some(wall) = self.map.walls().get(held.met.index) else { return held };
        let known_m2 = self.ekf.variance(&by_pose_and_wall(1.0, wall, &held.prediction, false));
        Held { variance_m2: known_m2 + held.own_m2, ..held }
    }
}

/// Information of what is known of displacements of such a size.
fn prior(size: &[f32; 3]) -> [[f32; 3]; 3] {
    let mut rows = [[0.0; 3]; 3];
    for (i, size) in size.iter().enumerate() {
        rows[i][i] = 1.0 / (size * size);
    }
    rows
}

#[cfg(test)]
mod tests {
    use crate::jolts::search::{Said, Surface, WALL_SAYS};

    #[test]
    fn readings_of_one_place_say_what_one_does() {
        let of = Surface { is_expected: true, ..Surface::default() };
        let together = |ends_m: &[f32]| {
            ends_m.iter().fold(Said::default(), |said, &end_m| said.with(of, 4.0, [1.0 + end_m, -2.0])).together()
        };
        assert_eq!(together(&[0.0; 8]), 4.0);
        assert_eq!(together(&[0.0, 0.02, 0.04]), 4.0);
        assert_eq!(together(&[0.0, 0.02, 0.1, 0.12]), 8.0);
        assert_eq!(together(&[0.0, 0.1, 0.2, 0.3]), WALL_SAYS);
    }
}
