//! Drives of a day, hour by hour, one of three days, and drives in large empty rooms:
//! `cargo run --release --package tests --example long_drives -- RESULT.md`, or `-- PLAN HOURS SEED [ROBOT [DEGREES]]` for one drive.

use std::{env, fs};

use hal_sim::Plan;
use lab::evaluate::statistics::median;
use monte_carlo::key::Key;
use monte_carlo::plan::changed;
use monte_carlo::setting::Setting;
use tests::long_drive::{Hour, drive, square};

/// The robot of most drives, and one whose walls keep directions of their own.
const ROBOT: &str = "sharp";
const OTHER_ROBOT: &str = "time-of-flight";

/// The homes whose covariance was lost first, two drives each.
const PLANS: [&str; 3] = ["flat", "clutter", "diagonal"];
const SEEDS: [u64; 2] = [1, 2];
const DAY_H: f64 = 24.0;

/// The drive of three days: plan and seed.
const LONGEST: (&str, u64) = ("flat", 1);

/// Homes for other assumptions, and drives in each.
const OTHER_PLANS: [&str; 2] = ["flat", "clutter"];
const OTHER_SEEDS: [u64; 3] = [1, 2, 3];

/// By how much each piece of furniture may stand askew, degrees.
const ASKEW_DEG: f64 = 10.0;

/// One drive.
struct Drive<'a> {
    plan: &'a str,
    robot: &'a str,
    /// Largest angle by which furniture is turned, degrees.
    furniture_deg: f64,
    hours: f64,
    seed: u64,
}

impl<'a> Drive<'a> {
    /// Of the usual robot in a home as it is drawn.
    fn usual(plan: &'a str, hours: f64, seed: u64) -> Self {
        Self { plan, robot: ROBOT, furniture_deg: 0.0, hours, seed }
    }

    fn home(&self) -> Plan {
        let plan = hal_sim::plan_file::load(self.plan).expect("a plan");
        let setting = Setting { values: [(Key::Furniture, self.furniture_deg)].into(), ..Setting::default() };
        changed(&plan, self.plan, &[], &setting, self.seed)
    }

    /// Its hours, each printed as it ends.
    fn hours(&self) -> Vec<Hour> {
        let (robot, _) = lab::input::robot(self.robot.as_ref()).expect("a built-in robot, or a rig file");
        let mut all = Vec::new();
        println!(
            "plan,seed,hour,rmse_m,aligned_m,nees,lost_s,restarts,path_m,births,holds,jolts,walls,least_pivot,flaw"
        );
        drive(&robot, &self.home(), self.hours, self.seed, |hour| {
            let Hour {
                number,
                rmse_m,
                aligned_m,
                nees,
                lost_s,
                restarts,
                path_m,
                births,
                holds,
                jolts,
                walls,
                least_pivot,
                flaw,
            } = hour;
            let (plan, seed, flaw) = (self.plan, self.seed, flaw.as_deref().unwrap_or(""));
            println!(
                "{plan},{seed},{number},{rmse_m:.4},{aligned_m:.4},{nees:.2},{lost_s:.0},{restarts},{path_m:.1},{births},{holds},{jolts},{walls},{least_pivot:.2e},{flaw}"
            );
            all.push(hour.clone());
        });
        all
    }
}

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [file] => fs::write(file, page()).expect("the result's file can be written"),
        [plan, hours, seed, ref other @ ..] if other.len() <= 2 => {
            let (hours, seed) = (hours.parse().expect("hours"), seed.parse().expect("a seed"));
            let furniture_deg = other.get(1).map_or(0.0, |deg| deg.parse().expect("degrees"));
            let robot = other.first().copied().unwrap_or(ROBOT);
            drop(Drive { robot, furniture_deg, ..Drive::usual(plan, hours, seed) }.hours());
        }
        _ => panic!("either RESULT.md or PLAN HOURS SEED [ROBOT [DEGREES]]"),
    }
}

/// Sides of the empty rooms, metres: from one where a wall is nearly always in reach to a hall; drives in each, and their length.
const SIDES_M: [f64; 8] = [6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 30.0, 60.0];
const ROOM_SEEDS: u64 = 10;
const ROOM_H: f64 = 0.2;

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
        "| {name} | {:.1} / {:.1} / {:.1} | {:.1} / {:.1} | {:.1} / {:.1} / {:.1} | {:.4} | {holds} / {jolts} | {restarts} / {lost_s:.0} | {least:.1e} | {flaws} |\n",
        100.0 * first.rmse_m,
        100.0 * last.rmse_m,
        100.0 * worst(|hour| hour.rmse_m),
        100.0 * first.aligned_m,
        100.0 * last.aligned_m,
        first.nees,
        last.nees,
        worst(|hour| hour.nees),
        f64::from(births) / path_m.max(1.0),
    )
}

