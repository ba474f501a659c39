//! Writes the pages of `docs/results/` anew, and into `docs/results/made.csv` of which commit each is.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};
use std::{fs, io};

use crate::run::{Result, cargo, output, root, run};
use crate::{figures, real_logs};

const PAGES: &str = "docs/results";
const MADE: &str = "docs/results/made.csv";
const HEAD: &str = "page,commit,minutes\n";

/// What makes a page.
enum Source {
    /// An example of a package, by its name, writes it, with these arguments.
    Writes(&'static str, &'static str, &'static [&'static str]),
    /// An example of `tests` prints it.
    Prints(&'static str, &'static [&'static str]),
    /// The same, told which logs of real robots to look into.
    PrintsLogs(&'static str, &'static [&'static str]),
    /// The experiment of its name, with those of its figures that are kept.
    Experiment,
    /// This program measures it.
    Target,
}

/// Each page, and what makes it. The last two take hours.
const ALL: [(&str, Source); 19] = [
    ("summary", Source::Writes("tests", "results", &[])),
    ("real-logs", Source::Writes("tests", "real_logs", &[])),
    ("robots", Source::Prints("robots", &[])),
    ("look-back", Source::PrintsLogs("robot_look_back", &LOGS)),
    ("hand-overs", Source::PrintsLogs("hand_overs", &LOGS)),
    ("relocation", Source::Prints("relocation", &["60"])),
    ("kept-pairs", Source::Prints("kept_pairs", &[])),
    ("mishaps", Source::Writes("tests", "mishaps", &["docs/results/mishaps.md"])),
    ("long-drives", Source::Writes("tests", "long_drives", &["docs/results/long-drives.md"])),
    ("floor", Source::Writes("lab", "floor_jobs", &[])),
    ("floor-again", Source::Writes("lab", "second_runs", &[])),
    ("clean-areas", Source::Writes("lab", "clean_areas", &[])),
    ("experiments/plans", Source::Experiment),
    ("experiments/breaking", Source::Experiment),
    ("experiments/ablations", Source::Experiment),
    ("experiments/disturbed", Source::Experiment),
    ("on-target", Source::Target),
    ("hostile-steps", Source::Writes("tests", "hostile_steps", &["100000000", "0", "docs/results/hostile-steps.md"])),
    ("relatives", Source::Writes("tests", "relatives", &[])),
];

/// Folders of logs that the pages of look backs show.
const LOGS: [&str; 5] = ["fr079-first", "olsson-demo", "wean-1", "wean-5", "rice"];

/// The pages' names.
pub fn names() -> String {
    ALL.map(|(name, ..)| name).join(", ")
}

/// Writes the pages of these names.
pub fn pages(names: &[&str]) -> Result {
    if names.is_empty() {
        return Err(format!("cargo xtask pages: which ones? There are {}", self::names()));
    }
    let find = |name: &&str| {
        let page = ALL.iter().find(|(known, ..)| known == name);
        page.ok_or_else(|| format!("cargo xtask pages {name}: no such page; there are {}", self::names()))
    };
    let asked = names.iter().map(find).collect::<Result<Vec<_>>>()?;
    asked.into_iter().try_for_each(|(name, source)| {
        let begun = Instant::now();
        write(name, source)?;
        note(name, begun.elapsed())
    })
}

fn write(name: &str, source: &Source) -> Result {
    let page = root().join(PAGES).join(name).with_extension("md");
    match source {
        Source::Writes(package, name, arguments) => run(example(package, name).args(*arguments)),
        Source::Prints(name, arguments) => print(example("tests", name).args(*arguments), &page),
        Source::PrintsLogs(name, logs) => {
            let folder = real_logs::folder();
            print(example("tests", name).args(logs.iter().map(|log| folder.join(log))), &page)
        }
        Source::Experiment => write_experiment(name, &page),
        Source::Target => figures::figures(),
    }
}

/// Runs an example that knows where the logs of real robots are, before its arguments.
fn example(package: &str, name: &str) -> Command {
    let mut command = cargo(&["run", "--release", "--package", package, "--example", name, "--"]);
    command.env(real_logs::VARIABLE, real_logs::folder());
    command
}

/// Writes what a command prints into a page.
fn print(command: &mut Command, page: &Path) -> Result {
    fs::write(page, output(command)?).map_err(|error| format!("{}: {error}", page.display()))
}

/// Runs the experiment and keeps its table, and those of its figures that are kept.
fn write_experiment(name: &str, page: &Path) -> Result {
    let file = format!("{name}.toml");
    let out = root().join("out/experiment").join(page.file_stem().unwrap_or_default());
    // An experiment goes on with the rows that it has, which may be of another estimator.
    if out.exists() {
        fs::remove_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    }
    run(&mut cargo(&["run", "--release", "--", "experiment", &file]))?;
    fs::copy(out.join("table.md"), page).map_err(|error| format!("{}: {error}", page.display()))?;
    let figures = out.join("figures");
    let kept = root().join(PAGES).join("experiments/figures");
    keep_figures(&figures, &kept).map_err(|error| format!("{}: {error}", figures.display()))
}

/// Replaces the figures that are kept by those of the same names.
fn keep_figures(from: &Path, to: &Path) -> io::Result<()> {
    for kept in fs::read_dir(to)? {
        let kept = kept?;
        let new = from.join(kept.file_name());
        if new.is_file() {
            fs::copy(new, kept.path())?;
        }
    }
    Ok(())
}

/// Notes of which commit a page is, with a `+` where the code was changed since, and how long it took.
fn note(name: &str, took: Duration) -> Result {
    let file = root().join(MADE);
    let git = |arguments: &[&str]| output(Command::new("git").current_dir(root()).args(arguments));
    let mut commit = git(&["rev-parse", "--short=8", "HEAD"])?.trim().to_owned();
    // Pages that were just written are no change of what makes them.
    if !git(&["status", "--porcelain", "--", ".", ":!docs"])?.is_empty() {
        commit.push('+');
    }
    let made = fs::read_to_string(&file).map_err(|error| format!("{MADE}: {error}"))?;
    let text = with_row(&made, name, &commit, took.as_secs().div_ceil(60));
    fs::write(&file, text).map_err(|error| format!("{MADE}: {error}"))
}

/// The table with this page's row, in the order of the pages.
fn with_row(made: &str, name: &str, commit: &str, minutes: u64) -> String {
    let mut text = String::from(HEAD);
    for (page, ..) in &ALL {
        let is_page = |row: &&str| row.split(',').next() == Some(*page);
        if *page == name {
            text += &format!("{name},{commit},{minutes}\n");
        } else if let Some(row) = made.lines().find(is_page) {
            text += row;
            text.push('\n');
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_is_made_again_has_one_row_at_its_place() {
        let first = with_row(HEAD, "robots", "abc", 4);
        let second = with_row(&with_row(&first, "summary", "def", 1), "robots", "012", 5);
        assert_eq!(second, "page,commit,minutes\nsummary,def,1\nrobots,012,5\n");
    }

    #[test]
    fn every_page_in_the_folder_is_made_by_a_name() {
        let folder = root().join(PAGES);
        for (sub, prefix) in [("", ""), ("experiments", "experiments/")] {
            let entries = fs::read_dir(folder.join(sub)).expect("the folder of pages");
            let pages = entries.map(|entry| entry.expect("an entry").path());
            for page in pages.filter(|path| path.extension().is_some_and(|end| end == "md")) {
                let name = format!("{prefix}{}", page.file_stem().expect("a name").to_string_lossy());
                assert!(name == "experiments/sensor" || ALL.iter().any(|(known, ..)| *known == name), "{name}");
            }
        }
    }
}
