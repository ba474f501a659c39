//! Walls that are one: merging them, and the statement that they lie in one plane.

use super::manhattan::ManhattanFrame;
use super::map::MapView;
use super::wall::{Direction, Wall, WallPolicy};
use crate::filter::ekf::{EkfView, Jacobian};
use crate::geometry::line::Line;
use heapless::Vec;

/// Distance within which two stretches of one wall stand in one plane, 1-sigma, metres: plaster, skirting boards.
const FLUSH_M: f32 = 0.005;

/// Merging gate: 99 % of a chi-square distribution with one degree of freedom.
const MERGE_GATE: f32 = 6.63;

/// Merging gate for two places along the walls: 99 % of a chi-square distribution with two degrees of freedom.
const JOINT_GATE: f32 = 9.21;

/// Gate for a wall that is found again after a drift that the filter does not know of: five sigma, and less than
/// [`REFIND_M`].
const REFIND_GATE: f32 = 25.0;

/// Largest distance between a newborn twin and its older wall, metres: beyond it, one may be a cupboard before the other.
const REFIND_M: f32 = 0.5;

/// Sigma of the distance between two walls above which they are vague twins, metres: readings were not held against the
/// wall that they may belong to.
const VAGUE_M: f32 = 0.15;

/// Largest unseen gap between collinear walls that are one, metres: too narrow for a door.
const MERGE_GAP_M: f32 = super::wall::GAP_M;

impl MapView {
    /// Merges wall `index` with the first other wall that is the same one: collinear within the uncertainty of both, and
    /// overlapping or nearly so. True where there was one.
    pub fn merge(&mut self, ekf: &mut EkfView, policy: WallPolicy, index: usize, newborn: bool) -> bool {
        let grid = ManhattanFrame::of(ekf);
        let Some(&wall) = self.walls().get(index) else { return false };
        let line = wall.line(ekf, &grid);
        let mut twins = self.walls().iter().enumerate().filter_map(|(other, candidate)| {
            // A free wall that is one with a wall of the grid is first taken into the grid.
            let comparable = newborn || wall.kind() == candidate.kind();
            if other == index || !comparable {
                return None;
            }
            Tie::between(ekf, &grid, (&wall, &line), candidate, policy, newborn).map(|tie| (other, tie))
        });
        let Some((other, tie)) = twins.next() else { return false };
        // Where the pose does not tell which of two it is, it is neither.
        if tie.is_vague && twins.next().is_some() {
            return false;
        }
        // A newborn twin is made of readings that the older wall's gate refused: the very ones that are off. It shows
        // where the wall goes on, and nothing more, unless it is off by more than readings are, or the gate was.
        if !newborn || tie.refound || tie.is_vague {
            for (difference_m, jacobian) in &tie.differences {
                // A tie that is numerically impossible leaves the filter as it was.
                let _ = ekf.update(-difference_m, jacobian, FLUSH_M * FLUSH_M);
            }
        }
        let (kept, gone) = if !newborn && wall.updates >= tie.updates { (index, other) } else { (other, index) };
        self.unite(ekf, kept, gone);
        true
    }
}

/// The statement that two walls are one, as scalar measurements of zero.
struct Tie {
    /// Distance of the two lines from one another at points they share, the second as it is after the first was made zero,
    /// and its Jacobian.
    differences: Vec<(f32, Jacobian), 2>,
    /// Readings that the other wall has.
    updates: u32,
    /// They differ by more than the filter expects, and yet there cannot be two.
    refound: bool,
    /// How they lie to one another is known so badly that readings could not tell.
    is_vague: bool,
}

