//! Hours in a home: as good, and as honest, as the first one. Days take a command (`tests/examples/long_drives.rs`).

use tests::long_drive::{Hour, drive};

/// 95 % of honest drives have a smaller NEES of a pose whose error stays as it is, as that of the start frame does:
/// chi-square with three degrees of freedom.
const NEES_AT_MOST: f64 = 7.81;

#[test]
fn four_hours_are_as_good_as_one() {
    let plan = hal_sim::plan_file::load("flat").expect("a built-in plan");
    let mut hours: Vec<Hour> = Vec::new();
    drive(&plan, 4.0, 1, |hour| hours.push(hour.clone()));
    println!("{hours:#?}");
    let [first, later @ ..] = &hours[..] else { panic!("no hour") };
    assert_eq!(later.len(), 3);
    for hour in &hours {
        assert_eq!(hour.flaw, None, "hour {}", hour.number);
        assert!(hour.nees < NEES_AT_MOST, "hour {}: NEES {}", hour.number, hour.nees);
        assert!(hour.rmse_m < 1.5 * first.rmse_m, "hour {}: {} m", hour.number, hour.rmse_m);
    }
    for hour in later {
        assert!(f64::from(hour.births) < hour.path_m, "hour {}: {} births", hour.number, hour.births);
    }
}
