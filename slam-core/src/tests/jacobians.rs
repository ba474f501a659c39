//! The measurement Jacobian of a whole step, for every kind of wall: seen from outside, in what one update moves.
//!
//! With a diagonal covariance, an update moves state i by P_ii J_i / S times the innovation; a step's report tells
//! innovation and S, so J_i can be read off and held against numerical derivatives of the f64 model.

use std::vec::Vec;

use super::numeric::{beam, derivative, ray_to_line};
use super::random::Random;
use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::walls::wall::{Direction, Wall, WallPolicy};
use crate::{
    Config, DriveModel, Linearisation, Motion, Mount, Outcome, RangeInput, RangeModel, RangeSensor, Rig, Sample, Slam,
};

type Small = Slam<2, 4, 16, { storage(24) }>;

/// x, y, theta, alpha, two scales, the track, two gains, rho, theta_i.
const STATES: usize = 11;
const GAIN: usize = 8;
const RHO: usize = 9;
const THETA_I: usize = 10;

/// How the wall's direction is made of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Free,
    Snapped { theta_moves: bool },
    Grid(u8),
}

impl Kind {
    fn policy(self) -> WallPolicy {
        match self {
            Self::Free => WallPolicy::Free,
            Self::Snapped { theta_moves } => WallPolicy::Snapped { theta_moves },
            Self::Grid(_) => WallPolicy::Grid,
        }
    }

    fn direction(self) -> Direction {
        match self {
            Self::Free => Direction::Free(THETA_I as u16),
            Self::Snapped { .. } => Direction::Snapped(THETA_I as u16),
            Self::Grid(quarter) => Direction::Grid(quarter),
        }
    }

    /// Eq. 4 of Rousse & Qiu: beta is alpha minus the whole quarter turns that bring it nearest to theta_i.
    fn beta(self, alpha: f64, theta_i: f64) -> f64 {
        let quarter = core::f64::consts::FRAC_PI_2;
        match self {
            Self::Free => theta_i,
            Self::Snapped { .. } => alpha - ((alpha - theta_i) / quarter + 0.5).floor() * quarter,
            Self::Grid(k) => alpha + f64::from(k) * quarter,
        }
    }
}

/// What the second sensor should report.
fn model(kind: Kind, mount: [f64; 3], s: &[f64; STATES]) -> f64 {
    let (origin, phi) = beam([s[X], s[Y], s[THETA]], mount);
    s[GAIN] * ray_to_line(origin, phi, s[RHO], kind.beta(s[ALPHA], s[THETA_I]))
}

fn slam(kind: Kind, mount: [f64; 3], state: &[f64; STATES], variances: &[f32; STATES]) -> Small {
    let [x_m, y_m, bearing_rad] = mount.map(|v| v as f32);
    let sensor = RangeSensor {
        mount: Mount { x_m, y_m, bearing_rad },
        min_m: 0.05,
        max_m: 6.0,
        max_incidence_rad: 1.25,
        gain_sigma: 0.01,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
    };
    let drive = DriveModel::Wheels {
        track_m: 0.2,
        track_sigma: 0.01,
        metres_per_tick: 1e-3,
        scale_sigma: 0.01,
        noise_m2_per_m: 1e-5,
    };
    let rig = Rig { drive, adc: None, sensors: [sensor, sensor].into_iter().collect() };
    let mut config = Config::default();
    config.walls.policy = kind.policy();
    config.measurement.linearisation = Linearisation::Latest;
    config.sensing.repeats = false;
    config.measurement.clutter = false;
    let mut slam = Small::with_config(rig, config).unwrap();
    slam.ekf = Ekf::EMPTY;
    for (mean, variance) in state.iter().zip(variances) {
        slam.ekf.augment(*mean as f32, &Jacobian::new(), *variance);
    }
    slam.map.has_grid = kind != Kind::Free;
    slam.map.add(Wall::at(RHO, kind.direction(), (-30.0, 30.0)), 50, 0.0);
    slam
}

/// A state and a mount whose beam meets the wall under less than 65 degrees, in the sensor's limits.
fn geometry(random: &mut Random, kind: Kind) -> ([f64; STATES], [f64; 3]) {
    loop {
        let mut r = |m: f64| f64::from(random.uniform(-m, m) as f32);
        let mount = [r(0.3), r(0.3), r(3.1)];
        let mut state = [r(3.0), r(3.0), r(2.9), r(0.7), 1.0, 1.0, 1.0, 1.0, 1.0 + r(0.04), r(5.0), r(2.9)]
            .map(|v| f64::from(v as f32));
        if let Kind::Snapped { .. } = kind {
            // As uncertain as walls are that were snapped: within 20 degrees of a grid direction.
            state[THETA_I] = f64::from((kind.beta(state[ALPHA], state[THETA_I]) + r(0.35)) as f32);
        }
        let (_, phi) = beam([state[X], state[Y], state[THETA]], mount);
        let range = model(kind, mount, &state);
        let cos = (kind.beta(state[ALPHA], state[THETA_I]) - phi).cos();
        if cos > 0.43 && range > 0.3 && range < 5.0 && state[THETA_I].abs() < 3.0 {
            return (state, mount);
        }
    }
}

