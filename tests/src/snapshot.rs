//! Figures of runs over several seeds beside committed ones.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

/// A figure that every run has.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name.
    pub name: &'static str,
    /// Whether it is an error, which may shrink as much as it likes.
    pub is_error: bool,
}

/// One line of a snapshot: what was run, and the values of each column, one a seed.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name.
    pub run: String,
    /// Column by column, seed by seed.
    pub values: Vec<Vec<f64>>,
}

/// How many standard errors the mean over the seeds may move: one in 370 does by chance alone.
const STANDARD_ERRORS: f64 = 3.0;

/// Compares the means over seeds with those of `tests/snapshots/NAME.csv`, each within what the committed standard deviation
/// lets two sets of so many drives differ by; or writes that file where the environment variable `UPDATE_SNAPSHOTS` is `figures`.
pub fn check(name: &str, columns: &[Column], lines: &[Line]) {
    let found = lines.iter().map(|line| (line.run.clone(), line.values.iter().map(|values| moments(values)).collect()));
    let found: Vec<(String, Vec<[f64; 2]>)> = found.collect();
    let Some(committed) = committed_or_written("figures", name, &text_of(columns, &found)) else { return };
    let seeds = lines.first().map_or(1, |line| line.values[0].len());
    let mut wrong = String::new();
    assert_eq!(committed.lines().count(), found.len() + 1, "{name}: other runs");
    for (line, (run, figures)) in committed.lines().skip(1).zip(&found) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!((cells[0], cells.len()), (run.as_str(), 1 + 2 * columns.len()), "{name}: other runs");
        let numbers: Vec<f64> = cells[1..].iter().map(|cell| cell.parse().expect("a number")).collect();
        for ((column, expected), &[mean, _]) in columns.iter().zip(numbers.chunks(2)).zip(figures) {
            let allowed = allowed(expected[1], seeds);
            if !holds(column, expected[0], mean, allowed) {
                let (name, expected) = (column.name, expected[0]);
                let _ = writeln!(wrong, "{run}: mean {name} is {mean:.4}, not {expected} +- {allowed:.4}");
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}where this is meant, run again with UPDATE_SNAPSHOTS=figures");
}

/// Compares check sums of runs; writes them where `UPDATE_SNAPSHOTS` is `bits`.
pub fn check_bits(name: &str, sums: &[(String, u64)]) {
    let text = sums.iter().fold(String::from("run,fnv1a\n"), |text, (run, sum)| text + &format!("{run},{sum:016x}\n"));
    let Some(committed) = committed_or_written("bits", name, &text) else { return };
    assert_eq!(
        committed, text,
        "the estimates have other bits; where this is meant, run again with UPDATE_SNAPSHOTS=bits"
    );
}

/// The committed file; none where it was just written. Two words for two kinds: who updates the bits, as every change of the
/// estimator must, does not accept worse figures by the way.
fn committed_or_written(kind: &str, name: &str, text: &str) -> Option<String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("snapshots").join(format!("{name}.csv"));
    let update = std::env::var("UPDATE_SNAPSHOTS").unwrap_or_default();
    assert!(["", "bits", "figures"].contains(&update.as_str()), "UPDATE_SNAPSHOTS is bits or figures, not {update}");
    if update == kind {
        fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        return None;
    }
    Some(fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

/// How far the mean of a second set of so many seeds may be from the first one's.
fn allowed(deviation: f64, seeds: usize) -> f64 {
    STANDARD_ERRORS * deviation * (2.0 / seeds as f64).sqrt()
}

fn holds(column: &Column, expected: f64, mean: f64, allowed: f64) -> bool {
    let differs = if column.is_error { mean - expected } else { (mean - expected).abs() };
    // The file has four digits.
    differs <= allowed + 1e-4
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    [mean, variance.sqrt()]
}

fn text_of(columns: &[Column], lines: &[(String, Vec<[f64; 2]>)]) -> String {
    let header =
        columns.iter().fold(String::from("run"), |text, Column { name, .. }| text + &format!(",{name},{name}_sd"));
    lines.iter().fold(header + "\n", |text, (run, figures)| {
        let cells: String = figures.iter().map(|[mean, deviation]| format!(",{mean:.4},{deviation:.4}")).collect();
        text + run + &cells + "\n"
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERROR: Column = Column { name: "ate_m", is_error: true };
    const FIGURE: Column = Column { name: "path_m", is_error: false };

    #[test]
    fn a_mean_may_move_by_what_chance_moves_it() {
        let allowed = allowed(0.002, 8);
        assert!((allowed - 0.003).abs() < 1e-9);
        assert!(holds(&FIGURE, 0.01, 0.0129, allowed) && holds(&FIGURE, 0.01, 0.0071, allowed));
        assert!(!holds(&FIGURE, 0.01, 0.0132, allowed) && !holds(&FIGURE, 0.01, 0.0068, allowed));
        assert!(!holds(&ERROR, 0.01, 0.0132, allowed) && holds(&ERROR, 0.01, 0.0, allowed));
        assert!(!holds(&ERROR, 0.01, f64::NAN, allowed), "what is no number fails");
    }

    #[test]
    fn moments_are_those_of_the_sample() {
        assert_eq!(moments(&[1.0, 2.0, 3.0]), [2.0, 1.0]);
        assert_eq!(moments(&[4.0]), [4.0, 0.0]);
    }
}
