//! Hostile input, a little of it: the committed cases, and random ones. `tests/examples/hostile_steps.rs` does as many as it is
//! told, `fuzz/` looks for worse ones.

use std::fs;
use std::path::Path;

use tests::fuzzing::{TARGETS, random_case};

/// Random cases for each target: together some 10^5 steps of the estimator.
const CASES: u64 = 50;

#[test]
fn committed_cases_do_no_harm() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus");
    for (name, target) in TARGETS {
        let files = fs::read_dir(corpus.join(name)).unwrap_or_else(|e| panic!("fuzz/corpus/{name}: {e}"));
        let mut tried = 0;
        for file in files {
            let file = file.expect("a folder that can be read").path();
            println!("{}", file.display());
            target(&fs::read(&file).expect("a file that can be read"));
            tried += 1;
        }
        assert!(tried > 0, "fuzz/corpus/{name} has no cases");
    }
}

#[test]
fn random_cases_do_no_harm() {
    for (name, target) in TARGETS {
        let tried: u64 = (0..CASES)
            .map(|seed| {
                println!("{name}, seed {seed}");
                target(&random_case(seed))
            })
            .sum();
        println!("{name}: {tried} tried");
        assert!(name != "samples" || tried > 50_000, "{tried} steps are too few");
    }
}
