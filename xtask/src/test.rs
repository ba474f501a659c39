//! Every test and check, in the order of how soon they fail.

use crate::fail_safe;
use crate::hil;
use crate::panic_check::panic_check;
use crate::run::{Result, cargo, run, target_dir};
use crate::setup;
use crate::size;
use crate::thumb::Thumb;
use crate::timing;
use std::time::Instant;

type Step = (&'static str, fn() -> Result);

const STEPS: &[Step] = &[
    ("fmt", fmt),
    ("clippy", clippy),
    ("doc", doc),
    ("no-std", no_std),
    ("host", host),
    ("firmware-lint", firmware_lint),
    ("firmware-host", firmware_host),
    ("fail-safe", fail_safe::test),
    ("hil", hil::test),
    ("panic-check", panic_check),
    ("size", size::size),
    ("timing", || timing::timing(false)),
];

/// The steps' names, for the help text.
pub fn step_names() -> String {
    STEPS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// Installs what is missing, then runs the named steps, or all.
pub fn test(wanted: &[&str]) -> Result {
    if let Some(unknown) = wanted.iter().find(|name| STEPS.iter().all(|(step, _)| step != *name)) {
        return Err(format!("no step is called '{unknown}'; there are: {}", step_names()));
    }
    setup::setup()?;
    let mut times = Vec::new();
    for (name, step) in STEPS.iter().filter(|(name, _)| wanted.is_empty() || wanted.contains(name)) {
        println!("== {name}");
        let start = Instant::now();
        step().map_err(|error| format!("step '{name}': {error}"))?;
        times.push(format!("{name} {:.0} s", start.elapsed().as_secs_f64()));
    }
    println!("== all passed: {}", times.join(", "));
    Ok(())
}

fn fmt() -> Result {
    run(&mut cargo(&["fmt", "--all", "--check"]))?;
    run(&mut cargo(&["fmt", "--all", "--check", "--manifest-path", "firmware/Cargo.toml"]))
}

fn clippy() -> Result {
    run(&mut cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
}

fn doc() -> Result {
    run(cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}

fn host() -> Result {
    run(&mut cargo(&["test", "--workspace"]))
}

/// The robot's crates build for a processor that has no standard library.
fn no_std() -> Result {
    let mut build = Thumb::require()?.cargo(".", "build");
    run(build.args(["--release", "--package", "slam-core", "--package", "robot", "--package", "wire"]))?;
    let mut with_defmt = Thumb::require()?.cargo(".", "build");
    run(with_defmt.args(["--release", "--package", "slam-core", "--features", "defmt"]))
}

/// Clippy of the firmware's workspace; Debian's compiler comes without clippy, so that one checks with its own warnings.
fn firmware_lint() -> Result {
    let thumb = Thumb::require()?;
    let checks: [&[&str]; 6] = [
        &["--package", "timing", "--package", "panic-check"],
        &["--package", "firmware", "--bin", "robot", "--features", "board"],
        &["--package", "firmware", "--bin", "fail_safe", "--features", "fail-safe"],
        &["--package", "firmware", "--bin", "hil", "--features", "hil"],
        &["--package", "firmware", "--bin", "hil", "--features", "hil-metric"],
        &["--package", "firmware", "--bin", "hil", "--features", "hil-usart"],
    ];
    for check in checks {
        let (subcommand, deny): (_, &[&str]) = match thumb {
            Thumb::Host => ("clippy", &["--", "-D", "warnings"]),
            Thumb::Debian => ("check", &[]),
        };
        run(thumb.cargo("firmware", subcommand).arg("--release").args(check).args(deny))?;
    }
    Ok(())
}

/// The firmware's tasks on this machine.
fn firmware_host() -> Result {
    let manifest = ["--manifest-path", "firmware/Cargo.toml", "--package", "firmware", "--lib", "--tests"];
    let dir = target_dir().join("firmware-host");
    run(cargo(&["clippy"]).args(manifest).args(["--", "-D", "warnings"]).env("CARGO_TARGET_DIR", &dir))?;
    run(cargo(&["test"]).args(manifest).env("CARGO_TARGET_DIR", &dir))
}
