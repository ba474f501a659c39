//! Instruction counts of the estimator's routines, held against the committed ones.

use crate::qemu;
use crate::run::{Result, root, run};
use crate::thumb::{TARGET, Thumb};
use std::collections::BTreeMap;
use std::time::Duration;

const FILE: &str = "docs/results/timing.csv";
/// What prints counts: the estimator's cases, and those of others, for which there is no memory beside them.
const PROGRAMS: [&str; 5] = ["timing", "look-back-timing", "back-end-timing", "search-timing", "floor-timing"];
const HEADER: &str = "case,compiler,instructions";
/// Largest growth over the committed figure with the same compiler.
const GROWTH: f64 = 1.05;
/// The same where only another compiler's figure is committed.
const OTHER_COMPILER_GROWTH: f64 = 1.25;
/// Assumed for cycles and shares of the core: what an update takes by the core's documented timings (`docs/notes/cost.md`); other code has
/// fewer loads. The flash's prefetch is taken to hide its wait states. Not measured on silicon.
pub const CYCLES_PER_INSTRUCTION: f64 = 1.9;
/// Counts that must not be exceeded, by whatever compiler.
const BARS: &[(&str, u32)] = &[
    ("update_n20", 1_950),
    ("update_n36", 4_300),
    ("update_n68", 12_000),
    ("update_n132", 36_000),
    ("dbscan_clutter", 150_000),
    ("dbscan_corner", 150_000),
    ("dbscan_heap", 150_000),
    ("step_n79_8_updates", 200_000),
    ("step_worst", 350_000),
    ("step_worst_dbscan", 350_000),
    // Two hundredths of a step.
    ("diary_step", 3_857),
    ("look_back_full", 1_500_000_000),
    ("look_back_slice", 350_000),
    ("back_end_slice", 350_000),
    // A step's period, less the worst of the filter's step and of the pilot's.
    ("back_end_handing_over", 3_000_000),
    // Five seconds of an idle core.
    ("search_full", 440_000_000),
    ("floor_job_average", 40_000),
    ("floor_job_worst", 150_000),
    ("pilot_average", 40_000),
    ("pilot_worst", 150_000),
];

/// By case, then by compiler.
type Figures = BTreeMap<String, BTreeMap<String, u32>>;

/// Measures, prints, and compares; with `update`, writes the figures down instead of comparing.
pub fn timing(update: bool) -> Result {
    let (measured, compiler) = measure()?;
    let path = root().join(FILE);
    let mut committed = match std::fs::read_to_string(&path) {
        Ok(text) => parse_file(&text)?,
        Err(_) if update => Figures::new(),
        Err(error) => return Err(format!("{FILE}: {error}; `cargo xtask timing --update` writes it")),
    };
    if !update {
        return compare(&measured, &committed, &compiler, BARS);
    }
    let over = over_bars(&measured, BARS);
    committed.retain(|case, _| measured.contains_key(case));
    for (case, count) in measured {
        committed.entry(case).or_default().insert(compiler.clone(), count);
    }
    std::fs::write(&path, write_file(&committed)).map_err(|error| format!("{FILE}: {error}"))?;
    println!("{FILE} is up to date with compiler {compiler}");
    if over.is_empty() { Ok(()) } else { Err(over.join("\n")) }
}

/// Counts every case; also says with which compiler.
pub fn measure() -> Result<(BTreeMap<String, u32>, String)> {
    let thumb = Thumb::require()?;
    run(thumb.cargo("firmware", "build").args(["--release", "--package", "timing"]))?;
    let mut counts = BTreeMap::new();
    for program in PROGRAMS {
        let elf = thumb.target_dir().join(TARGET).join("release").join(program);
        counts.extend(parse_output(&qemu::run(&elf, &[], Duration::from_secs(300))?)?);
    }
    Ok((counts, thumb.version()?))
}

/// Share of a core at 168 MHz that something takes 25 times a second, percent.
pub fn share_percent(instructions: u32) -> f64 {
    f64::from(instructions) * CYCLES_PER_INSTRUCTION * 25.0 / 168e6 * 100.0
}

