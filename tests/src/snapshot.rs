//! Figures of runs beside committed ones.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

/// How far a figure may be from the committed one.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name.
    pub name: &'static str,
    /// Largest difference, in the figure's own unit.
    pub absolute: f64,
    /// Largest difference as a share of the committed figure; the wider of the two counts.
    pub relative: f64,
    /// Whether the figure is an error, which may shrink as much as it likes.
    pub is_error: bool,
}

/// Compares rows of figures with those of `tests/snapshots/NAME.csv`, or writes that file where the environment variable
/// `UPDATE_SNAPSHOTS` is set.
pub fn check(name: &str, columns: &[Column], rows: &[(String, Vec<f64>)]) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("snapshots").join(format!("{name}.csv"));
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, text_of(columns, rows)).expect("the snapshot is written");
        return;
    }
    let committed = fs::read_to_string(&path).expect("the snapshot is there");
    let mut wrong = String::new();
    assert_eq!(committed.lines().count(), rows.len() + 1, "{}: other runs", path.display());
    for (line, (run, figures)) in committed.lines().skip(1).zip(rows) {
        let mut cells = line.split(',');
        assert_eq!(cells.next(), Some(run.as_str()), "{}: other runs", path.display());
        for ((column, cell), found) in columns.iter().zip(cells).zip(figures) {
            let expected: f64 = cell.parse().expect("a number");
            let allowed = column.absolute.max(column.relative * expected.abs());
            let differs = if column.is_error { found - expected } else { (found - expected).abs() };
            if differs > allowed || found.is_nan() != expected.is_nan() {
                let _ = writeln!(wrong, "{run}: {} is {found:.4}, not {expected} +- {allowed:.4}", column.name);
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}where this is meant, run again with UPDATE_SNAPSHOTS=1");
}

fn text_of(columns: &[Column], rows: &[(String, Vec<f64>)]) -> String {
    let mut text = String::from("run");
    for column in columns {
        let _ = write!(text, ",{}", column.name);
    }
    for (run, figures) in rows {
        let _ = write!(text, "\n{run}");
        for figure in figures {
            let _ = write!(text, ",{:.4}", figure);
        }
    }
    text + "\n"
}
