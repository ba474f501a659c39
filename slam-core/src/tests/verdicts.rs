//! Lines that are not clearly on the grid decide together.

use core::f32::consts::{FRAC_PI_2, PI};

use crate::births::local_line::LocalLine;
use crate::births::verdict::{Doubts, Verdict, judge};
use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::THETA;
use crate::walls::decision::BUILT_TOLERANCE;
use crate::walls::decision::LOOSE_RAD;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::WallPolicy;

const DEGREE: f32 = PI / 180.0;

/// Variance of walls near the grid about it, rad^2.
const NEAR: f32 = BUILT_TOLERANCE * BUILT_TOLERANCE;

/// A heading known to three degrees, a grid along it, and a line seen `off` degrees from a grid direction.
struct Case {
    ekf: Ekf<{ storage(24) }>,
    policy: WallPolicy,
    doubts: Doubts,
}

impl Case {
    fn new(policy: WallPolicy) -> Self {
        let mut ekf = Ekf::EMPTY;
        for i in 0..4 {
            ekf.augment(0.0, &Jacobian::new(), if i == THETA { 9.0 * DEGREE * DEGREE } else { 0.0 });
        }
        Self { ekf, policy, doubts: Doubts::NONE }
    }

    fn line(quarter: f32, off_deg: f32, seen_m: [f32; 2], path_m: f32) -> LocalLine {
        LocalLine {
            centroid_m: seen_m,
            normal_rad: quarter * FRAC_PI_2 + off_deg * DEGREE,
            variance_m2: 1e-4,
            direction_variance: DEGREE * DEGREE,
            seen_direction_variance: DEGREE * DEGREE,
            length_m: 1.0,
            count: 10,
            seen_m,
            path_m,
            by_calibration: heapless::Vec::new(),
        }
    }

    fn judge(&mut self, quarter: f32, off_deg: f32, seen_m: [f32; 2], path_m: f32) -> Verdict {
        let line = Self::line(quarter, off_deg, seen_m, path_m);
        let grid = ManhattanFrame::of(&self.ekf);
        judge(&self.ekf, self.policy, Some(&grid), &line, &[], &mut self.doubts)
    }
}

#[test]
fn a_line_that_may_be_off_because_the_heading_is_waits() {
    for (off_deg, policy) in [(9.5, WallPolicy::NearGrid), (-9.5, WallPolicy::NearGrid), (9.5, WallPolicy::Grid)] {
        let mut case = Case::new(policy);
        assert_eq!(case.judge(0.0, off_deg, [2.0, 0.0], 1.0), Verdict::Wait);
        // The same wall again tells nothing new.
        assert_eq!(case.judge(0.0, off_deg, [2.0, 2.0], 2.0), Verdict::Wait);
    }
}

#[test]
fn two_walls_off_by_the_same_angle_show_that_the_heading_is() {
    let snapped = WallPolicy::Snapped { theta_moves: false };
    for (policy, verdict) in [
        (WallPolicy::NearGrid, Verdict::NearGrid(1, NEAR)),
        (WallPolicy::Grid, Verdict::NearGrid(1, LOOSE_RAD * LOOSE_RAD)),
        (snapped, Verdict::Wait),
    ] {
        let mut case = Case::new(policy);
        assert_eq!(case.judge(0.0, 9.5, [2.0, 0.0], 1.0), Verdict::Wait);
        assert_eq!(case.judge(1.0, 9.0, [0.0, 2.0], 2.0), verdict);
    }
}

#[test]
fn another_side_of_the_same_thing_neither_agrees_nor_is_waited_with() {
    let mut case = Case::new(WallPolicy::NearGrid);
    assert_eq!(case.judge(0.0, 9.5, [2.0, 0.0], 1.0), Verdict::Wait);
    assert_eq!(case.judge(1.0, 9.0, [2.0, 0.3], 1.5), Verdict::Wait);
    // Farther off than two sides of a thing from the wall that was seen first, along which it would be the same again.
    assert_eq!(case.judge(1.0, 9.0, [0.0, 2.0], 2.0), Verdict::NearGrid(1, NEAR));
}

#[test]
fn two_sides_of_one_thing_or_other_angles_do_not() {
    for (off_deg, seen_m, path_m) in [(9.5, [2.0, 0.5], 2.0), (-9.5, [0.0, 2.0], 2.0), (9.5, [0.0, 2.0], 20.0)] {
        let mut case = Case::new(WallPolicy::NearGrid);
        assert_eq!(case.judge(0.0, 9.5, [2.0, 0.0], 1.0), Verdict::Wait);
        assert_eq!(case.judge(1.0, off_deg, seen_m, path_m), Verdict::Wait, "{off_deg} {seen_m:?} {path_m}");
    }
    // Nor do walls that stand farther off than the heading can be.
    let mut case = Case::new(WallPolicy::NearGrid);
    case.judge(0.0, 20.0, [2.0, 0.0], 1.0);
    assert_eq!(case.judge(1.0, 20.0, [0.0, 2.0], 2.0), Verdict::Free);
}

