//! Hardware in the loop: the firmware's loop image in the emulator, driven by the workbench.

use crate::run::{Result, cargo, root, run, target_dir};
use crate::thumb::{TARGET, Thumb};
use std::path::PathBuf;
use std::process::Command;

/// What a loop image is built for.
struct Image {
    features: &'static str,
    name: &'static str,
}

impl Image {
    /// The image for these arguments of `lab hil`; a copy of each keeps them apart.
    fn of(arguments: &[&str]) -> Self {
        let serial = arguments.contains(&"--serial");
        let metric = arguments.windows(2).any(|pair| pair == ["--rig", METRIC]);
        let (features, name) = match (serial, metric) {
            (false, false) => ("hil", "hil-semihosting"),
            (true, false) => ("hil-usart", "hil-serial"),
            (false, true) => ("hil-metric", "hil-metric-semihosting"),
            (true, true) => ("hil-usart,hil-metric", "hil-metric-serial"),
        };
        Self { features, name }
    }

    fn build(&self) -> Result<PathBuf> {
        let thumb = Thumb::require()?;
        let mut build = thumb.cargo("firmware", "build");
        run(build.args(["--release", "--package", "firmware", "--bin", "hil", "--features", self.features]))?;
        let release = thumb.target_dir().join(TARGET).join("release");
        let copy = release.join(self.name);
        std::fs::copy(release.join("hil"), &copy).map_err(|error| format!("{}: {error}", copy.display()))?;
        Ok(copy)
    }
}

/// Builds the image and drives it with `lab hil`, which gets the other arguments.
pub fn hil(arguments: &[&str]) -> Result {
    drive_with(&mut cargo(&["run", "--quiet", "--package", "lab-cli", "--"]), arguments)
}

fn drive_with(lab: &mut Command, arguments: &[&str]) -> Result {
    let image = Image::of(arguments).build()?;
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
/// The robot with sensors that report metres.
const METRIC: &str = "time-of-flight";
/// Where its drive leaves its results.
const METRIC_DRIVE: &str = "target/hil/metric";
/// Largest error of the position in that drive, metres; dead reckoning has ten times as much.
const LARGEST_ERROR_M: f64 = 0.04;
/// Most walls over a metre that a drive passed and that its map lacks: one that was seen for hardly long enough.
const MOST_MISSED: f64 = 1.0;

/// Three minutes in the flat, by semihosting.
pub fn drive() -> Result {
    drive_with(&mut tested_lab()?, &["--minutes", "3", "--out", DRIVE])
}

/// A figure of the three-minute drive.
pub fn figure(key: &str) -> Result<f64> {
    figure_of(DRIVE, key)
}

fn figure_of(drive: &str, key: &str) -> Result<f64> {
    let file = root().join(drive).join("hil.json");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let prefix = format!("\"{key}\":");
    let value = text.lines().find_map(|line| line.trim().strip_prefix(&prefix));
    let value = value.and_then(|value| value.trim().trim_end_matches(',').parse().ok());
    value.ok_or_else(|| format!("{} has no number '{key}'", file.display()))
}

/// The drives that every change must pass: the three minutes, as long with sensors that report metres, and a short one over
/// the serial line.
pub fn test() -> Result {
    drive()?;
    drive_with(&mut tested_lab()?, &["--rig", METRIC, "--minutes", "3", "--out", METRIC_DRIVE])?;
    for drive in [DRIVE, METRIC_DRIVE] {
        let error_m = figure_of(drive, "ate_m")?;
        if error_m > LARGEST_ERROR_M {
            return Err(format!("{drive}: the position is off by {error_m:.3} m; at most {LARGEST_ERROR_M} m"));
        }
        let missed = figure_of(drive, "walls_missed")?;
        if missed > MOST_MISSED {
            return Err(format!("{drive}: {missed} walls are missed; at most {MOST_MISSED}"));
        }
    }
    drive_with(&mut tested_lab()?, &["--serial", "--minutes", "0.1", "--out", "target/hil/serial"])
}
