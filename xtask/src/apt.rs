//! Debian packages, from the mirror that the machine already uses.

use crate::run::{Result, on_path, output, run};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

const BACKPORTS_LIST: &str = "/etc/apt/sources.list.d/wall-slam-backports.list";
const OS_RELEASE: &str = "/etc/os-release";
const KEYRING: &str = "/usr/share/keyrings/debian-archive-keyring.gpg";

/// Whether this machine has Debian's package manager.
pub fn available() -> bool {
    on_path("apt-get") && on_path("dpkg")
}

/// Asks the mirror once what there is.
pub fn refresh() -> Result {
    static REFRESHED: OnceLock<Result> = OnceLock::new();
    REFRESHED.get_or_init(update).clone()
}

/// Installs packages, `suite` naming another than the default one.
pub fn install(packages: &[&str], suite: Option<&str>) -> Result {
    refresh()?;
    let mut command = apt_get();
    command.args(["install", "--yes", "--no-install-recommends"]);
    if let Some(suite) = suite {
        command.args(["--target-release", suite]);
    }
    run(command.args(packages))
}

/// The version that `install` would take, for instance `1:7.2+dfsg-7`.
pub fn candidate(package: &str) -> Option<String> {
    let policy = output(Command::new("apt-cache").args(["policy", package]).env("LC_ALL", "C")).ok()?;
    let version = policy.lines().find_map(|line| line.trim().strip_prefix("Candidate: "))?;
    (version != "(none)").then(|| version.to_owned())
}

/// Whether this is Debian itself, whose backports have what its releases lack, and not a distribution made from it.
pub fn has_backports() -> bool {
    is_debian(&std::fs::read_to_string(OS_RELEASE).unwrap_or_default())
}

fn is_debian(os_release: &str) -> bool {
    os_release.lines().any(|line| line.trim() == "ID=debian")
}

/// Makes the backports of this Debian release known, and returns the suite's name. Nothing is installed from there
/// unless asked for by name.
pub fn enable_backports() -> Result<String> {
    let release = std::fs::read_to_string(OS_RELEASE).unwrap_or_default();
    let codename = release
        .lines()
        .find_map(|line| line.strip_prefix("VERSION_CODENAME="))
        .ok_or_else(|| format!("{OS_RELEASE} names no VERSION_CODENAME, so the backports suite is unknown"))?;
    let suite = format!("{codename}-backports");
    let mirror = mirror(codename)?;
    let key = if Path::new(KEYRING).is_file() { format!("[signed-by={KEYRING}] ") } else { String::new() };
    write_as_root(BACKPORTS_LIST, &format!("deb {key}{mirror} {suite} main\n"))?;
    update()?;
    Ok(suite)
}

/// The address that this machine's sources give for a release of Debian.
fn mirror(codename: &str) -> Result<String> {
    let codename = format!("Codename: {codename}");
    let filter = ["indextargets", "--format", "$(REPO_URI)", "Created-By: Packages", "Origin: Debian", &codename];
    let listed = output(Command::new("apt-get").args(filter))?;
    let first = listed.lines().next().map(|line| line.trim().to_owned());
    first.ok_or_else(|| format!("no Debian mirror with '{codename}' among the sources in /etc/apt"))
}

fn update() -> Result {
    run(apt_get().arg("update"))
}

fn apt_get() -> Command {
    let mut command = as_root("apt-get");
    // Another program may be installing at this moment.
    command.env("DEBIAN_FRONTEND", "noninteractive").args(["-o", "DPkg::Lock::Timeout=300", "--quiet=2"]);
    command
}

fn as_root(program: &str) -> Command {
    let root = output(Command::new("id").arg("-u")).is_ok_and(|id| id.trim() == "0");
    if root {
        return Command::new(program);
    }
    let mut command = Command::new("sudo");
    command.arg(program);
    command
}

fn write_as_root(path: &str, text: &str) -> Result {
    let failed = |error: std::io::Error| format!("cannot write {path}: {error}");
    let mut tee = as_root("tee");
    let mut child = tee.arg(path).stdin(Stdio::piped()).stdout(Stdio::null()).spawn().map_err(failed)?;
    child.stdin.take().ok_or("tee has no input")?.write_all(text.as_bytes()).map_err(failed)?;
    let status = child.wait().map_err(failed)?;
    if status.success() { Ok(()) } else { Err(format!("cannot write {path}: tee gave {status}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distribution_made_from_debian_is_not_debian() {
        assert!(is_debian("NAME=\"Debian GNU/Linux\"\nID=debian\n"));
        assert!(!is_debian("NAME=\"Ubuntu\"\nID=ubuntu\nID_LIKE=debian\n"));
    }
}
