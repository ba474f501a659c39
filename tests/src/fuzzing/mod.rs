//! Hostile input, made of any bytes: one function for each way into the project, which panics where something that must hold
//! does not. `fuzz/` searches for such bytes guided by coverage, `tests/tests/hostile_input.rs` tries the committed ones and
//! random ones, `tests/examples/hostile_steps.rs` as many random steps as it is told.

mod drive;
mod rigs;
mod source;
mod text;

pub use drive::samples;
pub use rigs::rigs;
pub use source::Source;
pub use text::{logs, plans, rig_files, wire};

/// A target: its name, as in `fuzz/fuzz_targets`, and what it does with the bytes; the number of things tried.
pub type Target = (&'static str, fn(&[u8]) -> u64);

/// Every target.
pub const TARGETS: [Target; 6] =
    [("samples", samples), ("rigs", rigs), ("wire", wire), ("logs", logs), ("plans", plans), ("rig_files", rig_files)];

/// A case of a few hundred bytes that follow from a seed.
pub fn random_case(seed: u64) -> Vec<u8> {
    let mut rng = hal_sim::rng::Rng::stream(seed, "hostile input", 0);
    let length = 400 + rng.next_u64() as usize % 800;
    (0..length).map(|_| rng.next_u64() as u8).collect()
}
