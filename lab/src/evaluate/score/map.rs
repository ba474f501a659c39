//! The map against the true plan.
//!
//! Mapped walls are first moved by the alignment of the path, so that the score judges the map's shape and size, not where
//! the start frame lies. A mapped wall matches a true one when both run in the same direction within
//! [`DIRECTION_RAD`], share a stretch and are there no farther apart than [`OFFSET_M`].

use slam_core::WallView;

use crate::evaluate::statistics::rms;
use crate::recording::{MapScore, Pose2, Segment};

/// Largest angle between a mapped wall and the true one that it matches, radians.
pub const DIRECTION_RAD: f64 = 0.175;

/// Largest distance between them, metres, in the middle of the stretch that they share.
pub const OFFSET_M: f64 = 0.15;

/// Length from which a true wall must be in the map, metres.
pub const LONG_M: f64 = 1.0;

/// Length of it that beams must have met before it counts as passed, metres.
pub const PASSED_M: f64 = 0.5;

/// Share of the met length that mapped walls must cover for the true wall to be in the map.
const COVERED: f64 = 0.3;

/// A stretch that two walls share must be this long, metres, or half the mapped wall where that is less.
const SHARED_M: f64 = 0.2;

/// A true wall that the robot passed.
#[derive(Clone, Debug, PartialEq)]
pub struct PassedWall {
    /// The whole wall.
    pub wall: Segment,
    /// The stretches that beams met, from the wall's first end, metres.
    pub stretches_m: Vec<(f64, f64)>,
}

/// Scores a map. `plan` is every true wall, `passed` those that must be in the map, `alignment` what moves the map onto
/// the truth.
pub fn score(walls: &[WallView], plan: &[Segment], passed: &[PassedWall], alignment: &Pose2) -> MapScore {
    let mapped: Vec<Segment> = walls.iter().map(|wall| segment_of(wall, alignment)).collect();
    let offsets: Vec<f64> = mapped.iter().filter_map(|wall| nearest_offset_m(wall, plan)).collect();
    let is_missed = |wall: &&PassedWall| covered_m(wall, &mapped) < COVERED * seen_m(wall);
    MapScore {
        offset_m: rms(&offsets),
        matched: offsets.len(),
        missed: passed.iter().filter(is_missed).count(),
        invented: mapped.len() - offsets.len(),
    }
}

/// The stretch of line that a mapped wall is, moved by `alignment`.
pub fn segment_of(wall: &WallView, alignment: &Pose2) -> Segment {
    let (s, c) = f64::from(wall.beta_rad).sin_cos();
    let rho_m = f64::from(wall.rho_m);
    let end = |along_m: f32| {
        let along_m = f64::from(along_m);
        alignment.transform([rho_m * c - along_m * s, rho_m * s + along_m * c])
    };
    Segment { from_m: end(wall.lo_m), to_m: end(wall.hi_m) }
}