/// The Jacobian that one step used, and the numerical one.
fn measured(random: &mut Random, kind: Kind) -> Option<([f64; STATES], [f64; STATES])> {
    let (state, mount) = geometry(random, kind);
    // So that the range is known well enough for one reading to tell the wall.
    let variances = [5e-4; STATES].map(|v: f32| v * random.uniform(0.5, 2.0) as f32);
    let mut slam = slam(kind, mount, &state, &variances);
    let expected = model(kind, mount, &state);
    let reading = RangeInput::Metres((expected + 0.05) as f32);
    let sample =
        Sample { time_us: 1, motion: Motion::Ticks(Default::default()), ranges: [RangeInput::Missing, reading] };
    let report = slam.step(&sample);
    let Outcome::Updated { innovation_m, variance_m2, .. } = report.readings[1].outcome else {
        panic!("{kind:?}: {:?}", report.readings[1].outcome)
    };
    assert!((f64::from(innovation_m) - 0.05).abs() < 2e-5, "{kind:?}: predicted {}", 0.05 - innovation_m);
    // The update may have been followed by a founding or a removal; those are not what is looked at here.
    if slam.ekf.len() != STATES {
        return None;
    }
    let mut used = [0.0; STATES];
    let mut numerical = [0.0; STATES];
    let mut s = 0.0;
    for i in 0..STATES {
        let moved = f64::from(slam.ekf.mean(i)) - state[i];
        // A heading that passed half a turn was wrapped.
        let moved = if i == THETA { moved.sin().atan2(moved.cos()) } else { moved };
        used[i] = moved * f64::from(variance_m2) / (f64::from(innovation_m) * f64::from(variances[i]));
        numerical[i] = derivative(|v| model(kind, mount, v), &state, i);
        s += numerical[i] * numerical[i] * f64::from(variances[i]);
    }
    if kind != (Kind::Snapped { theta_moves: true }) {
        // The rest is the reading's own noise: 1 cm of the sensor, and what the estimator adds for the surface.
        let rest = f64::from(variance_m2) - s;
        assert!((0.99e-4..1e-3).contains(&rest), "{kind:?}: innovation variance {variance_m2}, {s} from the states");
    }
    Some((used, numerical))
}

/// A moved mean of some metres is rounded to 2e-7; it moved by P J / S 0.05, about 2e-5 J / S.
fn assert_close(used: f64, numerical: f64, used_scale: f64, what: &str) {
    let tolerance = 2e-4 * (1.0 + numerical.abs() + used_scale * used_scale);
    assert!((used - numerical).abs() < tolerance, "{what}: {used}, not {numerical}");
}

#[test]
fn every_kind_of_wall_has_the_derivatives_of_its_model() {
    let mut random = Random::new(1);
    let kinds: Vec<Kind> = (0..4).map(Kind::Grid).chain([Kind::Free, Kind::Snapped { theta_moves: false }]).collect();
    for kind in kinds {
        let mut compared = 0;
        for _ in 0..200 {
            let Some((used, numerical)) = measured(&mut random, kind) else { continue };
            compared += 1;
            let largest = numerical.iter().fold(0.0f64, |a, b| a.max(b.abs()));
            for i in 0..STATES {
                assert_close(used[i], numerical[i], largest, &std::format!("{kind:?}, state {i}"));
            }
        }
        assert!(compared > 150, "{kind:?}");
    }
}

/// Eq. 5 with beta(alpha) in h: the predicted range does not change with theta_i at all.
#[test]
fn with_beta_of_alpha_the_derivative_by_theta_i_is_zero() {
    let mut random = Random::new(2);
    let kind = Kind::Snapped { theta_moves: false };
    for _ in 0..200 {
        let (used, numerical) = measured(&mut random, kind).unwrap();
        assert_eq!(numerical[THETA_I], 0.0);
        assert_eq!(used[THETA_I], 0.0);
        assert!(numerical[ALPHA].abs() > 1e-3 || used[ALPHA].abs() < 2e-3);
    }
}

/// Eq. 5 as it is printed: theta_i takes the derivative of alpha, which is that of beta in h.
#[test]
fn as_printed_theta_i_moves_as_alpha_does() {
    let mut random = Random::new(3);
    let kind = Kind::Snapped { theta_moves: true };
    for _ in 0..200 {
        let (used, numerical) = measured(&mut random, kind).unwrap();
        let largest = numerical.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        assert_close(used[ALPHA], numerical[ALPHA], largest, "alpha");
        assert_close(used[THETA_I], numerical[ALPHA], largest, "theta_i");
        assert_close(used[RHO], numerical[RHO], largest, "rho");
    }
}
