//! slam-core and look-back have no panic path on the robot's processor: the linker finds no way from its entry points to the handler.

use crate::elf::Elf;
use crate::run::{Result, run};
use crate::thumb::{TARGET, Thumb};
use std::collections::BTreeSet;

/// Kept by the linker exactly when some panic can be reached.
const HANDLER: &str = "panic_reached";

/// Checks the entry points, and that the check finds a panic that is put in.
pub fn panic_check() -> Result {
    let bad = link(&["--features", "bad"])?;
    if bad.find(HANDLER).is_none() {
        return Err("the panic path that was put in was not found: the check is blind".into());
    }
    let elf = link(&[])?;
    if elf.find(HANDLER).is_none() {
        println!("no panic path from the entry points of slam-core and look-back; one that was put in was found");
        return Ok(());
    }
    let places = panic_sites(&elf)?;
    Err(format!("slam-core or look-back can panic on the target, at {} places:\n{}", places.len(), places.join("\n")))
}

fn link(features: &[&str]) -> Result<Elf> {
    let thumb = Thumb::require()?;
    run(thumb.cargo("firmware", "build").args(["--release", "--package", "panic-check"]).args(features))?;
    Elf::read(&thumb.target_dir().join(TARGET).join("release/panic-check"))
}

/// Where code outside `core` enters the machinery of panics, with its source lines.
fn panic_sites(elf: &Elf) -> Result<Vec<String>> {
    let calls = elf.calls();
    let mut reached: BTreeSet<u64> = elf.find(HANDLER).map(|symbol| symbol.address).into_iter().collect();
    let mut sites = BTreeSet::new();
    let mut fresh = reached.clone();
    while !fresh.is_empty() {
        let mut next = BTreeSet::new();
        for call in calls.iter().filter(|call| fresh.contains(&call.to)) {
            let Some(caller) = elf.function_at(call.at) else { continue };
            if ["core::", "__rustc::"].iter().any(|machinery| caller.name.starts_with(machinery)) {
                next.extend(reached.insert(caller.address).then_some(caller.address));
            } else {
                sites.insert(call.at);
            }
        }
        fresh = next;
    }
    sites.into_iter().map(|at| describe(elf, at)).collect()
}

fn describe(elf: &Elf, at: u64) -> Result<String> {
    let function = elf.function_at(at).map_or("?", |symbol| &symbol.name);
    let lines = elf.lines(at)?;
    // The library's own lines say what kind of panic it is, ours where.
    let own = lines.iter().find(|line| !line.contains("/rustlib/") && !line.contains("/library/"));
    Ok(format!("  {} in {function} (inlined: {})", own.map_or("?", String::as_str), lines.join(" < ")))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    /// The names of the public functions of `impl Slam`, in the files of this folder and below.
    fn public_functions(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                public_functions(&path, found);
                continue;
            }
            let text = fs::read_to_string(&path).expect("a source file");
            let mut is_slam = false;
            for line in text.lines() {
                if line.starts_with("impl") {
                    is_slam = line.contains("> Slam<") && !line.contains(" for ");
                } else if let Some(rest) = line.strip_prefix("    pub ").filter(|_| is_slam) {
                    let name = rest
                        .trim_start_matches("const ")
                        .strip_prefix("fn ")
                        .and_then(|rest| rest.split(['(', '<']).next());
                    found.extend(name.map(str::to_owned));
                }
            }
        }
    }

    #[test]
    fn the_program_calls_every_public_function_of_the_estimator() {
        let root: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut names = Vec::new();
        public_functions(&root.join("slam-core/src"), &mut names);
        assert!(names.len() > 40, "{names:?}");
        let program = fs::read_to_string(root.join("firmware/panic-check/src/main.rs")).expect("the program");
        let is_called = |name: &String| [".", "::"].iter().any(|call| program.contains(&format!("{call}{name}(")));
        let missing: Vec<&String> = names.iter().filter(|name| !is_called(name)).collect();
        assert!(missing.is_empty(), "firmware/panic-check/src/main.rs does not call {missing:?}");
    }
}