/// Distance of a mapped wall from the true wall that it matches best; none where it matches none.
fn nearest_offset_m(mapped: &Segment, plan: &[Segment]) -> Option<f64> {
    let offsets = plan.iter().filter_map(|wall| {
        let shared = Shared::of(wall, mapped)?;
        (shared.length_m() >= SHARED_M.min(0.5 * length_m(mapped))).then_some(shared.offset_m)
    });
    offsets.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

fn seen_m(passed: &PassedWall) -> f64 {
    passed.stretches_m.iter().map(|(begin_m, end_m)| end_m - begin_m).sum()
}

/// Length of a passed wall's seen stretches that matching mapped walls cover.
fn covered_m(passed: &PassedWall, mapped: &[Segment]) -> f64 {
    let mut covers: Vec<(f64, f64)> = mapped
        .iter()
        .filter_map(|wall| Shared::of(&passed.wall, wall))
        .map(|shared| (shared.begin_m, shared.end_m))
        .collect();
    covers.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut covered_m = 0.0;
    for (begin_m, end_m) in &passed.stretches_m {
        let mut reached_m = *begin_m;
        for cover in &covers {
            let (from_m, to_m) = (cover.0.max(reached_m), cover.1.min(*end_m));
            if to_m > from_m {
                covered_m += to_m - from_m;
                reached_m = to_m;
            }
        }
    }
    covered_m
}

fn length_m(segment: &Segment) -> f64 {
    (segment.to_m[0] - segment.from_m[0]).hypot(segment.to_m[1] - segment.from_m[1])
}

/// What a true and a mapped wall share: a stretch along the true one, from its first end.
struct Shared {
    begin_m: f64,
    end_m: f64,
    /// Distance of the mapped wall in the middle of the stretch, to the left of the true one.
    offset_m: f64,
}

impl Shared {
    /// None where the two do not match.
    fn of(truth: &Segment, mapped: &Segment) -> Option<Self> {
        let length_m = length_m(truth);
        let along = [(truth.to_m[0] - truth.from_m[0]) / length_m, (truth.to_m[1] - truth.from_m[1]) / length_m];
        let local = |point_m: [f64; 2]| {
            let [dx, dy] = [point_m[0] - truth.from_m[0], point_m[1] - truth.from_m[1]];
            [dx * along[0] + dy * along[1], dy * along[0] - dx * along[1]]
        };
        let (mut from, mut to) = (local(mapped.from_m), local(mapped.to_m));
        if from[0] > to[0] {
            (from, to) = (to, from);
        }
        let slope = (to[1] - from[1]) / (to[0] - from[0]);
        let (begin_m, end_m) = (from[0].max(0.0), to[0].min(length_m));
        let offset_m = from[1] + slope * (0.5 * (begin_m + end_m) - from[0]);
        // A mapped wall that is a point, or at right angles, has a slope that is no number or too large.
        let matches = slope.abs() <= DIRECTION_RAD.tan() && end_m > begin_m && offset_m.abs() <= OFFSET_M;
        matches.then_some(Self { begin_m, end_m, offset_m })
    }

    fn length_m(&self) -> f64 {
        self.end_m - self.begin_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slam_core::WallKind;
    use std::f32::consts::FRAC_PI_2;

    const PLAN: [Segment; 2] =
        [Segment { from_m: [0.0, 2.0], to_m: [4.0, 2.0] }, Segment { from_m: [4.0, 2.0], to_m: [4.0, -1.0] }];

    fn wall(rho_m: f32, beta_rad: f32, lo_m: f32, hi_m: f32) -> WallView {
        WallView { id: 0, kind: WallKind::Free, rho_m, beta_rad, lo_m, hi_m, sigma_rho_m: 0.01, updates: 1 }
    }

    fn passed() -> Vec<PassedWall> {
        vec![
            PassedWall { wall: PLAN[0], stretches_m: vec![(0.0, 4.0)] },
            PassedWall { wall: PLAN[1], stretches_m: vec![(0.0, 1.0), (2.0, 3.0)] },
        ]
    }

    #[test]
    fn a_perfect_map_has_no_error() {
        // Along (-sin beta, cos beta): leftwards for beta = 90 degrees.
        let walls = [wall(2.0, FRAC_PI_2, -4.0, 0.0), wall(4.0, 0.0, -1.0, 2.0)];
        let score = score(&walls, &PLAN, &passed(), &Pose2::default());
        assert!(score.offset_m.expect("matches") < 1e-6, "{score:?}");
        assert_eq!((score.matched, score.missed, score.invented), (2, 0, 0));
    }

    #[test]
    fn offsets_inventions_and_omissions_are_told_apart() {
        let walls = [wall(2.03, FRAC_PI_2, -3.0, -1.0), wall(3.0, FRAC_PI_2, -3.0, -1.0), wall(2.0, 1.2, -3.0, -1.0)];
        let score = score(&walls, &PLAN, &passed(), &Pose2::default());
        assert!((score.offset_m.expect("a match") - 0.03).abs() < 1e-6, "{score:?}");
        assert_eq!((score.matched, score.missed, score.invented), (1, 1, 2));
    }

    #[test]
    fn a_map_of_nothing_true_has_no_offset() {
        let nothing = score(&[], &PLAN, &passed(), &Pose2::default());
        assert_eq!((nothing.offset_m, nothing.matched, nothing.missed), (None, 0, 2));
        let invented = score(&[wall(3.0, FRAC_PI_2, -3.0, -1.0)], &PLAN, &passed(), &Pose2::default());
        assert_eq!((invented.offset_m, invented.invented), (None, 1));
    }

    #[test]
    fn a_short_piece_does_not_stand_for_a_whole_wall() {
        let walls = [wall(2.0, FRAC_PI_2, -1.0, 0.0), wall(4.0, 0.0, -1.0, 2.0)];
        assert_eq!(score(&walls, &PLAN, &passed(), &Pose2::default()).missed, 1);
    }

    #[test]
    fn the_alignment_moves_the_map() {
        let alignment = Pose2::new(0.0, 1.0, 0.0);
        let walls = [wall(1.0, FRAC_PI_2, -4.0, 0.0)];
        assert_eq!(score(&walls, &PLAN, &[], &alignment).matched, 1);
    }
}
