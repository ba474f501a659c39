//! A drive in a map that was there before: what that map knows is what was seen of its walls from where the map is.

use heapless::Vec;
use slam_core::kept::{Kept, KeptWall, POSE_STATES};
use slam_core::{Pose, SURFACE_M, angle};

use crate::diary::Diary;
use crate::frame::dot;
use crate::group::{Group, NO_SENSOR};
use crate::keyframe::Keyframe;
use crate::names::Name;
use crate::record::FOUND;
use crate::wall::Wall;

/// The filter's state that is the grid's direction.
const ALPHA: usize = POSE_STATES;

/// Two walls at a smaller angle than this do not say where the map is, as the sine of that angle.
const LEAST_SINE: f32 = 0.5;

/// A wall counts for no more hits than this, about as many as one visit leaves: one that is no longer there is outvoted then.
const MOST_HITS: u32 = 100;

/// Half of a wall is at least so long, metres.
const LEAST_HALF_M: f32 = 0.05;

/// From so far before a wall it is seen, metres: any distance, but on the side that is seen.
const BEFORE_M: f32 = 0.1;

/// What a number is the sum of: states of the filter, and its derivatives by them.
type Terms = [(usize, f32)];

/// At most so many places that walls are seen from: one is the whole map's, the others are of parts of it.
const PLACES: usize = 4;

/// A wall that no place so far tells better than this makes a place of its own, 1-sigma, metres: what a keyframe can say of how far a part is off.
const PART_M: f32 = 0.01;

/// Walls at a smaller angle than this are parallel, as its sine: three degrees.
const PARALLEL_SINE: f32 = 0.05;

/// Where the map as a whole is: two of its walls are where they are in it, and its grid has the direction that it has. Or where a part of it
/// is, along the normal of one of its walls: that wall is.
///
/// Beside what walls are known to lie to each other there is an error that all share, of where the drive that drew them had begun, and one that
/// those of a room share which doorways alone join to the others. Each wall by itself, as if its errors were its own, would tell that again,
/// and two of such a room, known to millimetres beside each other, would be taken to be decimetres off.
struct Gauge {
    /// States of the two walls' offsets, and their normals' inverse: columns. Of a part, that of its wall, and its normal.
    offsets: [usize; 2],
    inverse: [[f32; 2]; 2],
}

/// The places that a map's walls are seen from: the whole map's, and those of parts in the order of their variances beside it, m^2.
struct Gauges<const W: usize> {
    all: Vec<(Gauge, f32), PLACES>,
    /// From which of them each wall is known best.
    nearest: [usize; W],
}

impl Gauge {
    /// By the wall that most readings met, and of those across it again that; none where there are no two such.
    fn of(map: &dyn Kept) -> Option<Self> {
        let first = walls(map).map(|(_, wall)| wall).max_by_key(|wall| wall.updates)?;
        let normal = normal(map, &first);
        let sine = |wall: &KeptWall| cross(normal, self::normal(map, wall));
        let others = walls(map).map(|(_, wall)| wall).filter(|wall| sine(wall).abs() > LEAST_SINE);
        let second = others.max_by_key(|wall| wall.updates)?;
        let ([a, b], [c, d], sine) = (normal, self::normal(map, &second), sine(&second));
        let inverse = [[d / sine, -c / sine], [-b / sine, a / sine]];
        Some(Self { offsets: [first.rho.into(), second.rho.into()], inverse })
    }

    /// By one wall, along its normal.
    fn of_part(map: &dyn Kept, wall: &KeptWall) -> Self {
        Self { offsets: [wall.rho.into(); 2], inverse: [normal(map, wall), [0.0; 2]] }
    }

    /// Whether it tells where something is along this direction.
    fn tells(&self, along: [f32; 2]) -> bool {
        let [a, b] = self.inverse;
        b != [0.0; 2] || cross(a, along).abs() < PARALLEL_SINE
    }

    /// By how much the map is moved along a direction, times `factor`.
    fn moved(&self, along: [f32; 2], factor: f32) -> [(usize, f32); 2] {
        let [a, b] = self.inverse.map(|column| factor * dot(along, column));
        [(self.offsets[0], a), (self.offsets[1], b)]
    }

    /// Variances of where it is, on each axis, m^2, and of how it is turned, rad^2.
    fn variances(&self, map: &dyn Kept) -> [f32; 2] {
        let along = |axis| {
            let [a, b] = self.moved(axis, 1.0);
            variance(map, &[a, b])
        };
        [0.5 * (along([1.0, 0.0]) + along([0.0, 1.0])), map.covariance(ALPHA, ALPHA)]
    }

    /// Variance of a wall's offset at its middle, as it is seen from where this is, m^2; none where that does not tell.
    fn variance_m2(&self, map: &dyn Kept, wall: &KeptWall) -> Option<f32> {
        let (normal, direction, at_m) = (normal(map, wall), wall.direction.turns_with(), middle_m(wall));
        let [a, b] = self.moved(normal, -1.0);
        let terms = [(wall.rho.into(), 1.0), (direction, -at_m), a, b, (ALPHA, at_m)];
        self.tells(normal).then(|| variance(map, &terms))
    }

