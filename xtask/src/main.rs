//! `cargo xtask`: set-up, tests and checks of the workspace.

#![forbid(unsafe_code)]

mod apt;
#[cfg(test)]
mod documents;
mod elf;
mod fail_safe;
mod figures;
mod hil;
mod pages;
mod panic_check;
mod qemu;
mod real_logs;
mod run;
mod setup;
mod size;
mod studio;
mod test;
mod thumb;
mod timing;
mod wasm;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask setup            install what the tests need (asks first, unless the variable CI is set)
cargo xtask test [STEP...]   set up what is missing, then run every step, or only the named ones
cargo xtask hil [ARG...]     run the firmware in the emulator, in the loop with the simulated home (see `lab hil --help`)
cargo xtask hil-long         ten minutes in the loop with look backs handed over, every estimate with the host's bits
cargo xtask late [MINUTES]   how late the estimator's steps begin in the emulator, with the back end and without
cargo xtask panic-check      show that slam-core has no panic path on the robot's processor
cargo xtask size             flash, RAM and stack of the robot's program, against their budgets
cargo xtask flash            build the robot's program and flash it through a debug probe (`cargo flash-robot` is the same)
cargo xtask timing           count the instructions of slam-core's routines and compare with docs/results/timing.csv
cargo xtask timing --update  write the counts into docs/results/timing.csv
cargo xtask studio           build the studio, a page for browsers, and print its folder last
cargo xtask studio --serve   build it and serve it on this machine
cargo xtask studio --measure build it and measure frames and speed in a browser
cargo xtask pages PAGE...    write pages of docs/results/ anew, and into its made.csv of which commit they are";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let result = match args.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["setup"] => setup::setup(),
        ["test", steps @ ..] => test::test(steps),
        ["hil", arguments @ ..] => hil::hil(arguments),
        ["hil-long"] => hil::long(),
        ["late"] => hil::timed("3"),
        ["late", minutes] => hil::timed(minutes),
        ["panic-check"] => panic_check::panic_check(),
        ["pages", names @ ..] => pages::pages(names),
        ["flash"] => size::flash(),
        ["size"] => size::size(),
        ["studio"] => studio::studio(),
        ["studio", "--serve"] => studio::serve(),
        ["studio", "--measure"] => studio::measure(),
        ["timing"] => timing::timing(false),
        ["timing", "--update"] => timing::timing(true),
        [] | ["help" | "--help" | "-h"] => {
            println!("{HELP}\n\nsteps: {}\npages: {}", test::step_names(), pages::names());
            Ok(())
        }
        other => Err(format!("cargo xtask {}: no such command\n{HELP}", other.join(" "))),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
