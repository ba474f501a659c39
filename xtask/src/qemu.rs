//! Programs on the emulated robot board.

use crate::run::Result;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Runs a bare program that ends by semihosting, one clock tick per instruction, and returns what it printed. The
/// emulator gets the other arguments.
pub fn run(elf: &Path, arguments: &[&str], limit: Duration) -> Result<String> {
    let mut command = Command::new("qemu-system-arm");
    command.args(["-machine", "olimex-stm32-h405", "-display", "none", "-monitor", "none", "-serial", "null"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-icount", "shift=0,sleep=off"]).args(arguments);
    let failed = |error: std::io::Error| format!("qemu-system-arm: {error}");
    let mut child =
        command.arg("-kernel").arg(elf).stdin(Stdio::null()).stdout(Stdio::piped()).spawn().map_err(failed)?;
    let mut printed = child.stdout.take().ok_or("qemu-system-arm has no output")?;
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        printed.read_to_string(&mut text).map(|_| text)
    });
    let start = Instant::now();
    let status = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) => break Some(status),
            None if start.elapsed() > limit => break None,
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    if status.is_none() {
        child.kill().and_then(|()| child.wait()).map_err(failed)?;
    }
    let text = reader.join().map_err(|_| "reading what the emulator printed failed")?.map_err(failed)?;
    match status {
        Some(status) if status.success() => Ok(text),
        Some(status) => Err(format!("{} in the emulator gave {status} and printed:\n{text}", elf.display())),
        None => Err(format!("{} in the emulator did not end in {limit:?} and printed:\n{text}", elf.display())),
    }
}
