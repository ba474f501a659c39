//! Which wall a beam meets first.

use crate::filter::ekf::EkfView;
use crate::geometry::line::Line;
use crate::measurement::beam::Beam;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::GAP_M;
use crate::walls::wall::{Direction, Wall};

/// Largest length by which one reading alone prolongs a wall, metres: half a gap, since a wider one takes a line of readings.
const PROLONGATION_M: f32 = 0.5 * GAP_M;

/// Upper limit of a prolongation, metres: the narrowest door.
const DOOR_M: f32 = 0.6;

/// Prolongation in steps of the robot: successive readings along a wall are one step apart, and turns add to that.
const STEPS: f32 = 1.25;

/// Beams flatter than this (cosine of 85 degrees) neither hit nor cross a wall in any useful sense.
const GRAZING_COS: f32 = 0.087;

/// A wall that a beam meets.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Index into the list of walls.
    pub index: usize,
    /// Its line.
    pub line: Line,
    /// Range along the beam, metres.
    pub range_m: f32,
    /// Cosine of the incidence angle.
    pub cos_incidence: f32,
    /// Coordinate along the wall at which the beam meets it, metres.
    pub along_m: f32,
    /// How far inside the wall's observed extent that is, metres; negative outside.
    pub inside_m: f32,
}

/// How far one reading alone may prolong a wall, metres, for a robot that moves so far in a step.
pub fn prolongation_m(step_m: f32) -> f32 {
    (STEPS * step_m).clamp(PROLONGATION_M, DOOR_M)
}

/// The nearest wall that the beam meets at more than `beyond_m` and less than `within_m`, within its extent and
/// `prolongation_m` more.
pub fn first_met(
    ekf: &EkfView,
    grid: &ManhattanFrame,
    walls: &[Wall],
    beam: &Beam,
    beyond_m: f32,
    within_m: f32,
    prolongation_m: f32,
) -> Option<Candidate> {
    // The grid has four directions: what a wall needs of them is computed once for all walls.
    let facing = [0, 1, 2, 3].map(|quarter| Facing::new(grid.normal(quarter), beam));
    let mut nearest: Option<Candidate> = None;
    let mut limit_m = within_m;
    for (index, wall) in walls.iter().enumerate() {
        let quarter = match wall.direction {
            Direction::Grid(quarter) => Some(quarter),
            Direction::Snapped(theta) => Some(grid.quarter(ekf.mean(usize::from(theta)))),
            Direction::Free(_) | Direction::NearGrid(..) | Direction::Built(..) => None,
        };
        let facing = match quarter {
            Some(quarter) => facing[usize::from(quarter & 3)],
            None => Facing::new(wall.line(ekf, grid).normal, beam),
        };
        // Behind the beam, seen from its back, or farther than what is already known to stop the beam.
        if facing.cos_incidence < GRAZING_COS {
            continue;
        }
        let distance = ekf.mean(wall.rho()) - facing.origin_m;
        if distance <= beyond_m * facing.cos_incidence || distance >= limit_m * facing.cos_incidence {
            continue;
        }
        let range_m = distance / facing.cos_incidence;
        let line = wall.line(ekf, grid);
        let along_m = line.along(beam.at(range_m));
        let inside_m = (along_m - wall.lo_m).min(wall.hi_m - along_m);
        if inside_m > -prolongation_m {
            limit_m = range_m;
            nearest = Some(Candidate { index, line, range_m, cos_incidence: facing.cos_incidence, along_m, inside_m });
        }
    }
    nearest
}

/// How a wall's normal stands to a beam.
#[derive(Clone, Copy)]
struct Facing {
    /// Cosine of the incidence angle.
    cos_incidence: f32,
    /// Coordinate of the beam's origin along the normal, metres.
    origin_m: f32,
}

impl Facing {
    fn new(normal: [f32; 2], beam: &Beam) -> Self {
        let [x, y] = beam.origin;
        Self {
            cos_incidence: normal[0] * beam.direction[0] + normal[1] * beam.direction[1],
            origin_m: x * normal[0] + y * normal[1],
        }
    }
}
