//! Hardware in the loop: the firmware's loop image in the emulator, driven by the workbench.

use crate::run::{HOST_TESTS, Result, cargo, root, run, target_dir};
use crate::thumb::{TARGET, Thumb};
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a loop image is built for.
struct Image {
    features: &'static str,
    name: &'static str,
}

impl Image {
    /// The image for these arguments of `lab hil`; a copy of each keeps them apart.
    fn of(arguments: &[&str]) -> Self {
        let (serial, timed) = (arguments.contains(&"--serial"), arguments.contains(&"--timed"));
        let metric = arguments.windows(2).any(|pair| pair == ["--rig", METRIC]);
        let (features, name) = match (serial, timed, metric) {
            (true, _, false) => ("hil-usart", "hil-serial"),
            (true, _, true) => ("hil-usart,hil-metric", "hil-metric-serial"),
            (false, true, false) => ("hil-timed", "hil-timed"),
            (false, true, true) => ("hil-timed,hil-metric", "hil-metric-timed"),
            (false, false, false) => ("hil", "hil-semihosting"),
            (false, false, true) => ("hil-metric", "hil-metric-semihosting"),
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
    run(cargo(&HOST_TESTS).args(["--quiet", "--no-run"]))?;
    let mut lab = Command::new(target_dir().join("debug/lab"));
    lab.current_dir(root());
    Ok(lab)
}

/// Where the three-minute drive leaves its results.
const DRIVE: &str = "target/hil/semihosting";
/// Where the cleaned room leaves them.
const CLEANED: &str = "target/hil/clean";
/// The robot with sensors that report metres.
const METRIC: &str = "time-of-flight";
/// Where its drive leaves its results.
const METRIC_DRIVE: &str = "target/hil/metric";
/// Where it leaves those on the processor's own clock, with look backs handed over and without.
const TIMED_DRIVES: [(&str, &str); 2] = [("true", "target/hil/timed"), ("false", "target/hil/timed-alone")];
/// Whether the first of them was driven by this program.
static TIMED: AtomicBool = AtomicBool::new(false);
/// Whether that with metres was.
static METRIC_DRIVEN: AtomicBool = AtomicBool::new(false);
/// Latest that a step may begin after its sample was due, microseconds: a fortieth of its period.
const LATEST_US: f64 = 1000.0;
/// Largest error of the position in a drive, metres; dead reckoning has ten times as much.
const LARGEST_ERROR_M: f64 = 0.04;
/// Most walls over a metre that a drive passed and that its map lacks: those that were seen for hardly long enough. Of fifty such drives on the
/// host 16 lack one and two lack two.
const MOST_MISSED: f64 = 2.0;
/// Least share of a room's floor that is swept, and how near to its start the robot ends, metres.
const LEAST_SWEPT: f64 = 0.96;
const HOME_M: f64 = 0.2;
/// Longest that it may take, minutes.
const LONGEST_MINUTES: &str = "15";

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

/// The drives that every change must pass: the three minutes, as long with sensors that report metres and look backs handed over, a
/// room cleaned, one whose map outlives resets and power cuts, one on the processor's own clock, and a short one over the serial line.
pub fn test() -> Result {
    drive()?;
    assert_accurate(DRIVE)?;
    metric_drive()?;
    assert_accurate(METRIC_DRIVE)?;
    if figure_of(METRIC_DRIVE, "hand_overs_taken")? < 1.0 {
        return Err(format!("{METRIC_DRIVE}: no look back was handed over"));
    }
    clean()?;
    drive_with(&mut tested_lab()?, &["--outlive", "--minutes", "3"])?;
    timed_drive("3", 0)?;
    drive_with(&mut tested_lab()?, &["--serial", "--minutes", "0.1", "--out", "target/hil/serial"])
}

/// Whether a drive's positions and its map are as they have to be.
fn assert_accurate(drive: &str) -> Result {
    let error_m = figure_of(drive, "ate_m")?;
    if error_m > LARGEST_ERROR_M {
        return Err(format!("{drive}: the position is off by {error_m:.3} m; at most {LARGEST_ERROR_M} m"));
    }
    match figure_of(drive, "walls_missed")? {
        missed if missed > MOST_MISSED => Err(format!("{drive}: {missed} walls are missed; at most {MOST_MISSED}")),
        _ => Ok(()),
    }
}

/// Three minutes of the robot whose sensors report metres.
fn metric_drive() -> Result {
    drive_with(&mut tested_lab()?, &["--rig", METRIC, "--minutes", "3", "--out", METRIC_DRIVE])?;
    METRIC_DRIVEN.store(true, Ordering::Relaxed);
    Ok(())
}

/// The floor job in the loop: a room is swept, and the robot comes back.
fn clean() -> Result {
    let job = ["--job", "clean", "--plan", "room", "--minutes", LONGEST_MINUTES, "--out", CLEANED];
    drive_with(&mut tested_lab()?, &job)?;
    let (swept, home_m) = (figure_of(CLEANED, "floor_swept")?, figure_of(CLEANED, "floor_home_m")?);
    if swept < LEAST_SWEPT || home_m > HOME_M {
        return Err(format!(
            "{CLEANED}: {swept:.3} of the floor is swept, and the robot ends {home_m:.2} m from its start; at least {LEAST_SWEPT} and \
             at most {HOME_M} m are wanted"
        ));
    }
    Ok(())
}

/// Ten minutes of the robot whose look backs are handed over, in lock step: as many estimates with the host's bits as there are.
pub fn long() -> Result {
    drive_with(&mut tested_lab()?, &["--rig", METRIC, "--minutes", "10", "--out", "target/hil/long"])?;
    match figure_of("target/hil/long", "hand_overs_taken")? {
        taken if taken >= 3.0 => Ok(()),
        taken => Err(format!("{taken} look backs were handed over; three at least are wanted")),
    }
}

/// Drives on the processor's own clock with the back end and without, and says how late the steps began in each.
pub fn timed(minutes: &str) -> Result {
    let drives = [timed_drive(minutes, 0)?, timed_drive(minutes, 1)?];
    println!("steps began late, us       median      99 %      most   look backs taken over");
    for (hand_overs, out) in drives {
        let [median, p99, most] = ["late_us_median", "late_us_99", "late_us_most"].map(|key| figure_of(out, key));
        let (median, p99, most) = (median?, p99?, most?);
        let (name, taken) = match hand_overs {
            "true" => ("with the back end", figure_of(out, "hand_overs_taken")?),
            _ => ("without", 0.0),
        };
        println!("{name:<22}{median:>11}{p99:>10}{most:>10}{taken:>10}");
    }
    Ok(())
}

/// One of these drives. The robot has the map of an earlier one and does not know where it is at first: searches are part of it.
fn timed_drive(minutes: &str, which: usize) -> Result<(&'static str, &'static str)> {
    let (hand_overs, out) = TIMED_DRIVES[which];
    if !METRIC_DRIVEN.load(Ordering::Relaxed) {
        metric_drive()?;
    }
    let map = format!("{METRIC_DRIVE}/map.bin");
    let begun = ["--hand-overs", hand_overs, "--map", &map];
    let drive = ["--timed", "--rig", METRIC, "--minutes", minutes, "--out", out];
    drive_with(&mut tested_lab()?, &[&drive[..], &begun].concat())?;
    TIMED.fetch_or(which == 0, Ordering::Relaxed);
    if figure_of(out, "found")? < 1.0 {
        return Err(format!("{out}: the robot did not find itself in its map"));
    }
    match figure_of(out, "late_us_most")? {
        most if most > LATEST_US => Err(format!("{out}: a step began {most} us late; at most {LATEST_US} us")),
        _ => Ok((hand_overs, out)),
    }
}

/// Deepest stack of a drive on the processor's own clock, bytes: there tasks interrupt the back end, as on the robot. Where the drives
/// that every change must pass were driven before by this program, it is theirs.
pub fn deepest_stack() -> Result<u64> {
    let (_, out) = TIMED_DRIVES[0];
    if !TIMED.load(Ordering::Relaxed) {
        timed_drive("3", 0)?;
    }
    Ok(figure_of(out, "stack_used_bytes")? as u64)
}
