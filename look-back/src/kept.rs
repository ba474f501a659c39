//! A drive in a map that was there before: what that map knows is what was seen of its walls from where the map is.

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

/// Where the map as a whole is: two of its walls are where they are in it, and its grid has the direction that it has.
///
/// Beside what walls are known to lie to each other there is an error that all share, of where the drive that drew them had begun.
/// Each wall by itself, as if its errors were its own, would tell that again.
struct Gauge {
    /// States of the two walls' offsets, and their normals' inverse: columns.
    offsets: [usize; 2],
    inverse: [[f32; 2]; 2],
}

impl Gauge {
    /// By the wall that most readings met, and of those across it again that; none where there are no two such.
    fn of(map: &dyn Kept) -> Option<Self> {
        let walls = || (0..usize::from(map.frame().walls)).filter_map(|index| map.wall(index));
        let first = walls().max_by_key(|wall| wall.updates)?;
        let normal = normal(map, &first);
        let sine = |wall: &KeptWall| cross(normal, self::normal(map, wall));
        let second = walls().filter(|wall| sine(wall).abs() > LEAST_SINE).max_by_key(|wall| wall.updates)?;
        let ([a, b], [c, d], sine) = (normal, self::normal(map, &second), sine(&second));
        let inverse = [[d / sine, -c / sine], [-b / sine, a / sine]];
        Some(Self { offsets: [first.rho.into(), second.rho.into()], inverse })
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

    /// A wall as it is seen from where the map is.
    fn sighting(&self, map: &dyn Kept, kept: &KeptWall, wall: &Wall) -> Group {
        let line = wall.line();
        let half_m = (0.5 * (wall.hi_m - wall.lo_m)).max(LEAST_HALF_M);
        let direction = kept.direction.turns_with();
        let [a, b] = self.moved(line.normal, -1.0);
        let at = wall.anchor_m;
        let offset_m2 = variance(map, &[(kept.rho.into(), 1.0), (direction, -at), a, b, (ALPHA, at)]);
        let turn_rad2 = variance(map, &[(direction, 1.0), (ALPHA, -1.0)]);
        // Where its direction is less known than hits spread evenly along it would tell, it counts as those that tell that.
        let known_m2 = offset_m2.max(turn_rad2 * half_m * half_m / 3.0) + SURFACE_M * SURFACE_M;
        let (mean_m, weight) = (line.at(at), 1.0 / known_m2);
        let before_m = [0, 1].map(|i| mean_m[i] - BEFORE_M * line.normal[i]);
        let [tx, ty] = line.tangent();
        let scatter = weight * half_m * half_m / 3.0;
        let mut seen = Group::of(before_m, mean_m, weight, 1.0, NO_SENSOR);
        seen.scatter = [scatter * tx * tx, scatter * tx * ty, scatter * ty * ty];
        seen.hits = wall.hits as u16;
        seen
    }
}

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// A diary that has begun goes on in a map that was there before, with the robot there in it; nothing is changed where that map does not
    /// tell where it is.
    pub(crate) fn begin_in(&mut self, map: &dyn Kept, robot: &Pose) {
        let Some(gauge) = Gauge::of(map).filter(|_| map.frame().has_grid) else { return };
        self.odometry.map_variances = gauge.variances(map);
        self.keyframes.clear();
        for (serial, pose) in (0..).zip([Pose::ORIGIN, Pose::ORIGIN, *robot]) {
            // There is room for four.
            let _ = self.keyframes.push(Keyframe::at(serial, pose));
        }
        let [origin, whole, ..] = self.keyframes.as_mut_slice() else { return };
        origin.hold_map();
        whole.part_from(robot, &self.calibration, FOUND);
        for (index, slot) in self.walls.iter_mut().enumerate() {
            let Some(kept) = map.wall(index) else { break };
            let wall = drawn(map, &kept);
            let mut seen = gauge.sighting(map, &kept, &wall);
            seen.set_wall(Some(index));
            let name = Name { id: kept.id, wall: index as u8 };
            // There are more names than walls.
            if self.groups.push(seen).is_ok() && self.names.push(name).is_ok() {
                *slot = Some(wall);
                whole.groups += 1;
            }
        }
    }
}

/// A kept wall where the map has it.
fn drawn(map: &dyn Kept, kept: &KeptWall) -> Wall {
    let [rho_m, beta_rad] = map.line(kept);
    let hits = kept.updates.min(MOST_HITS);
    let anchor_m = 0.5 * (kept.lo_m + kept.hi_m);
    Wall { rho_m, beta_rad, lo_m: kept.lo_m, hi_m: kept.hi_m, hits, anchor_m, is_placed: true, ..Wall::NEW }
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
