//! How often the estimator finds out that it was held or kicked, over many drives:
//! `cargo run --release --package tests --example mishaps -- RESULT.md [DRIVES]`.

use std::{env, fs};

use lab::evaluate::statistics::median;
use tests::mishaps::{Found, Mishap, found};

/// Homes, and drives in each unless the command says otherwise.
const PLANS: [&str; 4] = ["flat", "l-shape", "diagonal", "clutter"];
const DRIVES: u64 = 100;

fn main() {
    let mut arguments = env::args().skip(1);
    let file = arguments.next().expect("RESULT.md [DRIVES]");
    let drives = arguments.next().map_or(DRIVES, |count| count.parse().expect("a number of drives"));
    fs::write(file, page(drives)).expect("the result's file can be written");
}

fn page(drives: u64) -> String {
    let mut text = format!(
        "# Holds and kicks\n\n\
         The built-in robot with eight sensors is held for 4 s while its wheels turn, or kicked by 10 cm and 15 degrees, two and a half\n\
         minutes after its start, and drives on by its own estimate; {drives} drives a row. Back is one that is within 10 cm and 0.1 rad\n\
         of the truth in the start frame ten seconds after the hold, or twenty after the kick; false is a hold or a jolt where there was\n\
         none; NEES is the normalised error squared of the pose then, 3 where it is known as well as the robot says.\n\n\
         Made by `cargo run --release -p tests --example mishaps -- docs/results/mishaps.md`.\n\n\
         | home | mishap | back | found | false: holds / jolts | off, cm: median / worst | NEES: median / over 30 |\n|---|---|---|---|---|---|---|\n"
    );
    for name in PLANS {
        for mishap in [Mishap::Nothing, Mishap::Hold, Mishap::Kick] {
            let all: Vec<Found> = (1..=drives).map(|seed| found(name, mishap, seed)).collect();
            text += &row(name, mishap, &all);
        }
    }
    text
}

fn row(name: &str, mishap: Mishap, all: &[Found]) -> String {
    let count = |is: &dyn Fn(&Found) -> bool| all.iter().filter(|found| is(found)).count();
    let false_holds = count(&|found| found.holds > u32::from(mishap == Mishap::Hold));
    let false_jolts = count(&|found| found.jolts > u32::from(mishap == Mishap::Kick));
    let told = match mishap {
        Mishap::Nothing => String::from("-"),
        Mishap::Hold => count(&|found| found.holds > 0).to_string(),
        Mishap::Kick => count(&|found| found.jolts > 0).to_string(),
    };
    let mut off_m: Vec<f64> = all.iter().map(|found| found.off_m).collect();
    off_m.sort_by(f64::total_cmp);
    let nees: Vec<f64> = all.iter().map(|found| found.nees).collect();
    let row = format!(
        "| {name} | {mishap} | {} of {} | {told} | {false_holds} / {false_jolts} | {:.1} / {:.0} | {:.1} / {} |\n",
        count(&|found| found.is_within(0.1, 0.1)),
        all.len(),
        100.0 * off_m[off_m.len() / 2],
        100.0 * off_m[off_m.len() - 1],
        median(&nees).expect("there are drives"),
        count(&Found::is_too_sure),
    );
    print!("{row}");
    row
}
