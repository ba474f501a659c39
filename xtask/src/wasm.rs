//! The compiler for WebAssembly: rustup's where the target is installed, else Debian's with the standard library's source.

use crate::run::{Result, cargo, root, target_dir};
use crate::thumb::{self, DEBIAN_RUSTC, debian_is_complete, host_has};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A browser's target.
pub const TARGET: &str = "wasm32-unknown-unknown";

const DEBIAN_LINKER: &str = "/usr/bin/wasm-ld-22";

/// A compiler that can build for [`TARGET`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wasm {
    /// The compiler that also builds for the host, with the target's library installed.
    Host,
    /// Debian's compiler; the standard library is built from its source package.
    Debian,
}

impl Wasm {
    /// The compiler to use, if there is one.
    pub fn find() -> Option<Self> {
        let debian = || debian_is_complete() && Path::new(DEBIAN_LINKER).is_file();
        host_has(TARGET).then_some(Self::Host).or_else(|| debian().then_some(Self::Debian))
    }

    /// The compiler to use, or what to install.
    pub fn require() -> Result<Self> {
        Self::find()
            .ok_or_else(|| format!("no compiler for {TARGET}: {}, or let `cargo xtask setup` do it", Self::need()))
    }

    /// What to do by hand.
    pub fn need() -> String {
        format!("`rustup target add {TARGET}`, or on Debian `apt-get install {}`", thumb::DEBIAN_PACKAGES.join(" "))
    }

    /// A cargo command, run at the root, that builds for the target.
    pub fn cargo(self, subcommand: &str) -> Command {
        let mut command = match self {
            Self::Host => cargo(&[subcommand]),
            Self::Debian => {
                let mut command = Command::new("/usr/bin/cargo");
                command.args([subcommand, "-Z", "build-std=std,panic_abort"]);
                // What the calling cargo set for its own compiler must not reach this one.
                command.env_remove("LD_LIBRARY_PATH").env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1");
                command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", DEBIAN_LINKER);
                command
            }
        };
        command.current_dir(root()).args(["--target", TARGET]).env("CARGO_TARGET_DIR", self.target_dir());
        command
    }

    /// Where this compiler's output goes: two compilers in one directory would rebuild each other's work.
    pub fn target_dir(self) -> PathBuf {
        match self {
            Self::Host => target_dir(),
            Self::Debian => target_dir().join("wasm-debian"),
        }
    }
}
