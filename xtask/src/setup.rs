//! What the tests need beside a stable Rust, and how to get it.

use crate::apt;
use crate::run::{Result, on_path, output, run};
use crate::thumb::{DEBIAN_PACKAGES, TARGET, Thumb};
use crate::wasm::{self, Wasm};
use std::io::{IsTerminal, Write};
use std::process::Command;

/// Older models of the board stop in the clock set-up.
const OLDEST_QEMU: u32 = 10;
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Something that tests need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// rustfmt and clippy.
    Lints,
    /// A compiler for the robot's processor.
    Thumb,
    /// A compiler for browsers.
    Wasm,
    /// The emulator that runs the firmware.
    Qemu,
    /// The browser that checks report pages.
    Chromium,
}

impl Tool {
    const ALL: [Tool; 5] = [Tool::Lints, Tool::Thumb, Tool::Wasm, Tool::Qemu, Tool::Chromium];

    fn present(self) -> bool {
        match self {
            Self::Lints => {
                ["fmt", "clippy"].iter().all(|part| output(Command::new("cargo").args([part, "--version"])).is_ok())
            }
            Self::Thumb => Thumb::find().is_some(),
            Self::Wasm => Wasm::find().is_some(),
            Self::Qemu => qemu_major().is_some_and(|major| major >= OLDEST_QEMU),
            Self::Chromium => BROWSERS.iter().any(|name| on_path(name)),
        }
    }

    /// What is needed, in one line; also what to do by hand.
    fn need(self) -> String {
        match self {
            Self::Lints => "rustfmt and clippy: `rustup component add rustfmt clippy`".into(),
            Self::Thumb => format!(
                "a compiler for {TARGET}: `rustup target add {TARGET}`, or on Debian `apt-get install {}`",
                DEBIAN_PACKAGES.join(" ")
            ),
            Self::Wasm => format!("a compiler for {}: {}", wasm::TARGET, Wasm::need()),
            Self::Qemu => format!(
                "qemu-system-arm, version {OLDEST_QEMU} or newer: on Debian `apt-get install qemu-system-arm`, where \
                 that is older from the release's backports suite; elsewhere built from its source, or a container of \
                 Debian 13 as in .github/workflows"
            ),
            Self::Chromium => "Chromium or Chrome: on Debian `apt-get install chromium`".into(),
        }
    }

    fn install(self) -> Result {
        match self {
            Self::Lints => run(Command::new("rustup").args(["component", "add", "rustfmt", "clippy"])),
            Self::Thumb => install_target(TARGET, || Thumb::find().is_some()),
            Self::Wasm => install_target(wasm::TARGET, || Wasm::find().is_some()),
            Self::Qemu => install_qemu(),
            Self::Chromium => install_packages(&["chromium"], None),
        }
    }
}

/// Installs whatever is missing, after a question to the user; none on a CI machine.
pub fn setup() -> Result {
    let missing: Vec<Tool> = Tool::ALL.into_iter().filter(|tool| !tool.present()).collect();
    if missing.is_empty() {
        println!("set-up: everything the tests need is here");
        return Ok(());
    }
    println!("set-up: these are missing and will be installed:");
    for tool in &missing {
        println!("  - {}", tool.need());
    }
    if std::env::var_os("CI").is_none() {
        confirm()?;
    }
    for tool in missing {
        let by_hand = |error| format!("{error}\ninstall by hand: {}", tool.need());
        tool.install().map_err(by_hand)?;
        if !tool.present() {
            return Err(by_hand("what was installed is not usable".to_owned()));
        }
    }
    Ok(())
}

fn confirm() -> Result {
    if !std::io::stdin().is_terminal() {
        return Err("nobody is there to ask: install the above, or set CI=1 to let set-up do it".into());
    }
    print!("install them? [y/N] ");
    std::io::stdout().flush().map_err(|error| error.to_string())?;
    let mut answer = String::new();
    std::io::stdin().read_line(&mut answer).map_err(|error| error.to_string())?;
    if matches!(answer.trim(), "y" | "Y" | "yes") { Ok(()) } else { Err("not installed, as you wish".into()) }
}

/// A compiler for a target: rustup's, else Debian's.
fn install_target(target: &str, is_there: fn() -> bool) -> Result {
    if on_path("rustup") {
        let added = run(Command::new("rustup").args(["target", "add", target]));
        match added {
            Ok(()) if is_there() => return Ok(()),
            Ok(()) => println!("rustup has the target, but for another compiler than the one in use"),
            Err(error) if apt::available() => println!("{error}: trying Debian's compiler"),
            Err(error) => return Err(error),
        }
    }
    install_packages(&DEBIAN_PACKAGES, None)
}

fn install_qemu() -> Result {
    if !apt::available() {
        return Err("there is no apt-get here".into());
    }
    apt::refresh()?;
    let new_enough = apt::candidate("qemu-system-arm").and_then(|version| package_major(&version));
    if new_enough.is_some_and(|major| major >= OLDEST_QEMU) {
        return install_packages(&["qemu-system-arm"], None);
    }
    if !apt::has_backports() {
        return Err(format!("the newest qemu-system-arm of this distribution is older than {OLDEST_QEMU}"));
    }
    let suite = apt::enable_backports()?;
    install_packages(&["qemu-system-arm"], Some(&suite))
}

fn install_packages(packages: &[&str], suite: Option<&str>) -> Result {
    if apt::available() { apt::install(packages, suite) } else { Err("there is no apt-get here".into()) }
}

fn qemu_major() -> Option<u32> {
    let printed = output(Command::new("qemu-system-arm").arg("--version")).ok()?;
    printed.strip_prefix("QEMU emulator version ")?.split('.').next()?.parse().ok()
}

/// Upstream's major version in a Debian version such as `1:10.0.2+ds-2`.
fn package_major(version: &str) -> Option<u32> {
    let upstream = version.split_once(':').map_or(version, |(_, rest)| rest);
    upstream.split('.').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_debian_versions() {
        assert_eq!(package_major("1:7.2+dfsg-7+deb12u18+b3"), Some(7));
        assert_eq!(package_major("1:10.0.2+ds-2+deb13u1~bpo12+1"), Some(10));
        assert_eq!(package_major("11.0"), Some(11));
        assert_eq!(package_major("unknown"), None);
    }
}
