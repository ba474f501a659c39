//! Walls and beams as they lie at present.

use std::collections::BTreeSet;

/// Where on a wall readings ended is told in pieces of this length, metres.
pub const STRETCH_M: f64 = 0.25;

/// Readings on a wall are within so many sigmas of it.
pub const SIGMAS: f64 = 3.0;

/// A wall's line and what was seen of it.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Its number.
    pub wall: usize,
    /// Offset of its line, metres.
    pub rho_m: f64,
    /// Direction of the normal, radians.
    pub beta_rad: f64,
    /// Where along it readings ended, metres.
    pub span_m: [f64; 2],
    /// Which stretches of [`STRETCH_M`] along it they were on.
    pub stretches: BTreeSet<i64>,
    /// How many.
    pub count: usize,
}

/// One reading's beam.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Where it began, metres.
    pub from_m: [f64; 2],
    /// Where it ended, metres.
    pub end_m: [f64; 2],
    /// 1-sigma of that along the beam, metres.
    pub sigma_m: f64,
    /// Least cosine of the incidence at which its sensor sees a wall.
    pub min_cos: f64,
    /// The wall that it is on.
    pub wall: Option<usize>,
}

/// What a beam is to a wall that it ran towards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// How far behind the wall it ended, metres.
    pub behind_m: f64,
    /// Where along the wall it ended, metres.
    pub along_m: f64,
    /// Where along the wall it went through its line, metres; none where it ended before it or began behind it.
    pub through_m: Option<f64>,
}

impl Seen {
    /// None where the beam saw no more than the wall's edge, or its back.
    pub fn meet(&self, beam: &Beam) -> Option<Meeting> {
        let [from, end] = [beam.from_m, beam.end_m].map(|at| self.local(at));
        let [along, behind] = [end[0] - from[0], end[1] - from[1]];
        if behind <= beam.min_cos * along.hypot(behind) {
            return None;
        }
        let goes_through = from[1] < 0.0 && end[1] > 0.0;
        let through_m = goes_through.then(|| end[0] - end[1] / behind * along);
        Some(Meeting { behind_m: end[1], along_m: end[0], through_m })
    }

    /// The stretch that a place along the wall is in.
    pub fn stretch(along_m: f64) -> i64 {
        (along_m / STRETCH_M).floor() as i64
    }

    /// Along the wall and behind it, metres.
    fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.beta_rad.sin_cos();
        [c * y - s * x, c * x + s * y - self.rho_m]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The wall y = 2, seen from below, along -x.
    fn wall() -> Seen {
        let beta_rad = std::f64::consts::FRAC_PI_2;
        Seen { wall: 0, rho_m: 2.0, beta_rad, span_m: [-1.0, 1.0], stretches: BTreeSet::new(), count: 10 }
    }

    fn beam(from_m: [f64; 2], end_m: [f64; 2]) -> Beam {
        Beam { from_m, end_m, sigma_m: 0.02, min_cos: 0.3, wall: None }
    }

    #[test]
    fn a_beam_ends_before_a_wall_or_goes_through_it() {
        let found = wall().meet(&beam([0.0, 0.0], [-0.5, 1.0])).expect("it runs towards the wall");
        assert!((found.behind_m + 1.0).abs() < 1e-12 && (found.along_m - 0.5).abs() < 1e-12, "{found:?}");
        assert_eq!(found.through_m, None);
        let found = wall().meet(&beam([0.0, 0.0], [-1.5, 3.0])).expect("it runs towards the wall");
        assert!((found.behind_m - 1.0).abs() < 1e-12 && (found.along_m - 1.5).abs() < 1e-12, "{found:?}");
        assert!(found.through_m.is_some_and(|along_m| (along_m - 1.0).abs() < 1e-12), "{found:?}");
        let found = wall().meet(&beam([0.0, 2.5], [0.0, 3.0])).expect("it runs the way that the wall is seen");
        assert_eq!(found.through_m, None, "it began behind the wall");
    }

    #[test]
    fn a_back_and_an_edge_are_not_seen() {
        assert_eq!(wall().meet(&beam([0.0, 4.0], [0.0, 2.0])), None);
        assert_eq!(wall().meet(&beam([0.0, 1.9], [2.0, 2.0])), None);
    }
}
