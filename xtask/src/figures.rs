//! Writes `docs/results/on-target.md`: every figure of the robot's processor on one page.

use crate::run::{Result, root};
use crate::{hil, size, timing};
use std::fmt::Write;

const FILE: &str = "docs/results/on-target.md";

/// Measures and writes the page.
pub fn figures() -> Result {
    let (sizes, _) = size::measure()?;
    let drive = Drive::measure()?;
    let (counts, compiler) = timing::measure()?;
    let mut page = String::from(
        "# On the robot's processor\n\nWritten by `cargo xtask pages on-target`. All of it is from the emulated STM32F405; nothing \
         was measured on silicon yet.\n",
    );
    // Writing to a String cannot fail.
    let _ = write_sizes(&mut page, &sizes);
    let _ = write_drive(&mut page, &drive);
    let _ = write_timing(&mut page, &counts, &compiler);
    std::fs::write(root().join(FILE), page).map_err(|error| format!("{FILE}: {error}"))?;
    println!("{FILE} is written");
    Ok(())
}

fn write_sizes(page: &mut String, sizes: &size::Sizes) -> std::fmt::Result {
    writeln!(
        page,
        "\n## Size\n\nEight sensors, 64 grid walls, 128 buffered outliers. Flash and variables are those of the"
    )?;
    writeln!(
        page,
        "robot's own image; the stack is the deepest of a three-minute drive of the loop image, which runs"
    )?;
    writeln!(page, "the same tasks. `cargo xtask size` lists crates and symbols.\n")?;
    writeln!(page, "| what | bytes | budget |\n|---|---|---|")?;
    for (name, bytes, budget) in sizes.rows() {
        writeln!(page, "| {name} | {bytes} | {} |", budget.map_or(String::new(), |budget| budget.to_string()))?;
    }
    Ok(())
}

/// Figures of the drive in the loop.
struct Drive {
    identical: f64,
    differences: f64,
    ate_m: f64,
    odometry_ate_m: f64,
    walls: [f64; 3],
}

impl Drive {
    fn measure() -> Result<Self> {
        hil::drive()?;
        Ok(Self {
            identical: hil::figure("identical")?,
            differences: hil::figure("differences")?,
            ate_m: hil::figure("ate_m")?,
            odometry_ate_m: hil::figure("odometry_ate_m")?,
            walls: [hil::figure("walls")?, hil::figure("walls_missed")?, hil::figure("walls_invented")?],
        })
    }
}

fn write_drive(page: &mut String, drive: &Drive) -> std::fmt::Result {
    writeln!(page, "\n## In the loop\n\n`lab hil --qemu`: three minutes in the flat, the firmware driving.\n")?;
    writeln!(page, "| figure | value |\n|---|---|")?;
    writeln!(page, "| estimates with the host's bits | {} |", drive.identical)?;
    writeln!(page, "| estimates with other bits | {} |", drive.differences)?;
    writeln!(page, "| position, best alignment (RMSE) | {:.1} cm |", 100.0 * drive.ate_m)?;
    writeln!(page, "| the same by dead reckoning | {:.1} cm |", 100.0 * drive.odometry_ate_m)?;
    let [walls, missed, invented] = drive.walls;
    writeln!(page, "| walls; missed; invented | {walls}; {missed}; {invented} |")
}

/// What every one of the 25 steps a second has, so that it takes a share of the time; all else is done now and then, or over many steps.
const EACH_STEP: [&str; 5] = ["predict_", "step_", "diary_step", "floor_job_", "pilot_"];

fn is_of_each_step(case: &str) -> bool {
    EACH_STEP.iter().any(|name| case.starts_with(name))
}

fn write_timing(
    page: &mut String,
    counts: &std::collections::BTreeMap<String, u32>,
    compiler: &str,
) -> std::fmt::Result {
    let cycles = timing::CYCLES_PER_INSTRUCTION;
    writeln!(page, "\n## Timing\n\nInstructions, counted exactly, compiler {compiler}. What each case is says")?;
    writeln!(
        page,
        "[timing.md](../reference/timing.md). Shares, of what each step has, are of a core at 168 MHz, 25 times a second,"
    )?;
    writeln!(page, "at an assumed {cycles} cycles per instruction.\n\n| case | instructions | share |\n|---|---|---|")?;
    for (case, count) in counts {
        let share =
            if is_of_each_step(case) { format!("{:.2} %", timing::share_percent(*count)) } else { String::new() };
        writeln!(page, "| {case} | {count} | {share} |")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_done_with_every_step_has_no_share_of_the_time() {
        let counts = [("search_full".to_owned(), 154_795_945), ("step_worst".to_owned(), 276_707)].into();
        let mut page = String::new();
        write_timing(&mut page, &counts, "1.95").expect("a String takes it all");
        assert!(page.contains("| search_full | 154795945 |  |\n| step_worst | 276707 | 7.82 % |\n"), "{page}");
        assert!(
            ["back_end_step", "hand_over", "diary_thin", "look_back_slice"].iter().all(|case| !is_of_each_step(case))
        );
    }
}