    /// A wall as it is seen from where this is.
    fn sighting(&self, map: &dyn Kept, kept: &KeptWall, wall: &Wall) -> Group {
        let line = wall.line();
        let half_m = (0.5 * (wall.hi_m - wall.lo_m)).max(LEAST_HALF_M);
        let offset_m2 = self.variance_m2(map, kept).unwrap_or(f32::INFINITY);
        let turn_rad2 = variance(map, &[(kept.direction.turns_with(), 1.0), (ALPHA, -1.0)]);
        // Where its direction is less known than hits spread evenly along it would tell, it counts as those that tell that.
        let known_m2 = offset_m2.max(turn_rad2 * half_m * half_m / 3.0) + SURFACE_M * SURFACE_M;
        let (mean_m, weight) = (line.at(wall.anchor_m), 1.0 / known_m2);
        let before_m = [0, 1].map(|i| mean_m[i] - BEFORE_M * line.normal[i]);
        let [tx, ty] = line.tangent();
        let scatter = weight * half_m * half_m / 3.0;
        let mut seen = Group::of(before_m, mean_m, weight, 1.0, NO_SENSOR);
        seen.scatter = [scatter * tx * tx, scatter * tx * ty, scatter * ty * ty];
        seen.hits = wall.hits as u16;
        seen
    }
}

impl<const W: usize> Gauges<W> {
    /// A part is by the wall that most readings met of those that no place so far tells; none where the map does not tell where it is.
    fn of(map: &dyn Kept) -> Option<Self> {
        let mut all = Vec::new();
        let mut known_m2 = [f32::INFINITY; W];
        let mut next = Some((Gauge::of(map)?, 0.0));
        while let Some(place) = next {
            for ((_, wall), known_m2) in walls(map).zip(&mut known_m2) {
                *known_m2 = place.0.variance_m2(map, &wall).unwrap_or(f32::INFINITY).min(*known_m2);
            }
            let before = all.iter().filter(|(_, known_m2)| *known_m2 <= place.1).count();
            // There is room for it.
            let _ = all.insert(before, place);
            let untold = walls(map).zip(&known_m2).filter(|(_, known_m2)| **known_m2 > PART_M * PART_M);
            let others = untold.map(|((_, wall), _)| wall).filter(|wall| wall.direction.turns_with() == ALPHA);
            next = others.max_by_key(|wall| wall.updates).filter(|_| !all.is_full()).and_then(|wall| {
                let (whole, _) = all.first()?;
                Some((Gauge::of_part(map, &wall), whole.variance_m2(map, &wall)?))
            });
        }
        let mut nearest = [0; W];
        for ((_, wall), nearest) in walls(map).zip(&mut nearest) {
            let known =
                all.iter().enumerate().filter_map(|(at, (place, _))| Some((at, place.variance_m2(map, &wall)?)));
            *nearest = known.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(at, _)| at);
        }
        Some(Self { all, nearest })
    }
}

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// A diary that has begun goes on in a map that was there before, with the robot there in it; nothing is changed where that map does not
    /// tell where it is.
    pub(crate) fn begin_in(&mut self, map: &dyn Kept, robot: &Pose) {
        const { assert!(K >= 2 + PLACES) };
        if !map.frame().has_grid {
            return;
        }
        let Some(Gauges { all, nearest }) = Gauges::<W>::of(map) else { return };
        let Some((whole, _)) = all.first() else { return };
        self.odometry.map_variances = whole.variances(map);
        self.keyframes.clear();
        let poses = core::iter::repeat_n(Pose::ORIGIN, 1 + all.len()).chain([*robot]);
        for (serial, pose) in (0..).zip(poses) {
            // There is room for these.
            let _ = self.keyframes.push(Keyframe::at(serial, pose));
        }
        let [origin, places @ .., _] = self.keyframes.as_mut_slice() else { return };
        origin.hold_map();
        for (key, pair) in places.iter_mut().zip(all.windows(2)) {
            if let [(_, known_m2), (_, next_m2)] = pair {
                key.hold_part(float::sqrtf(next_m2 - known_m2));
            }
        }
        if let Some(last) = places.last_mut() {
            last.part_from(robot, &self.calibration, FOUND);
        }
        for (at, (key, (place, _))) in places.iter_mut().zip(&all).enumerate() {
            let all_walls = walls(map).zip(&nearest).zip(&mut self.walls);
            for (((index, kept), _), slot) in all_walls.filter(|((_, nearest), _)| **nearest == at) {
                let wall = drawn(map, &kept);
                let mut seen = place.sighting(map, &kept, &wall);
                seen.set_wall(Some(index));
                let name = Name { id: kept.id, wall: index as u8 };
                // There are more names than walls.
                if self.groups.push(seen).is_ok() && self.names.push(name).is_ok() {
                    *slot = Some(wall);
                    key.groups += 1;
                }
            }
        }
    }
}

/// A kept wall where the map has it.
fn drawn(map: &dyn Kept, kept: &KeptWall) -> Wall {
    let [rho_m, beta_rad] = map.line(kept);
    let hits = kept.updates.min(MOST_HITS);
    let anchor_m = middle_m(kept);
    Wall { rho_m, beta_rad, lo_m: kept.lo_m, hi_m: kept.hi_m, hits, anchor_m, is_placed: true, ..Wall::NEW }
}

/// The walls of a map and their numbers, from the first on without a gap.
fn walls(map: &dyn Kept) -> impl Iterator<Item = (usize, KeptWall)> {
    (0..usize::from(map.frame().walls)).map_while(|index| Some((index, map.wall(index)?)))
}

/// The middle of a wall's extent along it, metres.
fn middle_m(wall: &KeptWall) -> f32 {
    0.5 * (wall.lo_m + wall.hi_m)
}

fn normal(map: &dyn Kept, wall: &KeptWall) -> [f32; 2] {
    angle::normal(map.line(wall)[1])
}

fn cross([a, b]: [f32; 2], [c, d]: [f32; 2]) -> f32 {
    a * d - b * c
}

/// Variance of a sum of states.
#[inline(never)]
fn variance(map: &dyn Kept, terms: &Terms) -> f32 {
    let mut sum = 0.0;
    for &(i, u) in terms {
        for &(j, v) in terms {
            sum += u * v * map.covariance(i, j);
        }
    }
    sum.max(0.0)
}
