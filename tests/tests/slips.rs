//! Wheels slip by a centimetre once a metre, of which the rig states nothing: the robot notices that it knows its heading less well.

use hal_sim::{DriveOptions, SimOptions};
use lab::evaluate::statistics::median;
use slam_core::{Config, Slip};
use tests::simulated::{disturbed_rows, estimated};

/// Medians of mean NEES and error (metres) over drives in which wheels slip so often a metre, where that is learned and where it is taken
/// as stated.
fn medians(slips_per_m: f64) -> [[f64; 2]; 2] {
    let scores: Vec<[[f64; 2]; 2]> = (21..=36)
        .map(|seed| {
            let drive = DriveOptions { slips_per_m, ..DriveOptions::default() };
            let rows = disturbed_rows(SimOptions { drive, ..SimOptions::default() }, "flat", 5.0, seed);
            [Slip::Learned, Slip::Stated].map(|slip| {
                let mut config = Config::default();
                config.motion.slip = slip;
                let score = estimated(&rows, config).estimate.expect("a true path");
                [score.nees.expect("covariances"), score.ate_m]
            })
        })
        .collect();
    let of = |slip: usize, i: usize| median(&scores.iter().map(|score| score[slip][i]).collect::<Vec<_>>());
    [0, 1].map(|slip| [0, 1].map(|i| of(slip, i).expect("drives")))
}

#[test]
fn slips_that_the_rig_does_not_state_are_noticed() {
    let [[nees, ate_m], [stated_nees, stated_m]] = medians(1.0);
    assert!(nees < 8.0 && nees < 0.7 * stated_nees, "{nees}, as stated {stated_nees}");
    assert!(ate_m < 0.03 && ate_m < stated_m, "{ate_m} m, as stated {stated_m} m");
}

#[test]
fn where_wheels_slip_as_stated_nothing_is_lost() {
    let [[nees, ate_m], [stated_nees, stated_m]] = medians(0.0);
    assert!((1.5..5.0).contains(&nees) && nees < 1.2 * stated_nees, "{nees}, as stated {stated_nees}");
    assert!(ate_m < 1.15 * stated_m, "{ate_m} m, as stated {stated_m} m");
}
