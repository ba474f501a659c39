//! Which wall a beam meets first.

use crate::beam::Beam;
use crate::ekf::Ekf;
use crate::grid::GridDirection;
use crate::wall::{Line, Wall};

/// A wall may be prolonged by a reading over a gap that is too narrow for a door, metres. Doors start at 0.6 m.
pub const PROLONGATION_M: f32 = 0.4;

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
    /// Where along the wall the beam meets it, metres.
    pub along_m: f32,
    /// How far inside the wall's observed extent that is, metres; negative outside.
    pub inside_m: f32,
}

/// The nearest wall that the beam meets at more than `beyond_m`, within its extent plus [`PROLONGATION_M`].
pub fn first_met<const NB: usize, const BLOCKS: usize>(
    ekf: &Ekf<NB, BLOCKS>,
    grid: &GridDirection,
    walls: &[Wall],
    beam: &Beam,
    beyond_m: f32,
    within_m: f32,
) -> Option<Candidate> {
    let mut nearest: Option<Candidate> = None;
    for (index, wall) in walls.iter().enumerate() {
        let line = wall.line(ekf, grid);
        let cos_incidence = beam.cos_incidence(&line);
        let distance = line.distance(beam.origin);
        let limit_m = nearest.map_or(within_m, |n| n.range_m);
        // Behind the beam, seen from its back, or farther than what is already known to stop the beam.
        if cos_incidence < GRAZING_COS || distance <= beyond_m * cos_incidence || distance >= limit_m * cos_incidence {
            continue;
        }
        let range_m = distance / cos_incidence;
        let along_m = line.along(beam.at(range_m));
        let inside_m = (along_m - wall.lo_m).min(wall.hi_m - along_m);
        if inside_m > -PROLONGATION_M {
            nearest = Some(Candidate { index, line, range_m, cos_incidence, along_m, inside_m });
        }
    }
    nearest
}
