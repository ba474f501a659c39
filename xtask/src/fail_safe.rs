//! What reaches the motor driver's enable line when the robot's program fails, seen in the emulator.

use crate::qemu;
use crate::run::{Result, run};
use crate::thumb::{TARGET, Thumb};
use std::time::Duration;

/// Ways to fail, and the last words to each.
const WAYS: [(&str, &str); 4] = [
    ("panic", "as wanted"),
    ("fault", "hard fault"),
    ("overflow", "stack overflow"),
    // Interrupt 52 is UART4's.
    ("interrupt", "interrupt 52"),
];

/// The emulator has no port C: it logs what is written there. The program's mark that it runs; the enable line low, by the
/// handler; the mark of the last words.
const WRITTEN: [&str; 3] =
    ["offset 0x014, value 0x00001111", "offset 0x018, value 0x01000000", "offset 0x014, value 0x00009999"];

/// Every way to fail takes the enable line low before anything else.
pub fn test() -> Result {
    let thumb = Thumb::require()?;
    let mut build = thumb.cargo("firmware", "build");
    run(build.args(["--release", "--package", "firmware", "--bin", "fail_safe", "--features", "fail-safe"]))?;
    let release = thumb.target_dir().join(TARGET).join("release");
    let log = release.join("fail_safe.log");
    for (way, words) in WAYS {
        let failed = |error: std::io::Error| format!("{}: {error}", log.display());
        std::fs::write(&log, "").map_err(failed)?;
        let named = format!("enable=on,target=native,arg=fail_safe,arg={way}");
        let file = log.to_string_lossy();
        let arguments = ["-semihosting-config", &named, "-d", "unimp", "-D", &file];
        let said = qemu::run(&release.join("fail_safe"), &arguments, Duration::from_secs(60))?;
        let text = std::fs::read_to_string(&log).map_err(failed)?;
        judge(&said, words, &text).map_err(|error| format!("{way}: {error}"))?;
        println!("{way}: the enable line is low before the last words, '{words}'");
    }
    Ok(())
}

fn judge(said: &str, words: &str, log: &str) -> Result {
    if said.trim() != words {
        return Err(format!("the last words are '{}', not '{words}'", said.trim()));
    }
    let writes: Vec<&str> = log.lines().filter(|line| line.contains("GPIOC: unimplemented device write")).collect();
    let as_due = writes.len() == WRITTEN.len() && writes.iter().zip(WRITTEN).all(|(line, due)| line.contains(due));
    if as_due { Ok(()) } else { Err(format!("written to port C:\n{}\nexpected: {WRITTEN:?}", writes.join("\n"))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(writes: &[&str]) -> String {
        writes.iter().map(|write| format!("GPIOC: unimplemented device write (size 4, {write})\n")).collect()
    }

    #[test]
    fn an_enable_line_that_goes_low_late_or_not_at_all_fails() {
        assert_eq!(judge("hard fault\n", "hard fault", &log(&WRITTEN)), Ok(()));
        let [begin, low, last] = WRITTEN;
        for wrong in [&[begin, last, low][..], &[begin, last], &[low], &[]] {
            assert!(judge("hard fault\n", "hard fault", &log(wrong)).is_err(), "{wrong:?}");
        }
        assert!(judge("as wanted", "hard fault", &log(&WRITTEN)).is_err());
    }
}