/// Head of a table of drives.
const HEAD: &str = "| drive | RMSE, cm: first hour / last / worst | aligned, cm: first / last | NEES: first hour / last / worst | births a metre after the first hour | holds / jolts | maps given up / lost, s | least pivot | hours with a flaw |\n\
                    |---|---|---|---|---|---|---|---|---|\n";

fn page() -> String {
    let mut text = String::from(
        "# Long drives\n\n\
         The built-in robot drives by its own estimate for a day through each of three homes, twice, and through one for three days. RMSE\n\
         is that of the position in the start frame; aligned, it is that of the hour's path where that is laid over the true one: what is left is the\n\
         map's own error, without what the robot does not know of how it began. NEES is that of the pose in the start frame, 3 for an honest filter. A map that readings contradict is kept, and the\n\
         robot is lost until it has found itself in it again: such time is in neither. Nobody holds or kicks the robot; in clutter it\n\
         runs into chairs' legs. The covariance is looked at ten times a minute: the least pivot is that of the Cholesky factor of its\n\
         correlations with 1e-3 on the diagonal.\n\n\
         Made by `cargo run --release -p tests --example long_drives -- docs/results/long-drives.md`.\n\n",
    ) + HEAD;
    let mut days = Vec::new();
    for plan in PLANS {
        for seed in SEEDS {
            let hours = Drive::usual(plan, DAY_H, seed).hours();
            text += &row(&format!("{plan}, seed {seed}, 24 h"), &hours);
            days.push(hours);
        }
    }
    let (plan, seed) = LONGEST;
    text += &row(&format!("{plan}, seed {seed}, 72 h"), &Drive::usual(plan, 72.0, seed).hours());
    text +=
        "\nMeans over the six drives of a day:\n\n| hour | NEES | RMSE over that of the first hour |\n|---|---|---|\n";
    for hour in 0..DAY_H as usize {
        let mean = |value: &dyn Fn(&[Hour]) -> f64| days.iter().map(|day| value(day)).sum::<f64>() / days.len() as f64;
        let (nees, ratio) = (mean(&|day| day[hour].nees), mean(&|day| day[hour].rmse_m / day[0].rmse_m));
        text += &format!("| {} | {nees:.2} | {ratio:.2} |\n", hour + 1);
    }
    text + &others() + &rooms()
}

/// The tables of another robot, and of homes that are not as the estimator takes them to be.
fn others() -> String {
    let mut text = format!(
        "\n## Another robot, other homes\n\nFirst the built-in robot with time-of-flight sensors, whose walls keep directions of their own; then the built-in robot with analogue sensors in homes whose furniture is\n\
         turned, each piece about its middle by up to {ASKEW_DEG:.0} degrees. The filter alone, no look back. One drive is\n\
         `cargo run --release -p tests --example long_drives -- clutter 24 1 {OTHER_ROBOT}`, or `... -- clutter 24 1 {ROBOT} {ASKEW_DEG:.0}`.\n\n"
    ) + HEAD;
    for (robot, furniture_deg, what) in [(OTHER_ROBOT, 0.0, "time of flight"), (ROBOT, ASKEW_DEG, "furniture askew")] {
        for plan in OTHER_PLANS {
            for seed in OTHER_SEEDS {
                let hours = Drive { robot, furniture_deg, ..Drive::usual(plan, DAY_H, seed) }.hours();
                text += &row(&format!("{what}, {plan}, seed {seed}, 24 h"), &hours);
            }
        }
    }
    text
}

/// The table of the large empty rooms.
fn rooms() -> String {
    let mut text = format!(
        "\n## Large empty rooms\n\nSquares in which the robot begins in the middle, metres from any wall; {ROOM_SEEDS} drives of {:.0} minutes each. A drive's\n\
         error is mostly that of one way to its first wall, so that a single drive's NEES says little.\n\n\
         | side, m | NEES: mean / worst drive | RMSE, cm: median / worst | drives with a flaw |\n|---|---|---|---|\n",
        60.0 * ROOM_H
    );
    let (robot, _) = lab::input::robot(ROBOT.as_ref()).expect("a built-in robot");
    for side_m in SIDES_M {
        let mut all = Vec::new();
        (1..=ROOM_SEEDS).for_each(|seed| drive(&robot, &square(side_m), ROOM_H, seed, |hour| all.push(hour.clone())));
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
