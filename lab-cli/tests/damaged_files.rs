//! Damaged files end in an error or in a good reading, never in a panic, and never in an endless loop.

use std::path::Path;

use crate::common::{ODOMETRY_RIG, Place, SHARP_RIG, WHEELED_RIG, wheeled_log};
use lab::input::rig_file::Robot;

/// A generator of its own (xorshift64), so that every run tries the same damage.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }

    /// The text with a few bytes changed, dropped or doubled, mostly by such that mean something.
    fn damage(&mut self, text: &str) -> Vec<u8> {
        const MEANT: &[u8] = b"0123456789-+.eE,\n\r\t \"'[]{}=#nanif_x\0\xff\xc3";
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(bytes.len());
            match self.below(4) {
                0 if bytes.len() > 1 => drop(bytes.remove(at)),
                1 => bytes.insert(at, MEANT[self.below(MEANT.len())]),
                2 => bytes[at] = MEANT[self.below(MEANT.len())],
                _ => bytes.truncate(at.max(1)),
            }
        }
        bytes
    }
}

#[test]
fn damaged_rigs() {
    let mut random = Random(1);
    let (mut good, mut bad) = (0, 0);
    for rig in [WHEELED_RIG, SHARP_RIG, ODOMETRY_RIG] {
        for _ in 0..3000 {
            let text = String::from_utf8_lossy(&random.damage(rig)).into_owned();
            match Robot::parse(Path::new("rig.toml"), &text) {
                Ok(robot) => {
                    let session = lab::run::Session::new(&robot, slam_core::Config::default(), "damaged");
                    assert!(session.is_ok(), "what is read must be usable:\n{text}");
                    good += 1;
                }
                Err(error) => {
                    assert!(error.to_string().starts_with("rig.toml"), "{error}");
                    bad += 1;
                }
            }
        }
    }
    assert!(good > 200 && bad > 200, "{good} good, {bad} bad: the damage shows nothing");
}

fn damaged_logs(rig: &str, log: &str, seed: u64) {
    let place = Place::new();
    let mut random = Random(seed);
    let (mut rows, mut errors) = (0, 0);
    for _ in 0..600 {
        let path = place.put("log", random.damage(log));
        let mut robot = Robot::parse(Path::new("rig.toml"), rig).expect("good rig");
        let reader = match lab::input::log::open(&path, &mut robot) {
            Ok(reader) => reader,
            Err(_) => {
                errors += 1;
                continue;
            }
        };
        let mut session = lab::run::Session::new(&robot, slam_core::Config::default(), "damaged").expect("good rig");
        for row in reader {
            match row {
                Ok(row) => {
                    let step = session.push(&row);
                    assert!(step.pose.x_m.is_finite() && step.covariance.iter().flatten().all(|p| p.is_finite()));
                    rows += 1;
                }
                Err(_) => errors += 1,
            }
        }
    }
    assert!(rows > 1000 && errors > 100, "{rows} rows, {errors} errors: the damage shows nothing");
}

#[test]
fn damaged_csv_logs() {
    damaged_logs(WHEELED_RIG, &wheeled_log(20), 2);
}

#[test]
fn damaged_carmen_logs() {
    let scan = |i: usize| {
        let t = 0.1 * i as f64;
        format!("FLASER 4 1.0 0.9 0.8 0.7 0 0 0 {t} {} 0.1 {t} robot {t}\nODOM 0 0 0 0 0 0 {t} robot {t}\n", 0.5 * t)
    };
    let log: String = (0..20).map(scan).collect();
    damaged_logs(&ODOMETRY_RIG.replace("bearing_deg = 90.0", "bearing_deg = 45.0"), &log, 3);
}
