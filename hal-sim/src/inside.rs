//! Where in a plan a robot can be: within an outline, where there is one, and not in a box.

use crate::plan::{Face, Plan};

/// So far before a face's middle is the side from which it is seen, metres.
const BEFORE_M: f64 = 1e-6;

/// Pieces of an area's width and of its depth of which one must be in the home.
const PIECES: u32 = 64;

impl Plan {
    /// Whether a point is within an outline, where the plan has one that closes a home in, and not in a box.
    pub fn is_inside(&self, point_m: [f64; 2]) -> bool {
        is_inside(&self.faces, self.closes_in(), point_m)
    }

    /// Whether the plan has an outline with a home inside.
    pub(crate) fn closes_in(&self) -> bool {
        let before_m = |face: &Face| {
            let normal = face.normal();
            [0, 1].map(|axis| 0.5 * (face.from_m[axis] + face.to_m[axis]) + BEFORE_M * normal[axis])
        };
        let mut faces = self.faces.iter().filter(|face| !face.two_sided);
        faces.any(|face| turns(&self.faces, before_m(face)) > 0)
    }

    /// Whether some of an area with these corners is in the home.
    pub(crate) fn reaches_inside(&self, corners_m: &[[f64; 2]]) -> bool {
        let ends = |axis: usize, points_m: &mut dyn Iterator<Item = [f64; 2]>| {
            points_m.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], at| [lo.min(at[axis]), hi.max(at[axis])])
        };
        // What is beyond the home's own ends is not looked at, so that the pieces of a large area are small.
        let span = [0, 1].map(|axis| {
            let area = ends(axis, &mut corners_m.iter().copied());
            if !self.closes_in() {
                return area;
            }
            let home = ends(axis, &mut self.faces.iter().flat_map(|face| [face.from_m, face.to_m]));
            [area[0].max(home[0]), area[1].min(home[1])]
        });
        let at = |axis: usize, piece: u32| {
            let [lo, hi]: [f64; 2] = span[axis];
            lo + (hi - lo) * (f64::from(piece) + 0.5) / f64::from(PIECES)
        };
        let is_empty = span.iter().any(|[lo, hi]| lo >= hi);
        let mut pieces = (0..PIECES * PIECES).map(|piece| [at(0, piece % PIECES), at(1, piece / PIECES)]);
        !is_empty && pieces.any(|point_m| encloses(corners_m, point_m) && self.is_inside(point_m))
    }
}

/// The same by the plan's faces, and whether they close a home in.
pub(crate) fn is_inside(faces: &[Face], closes_in: bool, point_m: [f64; 2]) -> bool {
    match turns(faces, point_m) {
        1.. => true,
        0 => !closes_in,
        _ => false,
    }
}

/// How often the faces that are seen from one side run around a point: an outline once, a box once the other way.
fn turns(faces: &[Face], point_m: [f64; 2]) -> i32 {
    let ends = faces.iter().filter(|face| !face.two_sided).map(|face| (face.from_m, face.to_m));
    ends.map(|(from_m, to_m)| crossing(from_m, to_m, point_m)).sum()
}

/// Whether a closed line runs around a point.
pub(crate) fn encloses(points_m: &[[f64; 2]], point_m: [f64; 2]) -> bool {
    edges(points_m).filter(|(from_m, to_m)| crossing(*from_m, *to_m, point_m) != 0).count() % 2 == 1
}

/// How a line crosses the ray from a point along x: 1 upwards, -1 downwards, 0 not at all.
fn crossing([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [x_m, y_m]: [f64; 2]) -> i32 {
    if (ay > y_m) == (by > y_m) || x_m >= ax + (y_m - ay) / (by - ay) * (bx - ax) {
        return 0;
    }
    if by > ay { 1 } else { -1 }
}

/// The pieces of a closed line.
pub(crate) fn edges(points_m: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    points_m.iter().copied().zip(points_m.iter().copied().cycle().skip(1))
}

/// Two pieces of a closed line that cross each other, by the index of the point in which each begins; none where it does not cross
/// itself.
pub(crate) fn crossing_edges(points_m: &[[f64; 2]]) -> Option<(usize, usize)> {
    let pieces: Vec<_> = edges(points_m).collect();
    let crossed = |(i, a): (usize, &([f64; 2], [f64; 2]))| {
        let other = pieces.iter().skip(i + 1).position(|b| are_crossing(*a, *b))?;
        Some((i, i + 1 + other))
    };
    pieces.iter().enumerate().find_map(crossed)
}

/// Whether each of two lines has an end on either side of the other.
fn are_crossing((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    let side = |from: [f64; 2], to: [f64; 2], at: [f64; 2]| {
        (to[0] - from[0]) * (at[1] - from[1]) - (to[1] - from[1]) * (at[0] - from[0])
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use crate::plan_file::{BUILT_IN, load};

    #[test]
    fn every_home_s_start_is_inside_and_what_is_far_off_is_not() {
        let random = (0..30).flat_map(|seed| [format!("random-{seed}"), format!("large-{seed}")]);
        for name in BUILT_IN.map(|(name, _)| name.to_owned()).into_iter().chain(random) {
            let plan = load(&name).unwrap();
            assert!(plan.is_inside([plan.start.x_m, plan.start.y_m]), "{name}");
            assert!(!plan.is_inside([100.0, 100.0]) && !plan.is_inside([-100.0, plan.start.y_m]), "{name}");
        }
    }
}
