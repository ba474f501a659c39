//! Which parts of the true walls the sensors have seen: what a map can fairly be asked to contain.

use crate::plan::Face;

/// Length of one piece of wall in the bookkeeping, metres.
const PIECE_M: f64 = 0.05;

/// For every face of a plan, how often each 5 cm of it returned a beam within a sensor's range and incidence limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    faces: Vec<Face>,
    hits: Vec<Vec<u32>>,
}

/// One wall and what of it was seen.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenWall {
    /// Index into the plan's faces.
    pub face: usize,
    /// The whole wall, in the plan's frame.
    pub wall: Face,
    /// Total length seen, metres.
    pub seen_m: f64,
    /// Beams that ended on it.
    pub hits: u32,
    /// Stretches seen without a break, as (begin, end) along the wall from its first end, metres.
    pub stretches_m: Vec<(f64, f64)>,
}

impl Coverage {
    /// Nothing seen yet.
    pub fn new(faces: &[Face]) -> Self {
        let pieces = |face: &Face| vec![0; (libm::ceil(face.length_m() / PIECE_M) as usize).max(1)];
        Self { faces: faces.to_vec(), hits: faces.iter().map(pieces).collect() }
    }

    /// A beam ended at this point (metres, plan frame) of this face.
    pub fn record(&mut self, face: usize, point_m: [f64; 2]) {
        let (Some(wall), Some(hits)) = (self.faces.get(face), self.hits.get_mut(face)) else { return };
        let along_m = libm::hypot(point_m[0] - wall.from_m[0], point_m[1] - wall.from_m[1]);
        let piece = ((along_m / PIECE_M) as usize).min(hits.len() - 1);
        hits[piece] = hits[piece].saturating_add(1);
    }

    /// The walls at least `length_m` long of which at least `seen_m` were seen, with what was seen of each.
    pub fn walls(&self, length_m: f64, seen_m: f64) -> Vec<SeenWall> {
        let long = |(_, wall): &(usize, &Face)| wall.length_m() >= length_m;
        let walls = self.faces.iter().enumerate().filter(long);
        walls.map(|(face, wall)| self.seen_wall(face, wall)).filter(|seen| seen.seen_m >= seen_m).collect()
    }

    fn seen_wall(&self, face: usize, wall: &Face) -> SeenWall {
        let hits = &self.hits[face];
        let piece_m = wall.length_m() / hits.len() as f64;
        let mut stretches_m: Vec<(f64, f64)> = Vec::new();
        for (i, _) in hits.iter().enumerate().filter(|(_, count)| **count > 0) {
            let (begin_m, end_m) = (i as f64 * piece_m, (i + 1) as f64 * piece_m);
            match stretches_m.last_mut() {
                Some(last) if begin_m - last.1 < 0.5 * piece_m => last.1 = end_m,
                _ => stretches_m.push((begin_m, end_m)),
            }
        }
        let seen_m = stretches_m.iter().map(|(begin_m, end_m)| end_m - begin_m).sum();
        let count = hits.iter().fold(0_u32, |sum, &count| sum.saturating_add(count));
        SeenWall { face, wall: *wall, seen_m, hits: count, stretches_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_are_what_was_hit() {
        let wall = Face { from_m: [0.0, 0.0], to_m: [2.0, 0.0], two_sided: false };
        let mut coverage = Coverage::new(&[wall]);
        for x in [0.51, 0.56, 0.61, 1.99] {
            coverage.record(0, [x, 0.0]);
        }
        let walls = coverage.walls(1.0, 0.1);
        assert_eq!(walls[0].stretches_m.len(), 2);
        assert!((walls[0].seen_m - 0.2).abs() < 1e-9 && walls[0].hits == 4);
        assert!(coverage.walls(2.5, 0.0).is_empty() && coverage.walls(1.0, 0.3).is_empty());
    }
}