/// Prints a table and lists what is wrong.
fn compare(measured: &BTreeMap<String, u32>, committed: &Figures, compiler: &str, bars: &[(&str, u32)]) -> Result {
    let mut wrong = Vec::new();
    println!(
        "{:<24} {:>14} {:>14} {:>9} {:>9} {:>15}",
        "case", "instructions", "committed", "change", "bar", "cycles (about)"
    );
    for (case, &count) in measured {
        let figures = committed.get(case);
        let (figure, allowed) = match figures.and_then(|by| by.get(compiler)) {
            Some(&figure) => (Some(figure), GROWTH),
            None => (figures.and_then(|by| by.values().copied().max()), OTHER_COMPILER_GROWTH),
        };
        let bar = bars.iter().find(|(name, _)| name == case).map_or("-".to_owned(), |(_, bar)| bar.to_string());
        let cycles = f64::from(count) * CYCLES_PER_INSTRUCTION;
        let Some(figure) = figure else {
            println!("{case:<24} {count:>14} {:>14} {:>9} {bar:>9} {cycles:>15.0}", "-", "-");
            wrong.push(format!("{case} has no figure in {FILE}"));
            continue;
        };
        let change = f64::from(count) / f64::from(figure.max(1));
        println!("{case:<24} {count:>14} {figure:>14} {:>8.1}% {bar:>9} {cycles:>15.0}", (change - 1.0) * 100.0);
        if change > allowed {
            wrong.push(format!("{case} grew from {figure} to {count} (at most {:.0} %)", (allowed - 1.0) * 100.0));
        }
    }
    let gone = committed.keys().filter(|case| !measured.contains_key(*case));
    wrong.extend(gone.map(|case| format!("{case} of {FILE} was not measured")));
    let over = over_bars(measured, bars);
    if wrong.is_empty() && over.is_empty() {
        return Ok(());
    }
    let mut message: Vec<String> = over;
    if !wrong.is_empty() {
        message.extend(wrong);
        message.push("if this is meant, `cargo xtask timing --update` writes the new figures".to_owned());
    }
    Err(message.join("\n"))
}

/// The cases that exceed their bars, or have one and were not measured.
fn over_bars(measured: &BTreeMap<String, u32>, bars: &[(&str, u32)]) -> Vec<String> {
    let verdict = |&(case, bar): &(&str, u32)| match measured.get(case) {
        Some(&count) if count <= bar => None,
        Some(count) => Some(format!("{case} takes {count} instructions, over the bar of {bar}")),
        None => Some(format!("{case}, which has a bar of {bar}, was not measured")),
    };
    bars.iter().filter_map(verdict).collect()
}

fn parse_output(printed: &str) -> Result<BTreeMap<String, u32>> {
    let mut cases = BTreeMap::new();
    for line in printed.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let ["timing", case, count, "instructions"] = words.as_slice() else {
            return Err(format!("the timing program printed '{line}'"));
        };
        let count = count.parse().map_err(|_| format!("the timing program printed '{line}'"))?;
        cases.insert((*case).to_owned(), count);
    }
    if cases.is_empty() { Err("the timing program printed nothing".into()) } else { Ok(cases) }
}

fn parse_file(text: &str) -> Result<Figures> {
    let mut figures = Figures::new();
    for (at, line) in text.lines().enumerate() {
        if at == 0 && line == HEADER {
            continue;
        }
        let bad = || format!("{FILE} line {}: '{line}' is not `{HEADER}`", at + 1);
        let mut fields = line.split(',');
        let (Some(case), Some(compiler), Some(count), None) =
            (fields.next(), fields.next(), fields.next(), fields.next())
        else {
            return Err(bad());
        };
        let count = count.parse().map_err(|_| bad())?;
        figures.entry(case.to_owned()).or_default().insert(compiler.to_owned(), count);
    }
    Ok(figures)
}

fn write_file(figures: &Figures) -> String {
    let mut text = format!("{HEADER}\n");
    for (case, by_compiler) in figures {
        for (compiler, count) in by_compiler {
            text.push_str(&format!("{case},{compiler},{count}\n"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(count: u32) -> BTreeMap<String, u32> {
        parse_output(&format!("timing step {count} instructions\n")).unwrap()
    }

    #[test]
    fn growth_over_five_percent_fails() {
        let committed = parse_file("case,compiler,instructions\nstep,1.95,1000\n").unwrap();
        assert!(compare(&measured(1050), &committed, "1.95", &[]).is_ok());
        assert!(compare(&measured(1051), &committed, "1.95", &[]).is_err());
        assert!(compare(&measured(1051), &committed, "1.96", &[]).is_ok(), "another compiler has more room");
        assert!(compare(&measured(1251), &committed, "1.96", &[]).is_err());
    }

    #[test]
    fn a_bar_holds_whatever_is_committed() {
        let committed = parse_file("case,compiler,instructions\nstep,1.95,2000\n").unwrap();
        assert!(compare(&measured(1000), &committed, "1.95", &[("step", 1000)]).is_ok());
        let error = compare(&measured(1001), &committed, "1.95", &[("step", 1000)]).unwrap_err();
        assert!(error.contains("over the bar of 1000") && !error.contains("--update"), "{error}");
        assert!(compare(&measured(1000), &committed, "1.95", &[("other", 1000)]).is_err(), "a bar without a case");
    }

    #[test]
    fn cases_must_match_the_file() {
        let committed = parse_file("case,compiler,instructions\nother,1.95,1000\n").unwrap();
        let error = compare(&measured(1000), &committed, "1.95", &[]).unwrap_err();
        assert!(error.contains("step has no figure") && error.contains("other of"), "{error}");
        assert!(parse_file("case,compiler,instructions\nstep,1.95\n").unwrap_err().contains("line 2"));
        assert!(parse_output("panicked").is_err());
    }

    #[test]
    fn a_file_written_reads_back() {
        let text = "case,compiler,instructions\na,1.95,7\na,1.96,8\nb,1.95,9\n";
        assert_eq!(write_file(&parse_file(text).unwrap()), text);
    }
}
