//! How large the noise is, learned from the innovations.

use super::random::Random;
use crate::rig::DriveModel;
use crate::sensing::noise_level::{Expected, NoiseLevels};

/// Levels after innovations of which the state's part has the variance that is expected, and the reading's part, of so much
/// beforehand, another one.
fn after(readings: usize, share: f64, actual: f64) -> NoiseLevels {
    let mut random = Random::new(11);
    let mut levels = NoiseLevels::STATED;
    let (known_m2, stated_m2) = ((1.0 - share) * 1e-3, share * 1e-3);
    for _ in 0..readings {
        let sigma_m = (known_m2 + actual * stated_m2).sqrt();
        let noise_m2 = levels.readings.factor() * stated_m2 as f32;
        levels.note(
            &Expected {
                innovation_m: (sigma_m * random.gaussian()) as f32,
                variance_m2: known_m2 as f32 + noise_m2,
                noise_m2,
                heading_m2: 0.0,
            },
            1.0,
        );
    }
    levels
}

/// Poses that somebody logged.
const LOGGED: DriveModel = DriveModel::Odometry {
    scale_sigma: 0.0,
    veer_sigma: 0.0,
    noise_m2_per_m: 0.0,
    noise_rad2_per_m: 0.0,
    noise_rad2_per_rad: 0.0,
};

/// Two wheels that are counted.
const COUNTED: DriveModel =
    DriveModel::Wheels { track_m: 0.2, track_sigma: 0.0, metres_per_tick: 1e-3, scale_sigma: 0.0, noise_m2_per_m: 0.0 };

#[test]
fn the_level_of_readings_is_found() {
    for (actual, expected) in [(0.3, 0.3), (0.6, 0.6), (1.0, 1.0), (2.5, 1.0)] {
        let found = f64::from(after(3000, 0.9, actual).readings.factor());
        assert!((found / expected - 1.0).abs() < 0.3, "{found}, not {expected}, of {actual}");
        assert!(found <= 1.0, "{found}: what is larger than stated is other surfaces' doing");
    }
}

#[test]
fn a_few_readings_tell_little() {
    let found = after(3, 1.0, 0.1).readings.factor();
    assert!(found > 0.5, "{found} after three readings");
}

#[test]
fn motion_is_never_believed_to_be_worse_than_floors_are() {
    let stated = [[4e-4, 1e-4, 0.0], [1e-4, 4e-4, 0.0], [0.0, 0.0, 1e-3]];
    assert_eq!(NoiseLevels::STATED.of_motion(&stated, &LOGGED), stated);
    assert_eq!(after(500, 0.2, 40.0).of_motion(&stated, &LOGGED)[0][0], stated[0][0]);
    // Innovations that are smaller than the state alone explains are the motion's doing.
    let mut levels = NoiseLevels::STATED;
    for _ in 0..500 {
        let expected = Expected { innovation_m: 0.005, variance_m2: 1e-3, noise_m2: 1e-4, heading_m2: 5e-4 };
        levels.note(&expected, 1.0);
    }
    let believed = levels.of_motion(&stated, &LOGGED);
    assert!(believed[0][0] < 0.3 * stated[0][0] && believed[2][2] < 0.9 * stated[2][2], "{believed:?}");
    let counted = levels.of_motion(&stated, &COUNTED);
    assert_eq!((counted[0][0], counted[2][2]), (believed[0][0], stated[2][2]), "the heading of wheels is as stated");
    let correlation = |noise: [[f32; 3]; 3]| noise[0][1] / noise[0][0];
    assert!((correlation(believed) - correlation(stated)).abs() < 1e-6, "it stays a covariance");
}

#[test]
fn what_is_not_a_number_teaches_nothing() {
    let mut levels = NoiseLevels::STATED;
    for (innovation_m, variance_m2) in [(f32::NAN, 1e-3), (0.1, 0.0), (f32::INFINITY, 1e-3)] {
        levels.note(&Expected { innovation_m, variance_m2, noise_m2: 1e-4, heading_m2: 0.0 }, 1.0);
    }
    assert_eq!(levels.readings.factor(), 1.0);
}
