//! As many random steps as asked for: `cargo run --release --package tests --example hostile_steps -- STEPS [FIRST_SEED] [RESULT.md]`.
//!
//! Random rigs, settings, rooms and drives with odd times, motions and readings among them (`tests::fuzzing`). After every step
//! all means and variances must be finite and no variance negative, every 50th the whole covariance must be one. Ends with
//! the first seed that does harm and its case in a file, which `fuzz/corpus` then gets; or writes the result.

use std::{env, fs, panic, process};

use tests::fuzzing::{TARGETS, Target, random_case};

/// The targets that step the estimator.
const STEPPING: [&str; 2] = ["samples", "rigs"];

fn main() {
    let mut arguments = env::args().skip(1);
    let mut number = |usual: u64| {
        arguments.next().map_or(usual, |text| text.parse().expect("whole numbers: STEPS [FIRST_SEED] [RESULT.md]"))
    };
    let (wanted, first) = (number(1_000_000), number(0));
    let stepping = || TARGETS.iter().filter(|target| STEPPING.contains(&target.0));
    let (mut seed, mut steps) = (first, [0; STEPPING.len()]);
    while steps.iter().sum::<u64>() < wanted {
        for (target, steps) in stepping().zip(&mut steps) {
            *steps += tried(target, seed);
        }
        seed += 1;
        if seed.is_multiple_of(1000) {
            println!("seed {seed}: {} steps", steps.iter().sum::<u64>());
        }
    }
    let [of_samples, of_rigs] = steps;
    println!(
        "seeds {first} to {}: {of_samples} steps of good rigs, {of_rigs} of rigs of any numbers, no harm",
        seed - 1
    );
    if let Some(file) = arguments.next() {
        fs::write(&file, page(wanted, first, seed - 1, steps)).expect("the result's file can be written");
    }
}

/// Steps through a seed's case; where that does harm, keeps the case and ends.
fn tried((name, target): &Target, seed: u64) -> u64 {
    let case = random_case(seed);
    panic::catch_unwind(|| target(&case)).unwrap_or_else(|_| {
        let file = format!("{name}-{seed}");
        fs::write(&file, &case).expect("the case's file can be written");
        eprintln!("{name}, seed {seed} does harm; the case is in the file {file}");
        process::exit(1)
    })
}

/// The result, for docs/results.
fn page(wanted: u64, first: u64, last: u64, [of_samples, of_rigs]: [u64; 2]) -> String {
    format!(
        "# Hostile steps\n\n\
         Random rigs, settings, rooms and drives, with odd times, motions and readings among them. After every step all means and\n\
         variances were finite and no variance was negative; every 50th step the whole covariance was one (Cholesky factor of its\n\
         correlations with 1e-3 on the diagonal). [How](../../fuzz/README.md).\n\n\
         Made by `cargo run --release -p tests --example hostile_steps -- {wanted} {first} docs/results/hostile-steps.md`.\n\n\
         | seeds | what | steps | that did harm |\n|---|---|---|---|\n\
         | {first} to {last} | good rigs, odd samples | {of_samples} | 0 |\n\
         | {first} to {last} | rigs of any numbers that the checks let pass | {of_rigs} | 0 |\n"
    )
}
