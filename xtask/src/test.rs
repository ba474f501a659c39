//! Every test and check, in the order of how soon they fail. Those of the host and those of the firmware and the browser build in folders of
//! their own and run beside each other: an emulator, a browser and a linker leave a core idle.

use crate::fail_safe;
use crate::hil;
use crate::panic_check::panic_check;
use crate::real_logs;
use crate::run::{HOST_TESTS, Result, cargo, run, target_dir};
use crate::setup;
use crate::size;
use crate::studio;
use crate::thumb::Thumb;
use crate::timing;
use std::io::{Read, pipe};
use std::process::Command;
use std::thread;
use std::time::Instant;

struct Step {
    name: &'static str,
    run: fn() -> Result,
    /// What this machine lacks for the step and set-up cannot install.
    missing: fn() -> Option<String>,
}

const fn step(name: &'static str, run: fn() -> Result) -> Step {
    Step { name, run, missing: || None }
}

const HOST: &[Step] = &[
    step("fmt", fmt),
    step("clippy", clippy),
    step("doc", doc),
    step("host", host),
    Step { name: "real-logs", run: real_logs::test, missing: real_logs::missing },
];

const BESIDE: &[Step] = &[
    step("no-std", no_std),
    step("firmware-lint", firmware_lint),
    step("firmware-host", firmware_host),
    step("fail-safe", fail_safe::test),
    step("hil", hil::test),
    step("panic-check", panic_check),
    step("size", size::size),
    step("timing", || timing::timing(false)),
    step("studio", studio::test),
];

fn names(steps: &[Step]) -> Vec<&'static str> {
    steps.iter().map(|step| step.name).collect()
}

/// The steps' names, for the help text.
pub fn step_names() -> String {
    [names(HOST), names(BESIDE)].concat().join(", ")
}

/// Installs what is missing, then runs the named steps, one after the other, or all.
pub fn test(wanted: &[&str]) -> Result {
    let steps = || HOST.iter().chain(BESIDE);
    if let Some(unknown) = wanted.iter().find(|name| steps().all(|step| step.name != **name)) {
        return Err(format!("no step is called '{unknown}'; there are: {}", step_names()));
    }
    setup::setup()?;
    if wanted.is_empty() {
        return all();
    }
    run_steps(steps().filter(|step| wanted.contains(&step.name)), true)
}

/// Runs the host's steps, and beside them the others by another process, whose words come last.
fn all() -> Result {
    let failed = |error: std::io::Error| format!("the steps beside: {error}");
    let (mut words, writer) = pipe().map_err(failed)?;
    let mut beside = Command::new(std::env::current_exe().map_err(failed)?);
    beside.arg("test").args(names(BESIDE)).stderr(writer.try_clone().map_err(failed)?).stdout(writer);
    let mut child = beside.spawn().map_err(failed)?;
    // It holds the pipe's other end open, at which reading would wait for ever.
    drop(beside);
    let reader = thread::spawn(move || {
        let mut said = Vec::new();
        words.read_to_end(&mut said).map(|_| said)
    });
    let host = run_steps(HOST.iter(), false);
    let status = child.wait().map_err(failed)?;
    let said = reader.join().map_err(|_| "reading the steps beside failed".to_owned())?.map_err(failed)?;
    println!("{}", String::from_utf8_lossy(&said).trim_end());
    let beside = if status.success() { Ok(()) } else { Err("a step beside failed, as said above".to_owned()) };
    match (host, beside) {
        (Err(host), Err(beside)) => Err(format!("{host}; {beside}")),
        (host, beside) => host.and(beside),
    }
}

/// One after the other. A step that cannot run here is an error where it was named, and said twice where it was not.
fn run_steps(steps: impl Iterator<Item = &'static Step>, are_named: bool) -> Result {
    let (mut times, mut not_run) = (Vec::new(), Vec::new());
    for Step { name, run, missing } in steps {
        println!("== {name}");
        if let Some(missing) = missing() {
            let message = format!("step '{name}' CANNOT RUN: {missing}");
            if are_named {
                return Err(message);
            }
            eprintln!("\n!! {message}\n");
            not_run.push(message);
            continue;
        }
        let start = Instant::now();
        run().map_err(|error| format!("step '{name}': {error}"))?;
        times.push(format!("{name} {:.0} s", start.elapsed().as_secs_f64()));
    }
    println!("{}", summary(&times, &not_run));
    Ok(())
}

/// The last line: what passed, and what did not run.
fn summary(times: &[String], not_run: &[String]) -> String {
    let passed = times.join(", ");
    if not_run.is_empty() {
        return format!("== all passed: {passed}");
    }
    format!("== passed: {passed}; NOT ALL WAS RUN: {}", not_run.join("; "))
}

fn fmt() -> Result {
    run(&mut cargo(&["fmt", "--all", "--check"]))?;
    run(&mut cargo(&["fmt", "--all", "--check", "--manifest-path", "firmware/Cargo.toml"]))?;
    // Without --all: its dependencies are the workspace's.
    run(&mut cargo(&["fmt", "--check", "--manifest-path", "fuzz/Cargo.toml"]))
}

fn clippy() -> Result {
    run(&mut cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
}

fn doc() -> Result {
    run(cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}

fn host() -> Result {
    run(&mut cargo(&HOST_TESTS))?;
    run(&mut cargo(&["test", "--workspace", "--doc"]))
}

/// The robot's crates build for a processor that has no standard library.
fn no_std() -> Result {
    let mut build = Thumb::require()?.cargo(".", "build");
    run(build.args([
        "--release",
        "--package",
        "slam-core",
        "--package",
        "look-back",
        "--package",
        "keeper",
        "--package",
        "robot",
        "--package",
        "wire",
    ]))?;
    let mut with_defmt = Thumb::require()?.cargo(".", "build");
    run(with_defmt.args(["--release", "--package", "slam-core", "--features", "defmt"]))
}

/// Clippy of the firmware's workspace; Debian's compiler comes without clippy, so that one checks with its own warnings.
fn firmware_lint() -> Result {
    let thumb = Thumb::require()?;
    let checks: [&[&str]; 7] = [
        &["--package", "timing", "--package", "panic-check"],
        &["--package", "firmware", "--bin", "robot", "--features", "board"],
        &["--package", "firmware", "--bin", "fail_safe", "--features", "fail-safe"],
        &["--package", "firmware", "--bin", "hil", "--features", "hil"],
        &["--package", "firmware", "--bin", "hil", "--features", "hil-metric"],
        &["--package", "firmware", "--bin", "hil", "--features", "hil-timed"],
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_did_not_run_is_named_at_the_end() {
        let times = ["fmt 1 s".to_owned()];
        assert_eq!(summary(&times, &[]), "== all passed: fmt 1 s");
        let line = summary(&times, &["step 'real-logs' CANNOT RUN: no logs".to_owned()]);
        assert!(!line.contains("all passed") && line.contains("fmt 1 s") && line.contains("'real-logs'"), "{line}");
    }
}
