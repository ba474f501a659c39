//! As many random steps as asked for: `cargo run --release --package tests --example hostile_steps -- STEPS [FIRST_SEED]`.
//!
//! Random rigs, settings, rooms and drives with odd times, motions and readings among them (`tests::fuzzing`). After every step
//! all means and variances must be finite and no variance negative, every 50th the whole covariance must be one. Ends with
//! the first seed that does harm, which `fuzz/corpus/samples` then gets.

use std::env;

use tests::fuzzing::{random_case, rigs, samples};

fn main() {
    let mut numbers = env::args().skip(1).map(|text| text.parse::<u64>().expect("a whole number: STEPS [FIRST_SEED]"));
    let (wanted, first) = (numbers.next().unwrap_or(1_000_000), numbers.next().unwrap_or(0));
    let (mut seed, mut of_samples, mut of_rigs) = (first, 0, 0);
    while of_samples + of_rigs < wanted {
        let case = random_case(seed);
        of_samples += samples(&case);
        of_rigs += rigs(&case);
        seed += 1;
        if seed.is_multiple_of(1000) {
            println!("seed {seed}: {} steps", of_samples + of_rigs);
        }
    }
    println!(
        "seeds {first} to {}: {of_samples} steps of good rigs, {of_rigs} of rigs of any numbers, no harm",
        seed - 1
    );
}
