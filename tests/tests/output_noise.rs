//! Analogue sensors that are noisier than the rig states: the robot finds out before it draws its first wall, which all that comes later stands on.

use hal_sim::{SharpOptions, SimOptions};
use lab::evaluate::statistics::mean;
use slam_core::Config;
use tests::simulated::{disturbed_rows, estimated};

#[test]
fn a_noise_that_the_rig_does_not_state_is_known_before_the_first_wall() {
    let sharp = SharpOptions { noise_v: Some(0.045), ..SharpOptions::default() };
    let nees: Vec<f64> = (1..=60)
        .map(|seed| {
            let rows = disturbed_rows(SimOptions { sharp, ..SimOptions::default() }, "flat", 1.0, seed);
            estimated(&rows, Config::default()).estimate.and_then(|score| score.nees).expect("a true path")
        })
        .collect();
    // 3.1; with the first readings taken for as good as the rig says 4.0.
    let mean_nees = mean(&nees).expect("drives");
    assert!(mean_nees < 3.6, "{mean_nees}");
}
