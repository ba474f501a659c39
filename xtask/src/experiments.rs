//! Writes the pages of `docs/results/experiments/` and those of their figures that are kept there.

use std::path::Path;
use std::{fs, io};

use crate::run::{Result, cargo, root, run};

/// Each has a page of its name, and a file in `experiments/`.
const EXPERIMENTS: [&str; 4] = ["plans", "breaking", "ablations", "disturbed"];

/// Runs the experiments that have a page, and writes it. It takes half an hour on two cores.
pub fn experiments() -> Result {
    EXPERIMENTS.into_iter().try_for_each(write_page)
}

fn write_page(name: &str) -> Result {
    let (out, pages) = (root().join("out/experiment").join(name), root().join("docs/results/experiments"));
    // An experiment goes on with the rows that it has, which may be of another estimator.
    if out.exists() {
        fs::remove_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    }
    run(&mut cargo(&["run", "--release", "--", "experiment", &format!("experiments/{name}.toml")]))?;
    let page = pages.join(name).with_extension("md");
    fs::copy(out.join("table.md"), &page).map_err(|error| format!("{}: {error}", page.display()))?;
    let figures = out.join("figures");
    keep_figures(&figures, &pages.join("figures")).map_err(|error| format!("{}: {error}", figures.display()))
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
