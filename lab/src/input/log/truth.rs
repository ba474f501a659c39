//! `truth.csv`: true poses for scoring, and their pairing in time with log rows.

use std::io::Cursor;
use std::path::Path;

use super::csv::{count_cells, names, spelling};
use super::lines::Lines;
use super::{SECONDS, seconds};
use crate::recording::Pose2;
use input_file::FileError;

const COLUMNS: [&str; 4] = ["t_s", "x_m", "y_m", "theta_rad"];

/// Farthest in time that a true pose is still taken for a row's, seconds.
const MAX_GAP_S: f64 = 0.5;

/// True poses with their times, in seconds of the log's clock.
pub type Truth = Vec<(f64, Pose2)>;

/// Reads a truth file.
///
/// # Errors
/// The file cannot be read, or a line is bad.
pub fn read(file: &Path) -> Result<Truth, FileError> {
    parse(Lines::open(file)?, file)
}

/// The truth file whose content is in memory; `file` is what errors call it.
///
/// # Errors
/// A line is bad.
pub fn of_bytes(file: &Path, content: Vec<u8>) -> Result<Truth, FileError> {
    parse(Lines::of(file, Cursor::new(content))?, file)
}

fn parse(mut lines: Lines, file: &Path) -> Result<Truth, FileError> {
    let Some((number, header)) = lines.next_content()? else {
        return Err(FileError::new(file, format!("is empty; its header must name {}", COLUMNS.join(", "))));
    };
    let names = names(&lines, number, &header)?;
    let mut places = [0; 4];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = names.iter().position(|name| *name == column).ok_or_else(|| {
            let hint = spelling(&names, column).map_or(String::new(), |hint| format!("; {hint}"));
            lines.error(number, format!("is missing; the header must name {}{hint}", COLUMNS.join(", "))).at(column)
        })?;
    }
    let mut truth: Truth = Vec::new();
    while let Some((number, line)) = lines.next_content()? {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        count_cells(&cells, names.len()).map_err(|(column, what)| lines.error(number, what).at(column))?;
        let mut values = [0.0f64; 4];
        for ((value, place), column) in values.iter_mut().zip(places).zip(COLUMNS) {
            let cell = cells[place];
            *value =
                cell.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
                    lines.error(number, format!("is {cell:?}; it must be a finite number")).at(column)
                })?;
        }
        if seconds(cells[places[0]]).is_none() {
            return Err(lines.error(number, format!("is {:?}; it must be {SECONDS}", cells[places[0]])).at("t_s"));
        }
        if truth.last().is_some_and(|(last_s, _)| values[0] <= *last_s) {
            return Err(lines.error(number, format!("is {}; times must increase", values[0])).at("t_s"));
        }
        truth.push((values[0], Pose2::new(values[1], values[2], values[3])));
    }
    Ok(truth)
}

/// Why no row got a true pose, if none did.
pub fn without_pairs(times_s: &[f64], truth: &Truth) -> Option<String> {
    let (Some((from_s, _)), Some((to_s, _))) = (truth.first(), truth.last()) else {
        return Some("there is no truth to score against: the truth file has a header but no poses".to_owned());
    };
    let (first_s, last_s) = (times_s.first()?, times_s.last()?);
    pair(times_s, truth).iter().all(Option::is_none).then(|| {
        format!(
            "there is no truth to score against: none of the {} true poses, from {from_s} s to {to_s} s, is within half a second of a \
             row of the log, from {first_s} s to {last_s} s; both must have one clock, in seconds",
            truth.len()
        )
    })
}

/// Gives each row's time the true pose nearest to it, where that row is in turn the one nearest to the pose.
///
/// Nearest both ways: a slow truth must not lend one pose to many rows that the robot passed in between.
pub fn pair(times_s: &[f64], truth: &Truth) -> Vec<Option<Pose2>> {
    let truth_s: Vec<f64> = truth.iter().map(|(t_s, _)| *t_s).collect();
    let row = |t_s: &f64| {
        let index = nearest(&truth_s, *t_s)?;
        let (found_s, pose) = truth[index];
        let back_s = times_s[nearest(times_s, found_s)?];
        // Compared by time, not by index: two rows as near as each other may both have the pose.
        ((found_s - t_s).abs() <= MAX_GAP_S && (back_s - found_s).abs() >= (t_s - found_s).abs()).then_some(pose)
    };
    times_s.iter().map(row).collect()
}

/// Index of the time nearest to `t_s`; `times_s` increase.
fn nearest(times_s: &[f64], t_s: f64) -> Option<usize> {
    let after = times_s.partition_point(|t| *t < t_s);
    match (after.checked_sub(1), times_s.get(after)) {
        (Some(before), Some(next)) if t_s - times_s[before] <= next - t_s => Some(before),
        (_, Some(_)) => Some(after),
        (before, None) => before,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth_at(times_s: &[f64]) -> Truth {
        times_s.iter().map(|t| (*t, Pose2::new(*t, 0.0, 0.0))).collect()
    }

    #[test]
    fn a_slow_truth_is_given_to_the_nearest_row_only() {
        let paired = pair(&[0.0, 0.1, 0.2, 0.3, 0.4], &truth_at(&[0.02, 0.31]));
        let found: Vec<Option<f64>> = paired.iter().map(|p| p.map(|p| p.x_m)).collect();
        assert_eq!(found, [Some(0.02), None, None, Some(0.31), None]);
    }

    #[test]
    fn a_fast_truth_gives_each_row_its_nearest() {
        let times: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
        let paired = pair(&[0.101, 0.506], &truth_at(&times));
        assert_eq!(paired[0].map(|p| p.x_m), Some(0.1));
        assert_eq!(paired[1].map(|p| p.x_m), Some(0.51));
    }

    #[test]
    fn a_truth_from_another_time_is_given_to_no_row() {
        assert_eq!(pair(&[0.0, 0.1], &truth_at(&[7.0, 8.0])), [None, None]);
        assert_eq!(pair(&[0.0], &Vec::new()), [None]);
    }
}
