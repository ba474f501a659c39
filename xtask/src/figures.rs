//! Writes `docs/on-target.md`: every figure of the robot's processor on one page.

use crate::run::{Result, root};
use crate::{size, timing};
use std::fmt::Write;

const FILE: &str = "docs/on-target.md";

/// Measures and writes the page.
pub fn figures() -> Result {
    let (sizes, _) = size::measure()?;
    let drive = root().join(size::DRIVE).join("hil.json");
    let drive = std::fs::read_to_string(&drive).map_err(|error| format!("{}: {error}", drive.display()))?;
    let (counts, compiler) = timing::measure()?;
    let mut page = String::from(
        "# On the robot's processor\n\nWritten by `cargo xtask figures`. All of it is from the emulated STM32F405; nothing \
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

fn write_drive(page: &mut String, drive: &str) -> std::fmt::Result {
    let figure = |key: &str| {
        let prefix = format!("\"{key}\":");
        let value = drive.lines().find_map(|line| line.trim().strip_prefix(&prefix));
        value.map_or("?", |value| value.trim().trim_end_matches(',')).to_owned()
    };
    let centimetres = |key: &str| figure(key).parse().map_or("?".to_owned(), |m: f64| format!("{:.1} cm", 100.0 * m));
    writeln!(page, "\n## In the loop\n\n`lab hil --qemu`: three minutes in the flat, the firmware driving.\n")?;
    writeln!(page, "| figure | value |\n|---|---|")?;
    writeln!(page, "| estimates with the host's bits | {} |", figure("identical"))?;
    writeln!(page, "| estimates with other bits | {} |", figure("differences"))?;
    writeln!(page, "| position, best alignment (RMSE) | {} |", centimetres("ate_m"))?;
    writeln!(page, "| the same by dead reckoning | {} |", centimetres("odometry_ate_m"))?;
    let walls = [figure("walls"), figure("walls_missed"), figure("walls_invented")];
    writeln!(page, "| walls; missed; invented | {} |", walls.join("; "))
}

fn write_timing(
    page: &mut String,
    counts: &std::collections::BTreeMap<String, u32>,
    compiler: &str,
) -> std::fmt::Result {
    let cycles = timing::CYCLES_PER_INSTRUCTION;
    writeln!(page, "\n## Timing\n\nInstructions, counted exactly, compiler {compiler}; what each case is says")?;
    writeln!(
        page,
        "[timing.md](timing.md). Shares are of a core at 168 MHz, 25 times a second, at an assumed {cycles} cycles"
    )?;
    writeln!(page, "per instruction.\n\n| case | instructions | share |\n|---|---|---|")?;
    for (case, count) in counts {
        writeln!(page, "| {case} | {count} | {:.2} % |", timing::share_percent(*count))?;
    }
    Ok(())
}