/// A robot whose heading wanders by five degrees while it sees a wall knows the wall relative to itself, and that is a wall;
/// one that knows its heading and saw too little of the wall to tell where it goes does not.
#[test]
fn a_first_wall_is_judged_by_what_was_seen_of_it() {
    let case = Case::new(WallPolicy::NearGrid);
    let verdict = |direction_deg: f32, seen_deg: f32| {
        let square = |deg: f32| (deg * DEGREE) * (deg * DEGREE);
        let line = LocalLine {
            direction_variance: square(direction_deg),
            seen_direction_variance: square(seen_deg),
            ..Case::line(0.0, 0.0, [2.0, 0.0], 1.0)
        };
        judge(&case.ekf, case.policy, None, &line, &[], &mut { Doubts::NONE })
    };
    assert_eq!(verdict(5.0, 1.0), Verdict::Free);
    assert_eq!(verdict(5.0, 3.0), Verdict::Wait);
}

/// Where the heading is known to six degrees, a wall may stand askew by as much: one line has a direction of its own and
/// turns nothing, two tell.
#[test]
fn one_line_does_not_tell_a_heading_that_is_known_badly() {
    for (heading_deg, first) in [(2.0, Verdict::NearGrid(0, NEAR)), (6.0, Verdict::Free)] {
        let mut case = Case::new(WallPolicy::NearGrid);
        case.ekf.predict(
            [0.0; 3],
            &Default::default(),
            &[[0.0; 3], [0.0; 3], [0.0, 0.0, heading_deg * heading_deg * DEGREE * DEGREE]],
        );
        assert_eq!(case.judge(0.0, 1.0, [2.0, 0.0], 1.0), first, "{heading_deg}");
        assert_eq!(case.judge(1.0, 0.5, [0.0, 2.0], 2.0), Verdict::NearGrid(1, NEAR), "{heading_deg}");
    }
}

/// Lines that are known well to the robot that saw them agree though its heading wandered since.
#[test]
fn two_lines_agree_under_a_heading_that_wanders() {
    let mut case = Case::new(WallPolicy::NearGrid);
    let mut both = |seen_deg: f32| {
        let square = |deg: f32| (deg * DEGREE) * (deg * DEGREE);
        let wandering =
            |line| LocalLine { direction_variance: square(3.0), seen_direction_variance: square(seen_deg), ..line };
        case.doubts = Doubts::NONE;
        let grid = ManhattanFrame::of(&case.ekf);
        [Case::line(0.0, 9.5, [2.0, 0.0], 1.0), Case::line(1.0, 9.0, [0.0, 2.0], 2.0)]
            .map(|line| judge(&case.ekf, case.policy, Some(&grid), &wandering(line), &[], &mut case.doubts))
    };
    assert_eq!(both(1.0), [Verdict::Wait, Verdict::NearGrid(1, NEAR)]);
    // Each to two degrees, the angle between them not.
    assert_eq!(both(1.8), [Verdict::Wait, Verdict::Wait]);
    assert_eq!(both(2.5), [Verdict::Wait, Verdict::Wait]);
}

/// Off the grid a direction may be any of a quarter turn: the odds of nineteen to one are where the normal density on the grid
/// is nineteen times that.
#[test]
fn a_line_is_on_the_grid_up_to_where_the_odds_are_nineteen_to_one() {
    use crate::walls::decision::{GRID_TOLERANCE, decide};
    for (sigma, share) in [(0.01_f64, 0.9_f64), (0.02, 0.8), (0.03, 0.7)] {
        let variance = sigma * sigma + f64::from(GRID_TOLERANCE).powi(2);
        let at_zero = share / (1.0 - share) * core::f64::consts::FRAC_PI_2 / (core::f64::consts::TAU * variance).sqrt();
        let judged = |off: f64| decide(off as f32, (sigma * sigma) as f32, share as f32);
        let angle = |odds: f64| (2.0 * variance * (at_zero / odds).ln()).sqrt();
        assert_eq!(judged(0.99 * angle(19.0)), Some(true));
        assert_eq!(judged(1.01 * angle(19.0)), None);
        assert_eq!(judged(0.99 * angle(1.0 / 19.0)), None);
        assert_eq!(judged(1.01 * angle(1.0 / 19.0)), Some(false));
    }
}
