//! The compiler for the robot's Cortex-M4F: rustup's where the target is installed, else Debian's with its own `core`.

use crate::run::{Result, cargo, output, root, run, target_dir};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The STM32F405's target.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// Debian's compiler, its library source and a linker.
pub const DEBIAN_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld-22"];
/// Setting this variable to `debian` or `rustup` takes that compiler and no other.
const CHOICE: &str = "THUMB_COMPILER";

/// Debian's compiler.
pub const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_LINKER: &str = "/usr/bin/lld-22";
const OLDEST: (u32, u32) = (1, 95);

/// A compiler that can build for [`TARGET`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thumb {
    /// The compiler that also builds for the host, with the target's `core` installed.
    Host,
    /// Debian's compiler; `core` is built from its source package.
    Debian,
}

impl Thumb {
    /// The compiler to use, if there is one.
    pub fn find() -> Option<Self> {
        let wanted = std::env::var(CHOICE).unwrap_or_default();
        let host = (wanted != "debian" && host_has(TARGET)).then_some(Self::Host);
        host.or_else(|| (wanted != "rustup" && debian_is_complete()).then_some(Self::Debian))
    }

    /// The compiler to use, or what to install.
    pub fn require() -> Result<Self> {
        Self::find().ok_or_else(|| {
            format!(
                "no compiler for {TARGET}: run `rustup target add {TARGET}`, or on Debian `apt-get install {}`, \
                 or let `cargo xtask setup` do it",
                DEBIAN_PACKAGES.join(" ")
            )
        })
    }

    /// A cargo command, run in `dir` (relative to the root), that builds for the target.
    pub fn cargo(self, dir: &str, subcommand: &str) -> Command {
        let mut command = match self {
            Self::Host => cargo(&[subcommand]),
            Self::Debian => {
                let mut command = Command::new("/usr/bin/cargo");
                command.args([subcommand, "-Z", "build-std=core"]);
                // What the calling cargo set for its own compiler must not reach this one.
                command.env_remove("LD_LIBRARY_PATH").env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1");
                command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", DEBIAN_LINKER);
                command
            }
        };
        command.current_dir(root().join(dir)).args(["--target", TARGET]);
        command.arg("--config").arg(format!("target.{TARGET}.rustflags={:?}", short_paths()));
        command.env("CARGO_TARGET_DIR", self.target_dir());
        command
    }

    /// Major and minor version of the compiler, for instance `1.95`.
    pub fn version(self) -> Result<String> {
        let program = if self == Self::Host { host_rustc() } else { DEBIAN_RUSTC.into() };
        let printed = output(Command::new(&program).arg("--version").current_dir(root()))?;
        let unknown = || format!("`{} --version` says '{}'", program.display(), printed.trim());
        let (major, minor) = rust_version(&printed).ok_or_else(unknown)?;
        Ok(format!("{major}.{minor}"))
    }

    /// Where this compiler's output goes: two compilers in one directory would rebuild each other's work.
    pub fn target_dir(self) -> PathBuf {
        let dir = target_dir();
        match self {
            Self::Host => dir.join("thumb"),
            Self::Debian => dir.join("thumb-debian"),
        }
    }
}

/// What keeps the folders of this machine out of the program: a place where it can panic carries its file's name, and so the flash that it
/// takes would depend on where the project and cargo's packages lie. Debuggers are still told the whole paths.
fn short_paths() -> Vec<String> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo"))).unwrap_or_default();
    let packages = home.join("registry/src");
    if !packages.is_dir() {
        // One folder for each registry, and none before the first package came. That none can be fetched, the build itself will say.
        run(&mut cargo(&["fetch"])).ok();
    }
    let registries = packages.read_dir().into_iter().flatten().flatten().map(|entry| entry.path());
    let mut folders: Vec<PathBuf> = registries.chain([root().to_path_buf()]).collect();
    folders.sort();
    let remap = folders.iter().map(|folder| format!("--remap-path-prefix={}/=", folder.display()));
    remap.chain(["--remap-path-scope=macro".to_owned()]).collect()
}

/// The compiler beside the cargo that runs this program; another one may come first on the path.
fn host_rustc() -> PathBuf {
    let cargo = std::env::var_os("CARGO").map(PathBuf::from);
    let beside = cargo.map(|cargo| cargo.with_file_name("rustc")).filter(|rustc| rustc.is_file());
    beside.unwrap_or_else(|| "rustc".into())
}

/// Whether the library for this target is installed beside the compiler that also builds for the host.
pub fn host_has(target: &str) -> bool {
    let sysroot = output(Command::new(host_rustc()).args(["--print", "sysroot"]).current_dir(root()));
    sysroot.is_ok_and(|dir| Path::new(dir.trim()).join("lib/rustlib").join(target).join("lib").is_dir())
}

/// Whether Debian's compiler is here with everything that it needs for a target without a library.
pub fn debian_is_complete() -> bool {
    let Ok(version) = output(Command::new(DEBIAN_RUSTC).arg("--version").env_remove("LD_LIBRARY_PATH")) else {
        return false;
    };
    rust_version(&version).is_some_and(|found| found >= OLDEST)
        && Path::new("/usr/bin/cargo").is_file()
        && Path::new(DEBIAN_LINKER).is_file()
        && Path::new("/usr/lib/rustlib/src/rust/library/core/src/lib.rs").is_file()
}

/// Major and minor version in the output of `rustc --version`.
fn rust_version(printed: &str) -> Option<(u32, u32)> {
    let mut numbers = printed.strip_prefix("rustc ")?.split('.').map(|part| part.parse().ok());
    Some((numbers.next()??, numbers.next()??))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_of_the_project_is_left_out() {
        let paths = short_paths();
        assert!(paths.contains(&format!("--remap-path-prefix={}/=", root().display())), "{paths:?}");
    }

    #[test]
    fn reads_the_compilers_version() {
        assert_eq!(rust_version("rustc 1.96.0 (ac68faa20 2026-05-25)"), Some((1, 96)));
        assert_eq!(rust_version("rustc 1.95.0-nightly"), Some((1, 95)));
        assert_eq!(rust_version("cargo 1.95.0"), None);
    }
}
