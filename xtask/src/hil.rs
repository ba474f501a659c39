//! Hardware in the loop: the firmware's loop image in the emulator, driven by the workbench.

use crate::run::{Result, cargo, root, run, target_dir};
use crate::thumb::{TARGET, Thumb};
use std::path::PathBuf;
use std::process::Command;

/// How the host reaches the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkKind {
    /// Semihosting.
    Semihosting,
    /// The serial line USART2.
    Serial,
}

/// Builds the loop image; a copy keeps the two kinds apart.
pub fn image(kind: LinkKind) -> Result<PathBuf> {
    let (feature, name) = match kind {
        LinkKind::Semihosting => ("hil", "hil-semihosting"),
        LinkKind::Serial => ("hil-usart", "hil-serial"),
    };
    let thumb = Thumb::require()?;
    let mut build = thumb.cargo("firmware", "build");
    run(build.args(["--release", "--package", "firmware", "--bin", "hil", "--features", feature]))?;
    let release = thumb.target_dir().join(TARGET).join("release");
    let copy = release.join(name);
    std::fs::copy(release.join("hil"), &copy).map_err(|error| format!("{}: {error}", copy.display()))?;
    Ok(copy)
}

/// Builds the image and drives it with `lab hil`, which gets the other arguments.
pub fn hil(arguments: &[&str]) -> Result {
    drive_with(&mut cargo(&["run", "--quiet", "--package", "lab-cli", "--"]), arguments)
}

fn drive_with(lab: &mut Command, arguments: &[&str]) -> Result {
    let kind = if arguments.contains(&"--serial") { LinkKind::Serial } else { LinkKind::Semihosting };
    let image = image(kind)?;
    run(lab.args(["hil", "--qemu", "--image"]).arg(image).args(arguments))
}

/// The workbench as the host's tests have built it: alone it would be compiled again, with other features of its
/// dependencies.
fn tested_lab() -> Result<Command> {
    run(&mut cargo(&["test", "--quiet", "--workspace", "--no-run"]))?;
    let mut lab = Command::new(target_dir().join("debug/lab"));
    lab.current_dir(root());
    Ok(lab)
}

/// Where the three-minute drive leaves its results.
const DRIVE: &str = "target/hil/semihosting";
/// Largest error of the position in that drive, metres; dead reckoning has ten times as much.
const LARGEST_ERROR_M: f64 = 0.04;

/// Three minutes in the flat, by semihosting.
pub fn drive() -> Result {
    drive_with(&mut tested_lab()?, &["--minutes", "3", "--out", DRIVE])
}

/// A figure of the three-minute drive.
pub fn figure(key: &str) -> Result<f64> {
    let file = root().join(DRIVE).join("hil.json");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let prefix = format!("\"{key}\":");
    let value = text.lines().find_map(|line| line.trim().strip_prefix(&prefix));
    let value = value.and_then(|value| value.trim().trim_end_matches(',').parse().ok());
    value.ok_or_else(|| format!("{} has no number '{key}'", file.display()))
}

/// The drives that every change must pass: the three minutes, and a short one over the serial line.
pub fn test() -> Result {
    drive()?;
    let error_m = figure("ate_m")?;
    if error_m > LARGEST_ERROR_M {
        return Err(format!("the position in the loop is off by {error_m:.3} m; at most {LARGEST_ERROR_M} m"));
    }
    drive_with(&mut tested_lab()?, &["--serial", "--minutes", "0.1", "--out", "target/hil/serial"])
}
