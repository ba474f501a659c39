//! Drives of a day, six of them, one of three days, hour by hour, and drives in large empty rooms:
//! `cargo run --release --package tests --example long_drives -- RESULT.md`, or `-- PLAN HOURS SEED` for one drive.

use std::{env, fs};

use lab::evaluate::statistics::median;
use tests::long_drive::{Hour, drive, square};

/// The homes whose covariance was lost first, two drives each.
const PLANS: [&str; 3] = ["flat", "clutter", "diagonal"];
const SEEDS: [u64; 2] = [1, 2];
const DAY_H: usize = 24;

/// The drive of three days: plan and seed.
const LONGEST: (&str, u64) = ("flat", 1);

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match &arguments[..] {
        [plan, hours, seed] => drop(driven(plan, hours.parse().expect("hours"), seed.parse().expect("a seed"))),
        [file] => fs::write(file, page()).expect("the result's file can be written"),
        _ => panic!("either RESULT.md or PLAN HOURS SEED"),
    }
}

/// Sides of the empty rooms, metres: from one where a wall is nearly always in reach to a hall; drives in each, and their length.
const SIDES_M: [f64; 8] = [6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 30.0, 60.0];
const ROOM_SEEDS: u64 = 10;
const ROOM_H: f64 = 0.2;

/// Every hour of a drive, printed as it ends.
fn driven(plan: &str, hours: f64, seed: u64) -> Vec<Hour> {
    let home = hal_sim::plan_file::load(plan).expect("a plan");
    let mut all = Vec::new();
    println!("plan,seed,hour,rmse_m,nees,lost_s,restarts,path_m,births,holds,jolts,walls,least_pivot,flaw");
    drive(&home, hours, seed, |hour| {
        let Hour { number, rmse_m, nees, lost_s, restarts, path_m, births, holds, jolts, walls, least_pivot, flaw } =
            hour;
        let flaw = flaw.as_deref().unwrap_or("");
        println!(
            "{plan},{seed},{number},{rmse_m:.4},{nees:.2},{lost_s:.0},{restarts},{path_m:.1},{births},{holds},{jolts},{walls},{least_pivot:.2e},{flaw}"
        );
        all.push(hour.clone());
    });
    all
}

/// One row of the table of drives.
fn row(name: &str, hours: &[Hour]) -> String {
    let (first, later) = hours.split_first().expect("an hour at least");
    let worst = |value: fn(&Hour) -> f64| hours.iter().map(value).fold(0.0, f64::max);
    let last = hours.last().unwrap_or(first);
    let (births, path_m) = later.iter().fold((0, 0.0), |(n, m), hour| (n + hour.births, m + hour.path_m));
    let (holds, jolts) = hours.iter().fold((0, 0), |(n, m), hour| (n + hour.holds, m + hour.jolts));
    let (restarts, lost_s) = hours.iter().fold((0, 0.0), |(n, s), hour| (n + hour.restarts, s + hour.lost_s));
    let least = hours.iter().map(|hour| hour.least_pivot).fold(f64::INFINITY, f64::min);
    let flaws = hours.iter().filter(|hour| hour.flaw.is_some()).count();
    format!(
        "| {name} | {:.1} / {:.1} / {:.1} | {:.1} / {:.1} / {:.1} | {:.4} | {holds} / {jolts} | {restarts} / {lost_s:.0} | {least:.1e} | {flaws} |\n",
        100.0 * first.rmse_m,
        100.0 * last.rmse_m,
        100.0 * worst(|hour| hour.rmse_m),
        first.nees,
        last.nees,
        worst(|hour| hour.nees),
        f64::from(births) / path_m.max(1.0),
    )
}

fn page() -> String {
    let mut text = String::from(
        "# Long drives\n\n\
         The built-in robot drives by its own estimate for a day through each of three homes, twice, and through one for three days. RMSE\n\
         is that of the position in the start frame. NEES is that of the pose, 3 for an honest filter. A map that readings contradict is kept, and the\n\
         robot is lost until it has found itself in it again: such time is in neither. Nobody holds or kicks the robot; in clutter it\n\
         runs into chairs' legs. The covariance is looked at ten times a minute: the least pivot is that of the Cholesky factor of its\n\
         correlations with 1e-3 on the diagonal.\n\n\
         Made by `cargo run --release -p tests --example long_drives -- docs/results/long-drives.md`.\n\n\
         | drive | RMSE, cm: first hour / last / worst | NEES: first hour / last / worst | births a metre after the first hour | holds / jolts | maps given up / lost, s | least pivot | hours with a flaw |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let mut days = Vec::new();
    for plan in PLANS {
        for seed in SEEDS {
            let hours = driven(plan, DAY_H as f64, seed);
            text += &row(&format!("{plan}, seed {seed}, 24 h"), &hours);
            days.push(hours);
        }
    }
    let (plan, seed) = LONGEST;
    text += &row(&format!("{plan}, seed {seed}, 72 h"), &driven(plan, 72.0, seed));
    text +=
        "\nMeans over the six drives of a day:\n\n| hour | NEES | RMSE over that of the first hour |\n|---|---|---|\n";
    for hour in 0..DAY_H {
        let mean = |value: &dyn Fn(&[Hour]) -> f64| days.iter().map(|day| value(day)).sum::<f64>() / days.len() as f64;
        let (nees, ratio) = (mean(&|day| day[hour].nees), mean(&|day| day[hour].rmse_m / day[0].rmse_m));
        text += &format!("| {} | {nees:.2} | {ratio:.2} |\n", hour + 1);
    }
    text + &rooms()
}

/// The table of the large empty rooms.
fn rooms() -> String {
    let mut text = format!(
        "\n## Large empty rooms\n\nSquares in which the robot begins in the middle, metres from any wall; {ROOM_SEEDS} drives of {:.0} minutes each. A drive's\n\
         error is mostly that of one way to its first wall, so that a single drive's NEES says little.\n\n\
         | side, m | NEES: mean / worst drive | RMSE, cm: median / worst | drives with a flaw |\n|---|---|---|---|\n",
        60.0 * ROOM_H
    );
    for side_m in SIDES_M {
        let mut all = Vec::new();
        (1..=ROOM_SEEDS).for_each(|seed| drive(&square(side_m), ROOM_H, seed, |hour| all.push(hour.clone())));
        let worst = |value: fn(&Hour) -> f64| all.iter().map(value).fold(0.0, f64::max);
        let mean = all.iter().map(|drive| drive.nees).sum::<f64>() / all.len() as f64;
        let errors: Vec<f64> = all.iter().map(|drive| drive.rmse_m).collect();
        text += &format!(
            "| {side_m:.0} | {mean:.1} / {:.1} | {:.1} / {:.1} | {} |\n",
            worst(|drive| drive.nees),
            100.0 * median(&errors).unwrap_or(f64::NAN),
            100.0 * worst(|drive| drive.rmse_m),
            all.iter().filter(|drive| drive.flaw.is_some()).count()
        );
    }
    text
}
