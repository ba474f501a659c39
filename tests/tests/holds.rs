//! A robot whose wheels turn while something holds it stays where it is.

use tests::mishaps::{Found, Mishap, found};

/// Drives in each home: a share of 0.6 is then known to 0.05.
const DRIVES: u64 = 100;

#[test]
fn most_holds_are_found_and_none_where_there_is_none() {
    for name in ["flat", "l-shape"] {
        // Without it the wheels carry the pose most of a metre away.
        let all: Vec<Found> = (1..=DRIVES).map(|seed| found(name, Mishap::Hold, seed)).collect();
        let stayed = all.iter().filter(|found| found.is_back() && found.holds > 0).count();
        assert!(stayed >= 50, "{name}: {stayed} of {DRIVES}");
        for seed in 1..=DRIVES {
            let Found { off_m, holds, .. } = found(name, Mishap::Nothing, seed);
            assert!(holds == 0, "{name}, seed {seed}: {holds} holds, {off_m} m");
        }
    }
}
