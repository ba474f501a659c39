//! What must hold for the built-in robot in the four-room flat: 1 % gain and 0.5 % wheel errors, drawn anew by each seed.

use lab::evaluate::statistics::{chi_square_mean_band, median};
use lab::recording::Recording;
use tests::simulated::drive;

#[test]
fn five_seeds_of_the_flat() {
    let runs: Vec<Recording> = (1..=5).map(|seed| drive("flat", 10.0, seed)).collect();
    let scores = || runs.iter().map(|run| run.figures.estimate.expect("there is a truth"));
    for (run, score) in runs.iter().zip(scores()) {
        println!("{score:?} {:?}", run.figures.map);
        assert!(run.figures.path_m >= 60.0, "{} m", run.figures.path_m);
        let map = run.figures.map.expect("there is a plan");
        assert_eq!(map.missed, 0, "{map:?}");
        assert!(map.invented <= 1, "{map:?}");
    }
    let nees: f64 = scores().map(|score| score.nees.expect("there is a covariance")).sum();
    let (nees, [_, most]) = (nees / runs.len() as f64, chi_square_mean_band(3, runs.len()));
    assert!(nees <= most, "mean NEES {nees}, over {most}");
    let middle = |values: Vec<f64>| median(&values).expect("there are runs");
    let ate_m = middle(scores().map(|score| score.ate_m).collect());
    let heading_deg = middle(scores().map(|score| score.heading_deg).collect());
    assert!(ate_m <= 0.03, "median aligned RMSE {ate_m} m");
    assert!(heading_deg <= 1.5, "median heading RMSE {heading_deg} degrees");
    let odometry = runs.iter().map(|run| run.figures.odometry.expect("there is a truth").ate_m);
    assert!(middle(odometry.collect()) > 10.0 * ate_m, "dead reckoning must be the worse one by far");
}
