//! The measurement model of one beam: its derivatives, and eq. 1 of Rousse & Qiu beside it.

use super::numeric::{beam, derivative, ray_to_line};
use super::random::Random;
use crate::Mount;
use crate::geometry::angle::sin_cos;
use crate::geometry::line::Line;
use crate::measurement::beam::FixedMount;

/// (x, y, theta, rho, beta) and a mount such that the beam meets the line under less than 70 degrees.
fn geometry(random: &mut Random) -> ([f64; 5], [f64; 3]) {
    loop {
        let r = |random: &mut Random, m: f64| f64::from(random.uniform(-m, m) as f32);
        let state = [r(random, 4.0), r(random, 4.0), r(random, 3.1), r(random, 6.0), r(random, 3.1)];
        let mount = [r(random, 0.3), r(random, 0.3), r(random, 3.1)];
        let range = model(&state, mount);
        let (_, phi) = beam([state[0], state[1], state[2]], mount);
        if (state[4] - phi).cos() > 0.34 && range > 0.05 && range < 5.0 {
            return (state, mount);
        }
    }
}

fn model(state: &[f64; 5], mount: [f64; 3]) -> f64 {
    let [x, y, theta, rho, beta] = *state;
    let (origin, phi) = beam([x, y, theta], mount);
    ray_to_line(origin, phi, rho, beta)
}

fn fixed(mount: [f64; 3]) -> FixedMount {
    let [x_m, y_m, bearing_rad] = mount.map(|v| v as f32);
    FixedMount::new(&Mount { x_m, y_m, bearing_rad })
}

fn line(rho: f64, beta: f64) -> Line {
    let (s, c) = sin_cos(beta as f32);
    Line { rho_m: rho as f32, beta_rad: beta as f32, normal: [c, s] }
}

#[test]
fn derivatives_are_those_of_the_ray_for_any_mount() {
    let mut random = Random::new(1);
    for _ in 0..2000 {
        let (state, mount) = geometry(&mut random);
        let [x, y, theta, rho, beta] = state;
        let prediction = fixed(mount).beam([x as f32, y as f32], sin_cos(theta as f32)).predict(&line(rho, beta));
        let expected = [0, 1, 2, 3, 4].map(|i| derivative(|s| model(s, mount), &state, i));
        let [bx, by] = prediction.by_position;
        let exact = [bx, by, prediction.by_heading, prediction.by_rho, prediction.by_beta];
        for (i, (exact, expected)) in exact.iter().zip(expected).enumerate() {
            // Rounding of f32 coordinates of some metres, through divisions by a cosine of at least a third.
            let tolerance = 2e-5 * (1.0 + expected.abs());
            assert!(
                (f64::from(*exact) - expected).abs() < tolerance,
                "entry {i}: {exact} {expected} at {state:?} {mount:?}"
            );
        }
        assert!((f64::from(prediction.range_m) - model(&state, mount)).abs() < 1e-5);
    }
}

/// A reading made while the robot moved comes from a mount that lags behind: the same beam as from the pose then.
#[test]
fn a_lagging_mount_is_the_mount_of_the_pose_then() {
    let mut random = Random::new(2);
    for _ in 0..200 {
        let mount = [random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-3.0, 3.0)];
        let (forward, left, turn) =
            (random.uniform(-0.02, 0.02), random.uniform(-0.005, 0.005), random.uniform(-0.05, 0.05));
        let now = [1.0, -2.0, 0.7f64];
        // The pose from which (forward, left) in the present frame and the turn lead to the present one.
        let (s, c) = now[2].sin_cos();
        let then = [now[0] - c * forward + s * left, now[1] - s * forward - c * left, now[2] - turn];
        let (origin, phi) = beam(then, mount);
        let lagging = fixed(mount).lagging([forward as f32, left as f32], turn as f32);
        let beam = lagging.beam([now[0] as f32, now[1] as f32], sin_cos(now[2] as f32));
        // The lever is turned to first order: half a turn squared of 0.42 m; the direction to third.
        let second_order = 0.5 * turn * turn * 0.43 + 1e-6;
        for (got, expected) in beam.origin.iter().zip(origin) {
            assert!((f64::from(*got) - expected).abs() < second_order, "{got} {expected}");
        }
        let [dx, dy] = beam.direction.map(f64::from);
        assert!((dx * phi.sin() - dy * phi.cos()).abs() < turn.abs().powi(3) + 1e-6);
        assert!((dx.hypot(dy) - 1.0).abs() < turn.powi(4) + 1e-6);
    }
}

/// Eq. 1 of Rousse & Qiu as printed: a sensor at `d` along the robot's long axis, looking under `psi`.
fn printed_eq_1([x, y, theta]: [f64; 3], rho: f64, theta_i: f64, d: f64, psi: f64) -> f64 {
    (x * theta_i.cos() + y * theta_i.sin() - rho + d * (theta - theta_i).cos()) / (theta_i - theta - psi).cos()
}

fn ours(pose: [f64; 3], rho: f64, beta: f64, mount: [f64; 3]) -> f64 {
    let [x, y, theta] = pose.map(|v| v as f32);
    fixed(mount).beam([x, y], sin_cos(theta)).predict(&line(rho, beta)).range_m.into()
}

#[test]
fn equation_1_of_rousse_and_qiu_is_the_negated_range() {
    // In front of a wall at x = 2, with a sensor 0.1 m ahead of the axle: 1.9 m.
    let printed = printed_eq_1([0.0; 3], 2.0, 0.0, 0.1, 0.0);
    assert!((printed + 1.9).abs() < 1e-12);
    assert!((ours([0.0; 3], 2.0, 0.0, [0.1, 0.0, 0.0]) - 1.9).abs() < 1e-6);
    // And so from any pose, for a sensor on the long axis.
    let mut random = Random::new(3);
    for _ in 0..500 {
        let ([x, y, theta, rho, beta], [d, _, psi]) = geometry(&mut random);
        let (pose, mount) = ([x, y, theta], [d, 0.0, psi]);
        let (origin, phi) = beam(pose, mount);
        if (beta - phi).cos() < 0.34 {
            continue;
        }
        let range = ray_to_line(origin, phi, rho, beta);
        assert!((printed_eq_1(pose, rho, beta, d, psi) + range).abs() < 1e-9);
        assert!((ours(pose, rho, beta, mount) - range).abs() < 2e-5);
    }
}

#[test]
fn equation_1_of_rousse_and_qiu_holds_on_the_long_axis_only() {
    // A sensor 0.1 m to the left, looking left at a wall 2 m to the left: 1.9 m. They have only d to put it in.
    let beta = core::f64::consts::FRAC_PI_2;
    assert!((ours([0.0; 3], 2.0, beta, [0.0, 0.1, beta]) - 1.9).abs() < 1e-6);
    assert!((printed_eq_1([0.0; 3], 2.0, beta, 0.1, beta) + 2.0).abs() < 1e-12);
}