impl Tie {
    fn between(
        ekf: &EkfView,
        grid: &ManhattanFrame,
        (wall, line): (&Wall, &Line),
        other: &Wall,
        policy: WallPolicy,
        newborn: bool,
    ) -> Option<Self> {
        // The cheap questions first: most pairs face another way or stand elsewhere.
        let other_way = matches!((wall.direction.quarter(), other.direction.quarter()), (Some(a), Some(b)) if a != b);
        let gap_m = wall.lo_m.max(other.lo_m) - wall.hi_m.min(other.hi_m);
        if other_way || gap_m > MERGE_GAP_M {
            return None;
        }
        let other_line = other.line(ekf, grid);
        let cos = line.normal[0] * other_line.normal[0] + line.normal[1] * other_line.normal[1];
        // Within eight degrees of each other, facing the same way.
        if cos < 0.99 || (line.rho_m - other_line.rho_m).abs() > 1.0 {
            return None;
        }
        // Between the two, or the ends of what they share; for walls with the same direction one point tells all.
        let (a, b) = (wall.lo_m.max(other.lo_m), wall.hi_m.min(other.hi_m));
        let same_direction = matches!(
            (wall.direction, other.direction),
            (Direction::Grid(_) | Direction::Snapped(_), Direction::Grid(_) | Direction::Snapped(_))
        );
        let same_quarter = match (wall.direction, other.direction) {
            (
                Direction::NearGrid(_, a) | Direction::Built(_, a),
                Direction::NearGrid(_, b) | Direction::Built(_, b),
            ) => a == b,
            _ => same_direction,
        };
        let points = if same_direction { [0.5 * (a + b), f32::NAN] } else { [a, b] };
        let mut differences: Vec<(f32, Jacobian), 2> = Vec::new();
        let mut variances: Vec<f32, 2> = Vec::new();
        let mut refound = false;
        let mut is_vague = false;
        for along_m in points.into_iter().filter(|p| p.is_finite()) {
            let (difference_m, jacobian) = apart((wall, line), (other, &other_line), along_m);
            let variance = ekf.variance(&jacobian) + FLUSH_M * FLUSH_M;
            let square = difference_m * difference_m;
            // A wall cannot stand behind another that faces the same way and be seen where the other is.
            let hides = newborn && same_quarter && gap_m < -0.5 * wall.length_m() && difference_m.abs() < REFIND_M;
            let fits = square <= MERGE_GATE * variance;
            // Not a number, no merger.
            if !(fits || hides && square <= REFIND_GATE * variance) {
                return None;
            }
            refound |= !fits;
            is_vague |= variance > VAGUE_M * VAGUE_M;
            let _ = differences.push((difference_m, jacobian));
            let _ = variances.push(variance);
        }
        if let ([(first_m, _), (second_m, _)], &[first_m2, second_m2]) = (differences.as_mut_slice(), &variances[..]) {
            // The difference halfway is the mean of both; its variance tells their covariance.
            let (_, halfway) = apart((wall, line), (other, &other_line), 0.5 * (a + b));
            let mean_m2 = ekf.variance(&halfway) + 0.5 * FLUSH_M * FLUSH_M;
            let covariance_m2 = 2.0 * mean_m2 - 0.5 * (first_m2 + second_m2);
            let gate = if refound { REFIND_GATE } else { JOINT_GATE };
            *second_m = second_if_first_is_zero([*first_m, *second_m], [first_m2, second_m2], covariance_m2, gate)?;
        }
        // What stands beside a vague twin may as well be a cupboard before the next wall. Walls that keep deviations of their own have to
        // fit at two places, and so tell a robot with the odometry of real wheels where it is; Rousse & Qiu's are left as they are.
        if is_vague && policy == WallPolicy::Grid && gap_m > -0.5 * wall.length_m().min(other.length_m()) {
            return None;
        }
        Some(Self { differences, updates: other.updates, refound, is_vague })
    }
}

/// What is left of the second of two differences once the first is zero; none where not both can be zero at once. Two walls
/// askew to one another may differ little for what is known of them at either place, and yet not at both.
fn second_if_first_is_zero(
    [first_m, second_m]: [f32; 2],
    variances_m2: [f32; 2],
    covariance_m2: f32,
    gate: f32,
) -> Option<f32> {
    let [first_m2, second_m2] = variances_m2;
    let gain = covariance_m2 / first_m2;
    let left_m = second_m - gain * first_m;
    let left_m2 = (second_m2 - gain * covariance_m2).max(FLUSH_M * FLUSH_M);
    // Not a number, no merger.
    (first_m * first_m / first_m2 + left_m * left_m / left_m2 <= gate).then_some(left_m)
}

/// Distance of two lines from one another at a place along the first, metres, and its Jacobian.
fn apart((wall, line): (&Wall, &Line), (other, other_line): (&Wall, &Line), along_m: f32) -> (f32, Jacobian) {
    let point = line.at(along_m);
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((wall.rho(), 1.0));
    let _ = jacobian.push((other.rho(), -1.0));
    // The direction turns the line about the origin: d(distance)/dbeta = -along.
    let (i, j) = (wall.direction.turns_with(), other.direction.turns_with());
    if i != j {
        let _ = jacobian.push((i, -line.along(point)));
        let _ = jacobian.push((j, other_line.along(point)));
    }
    (line.distance(point) - other_line.distance(point), jacobian)
}
