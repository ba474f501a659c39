//! Hardware in the loop: the firmware's loop image in the emulator, driven by the workbench.

use crate::run::{Result, cargo, run};
use crate::thumb::{TARGET, Thumb};
use std::path::PathBuf;

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
    let kind = if arguments.contains(&"--serial") { LinkKind::Serial } else { LinkKind::Semihosting };
    let image = image(kind)?;
    let mut lab = cargo(&["run", "--quiet", "--package", "lab", "--", "hil", "--qemu", "--image"]);
    run(lab.arg(image).args(arguments))
}

/// The drives that every change must pass: three minutes by semihosting, a short one over the serial line.
pub fn test() -> Result {
    hil(&["--minutes", "3", "--out", "target/hil/semihosting"])?;
    hil(&["--serial", "--minutes", "0.1", "--out", "target/hil/serial"])
}
