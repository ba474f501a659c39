//! A sensor's log: columns of a CSV file by name.

use std::path::Path;

use super::fit::Reading;
use input_file::FileError;

/// Reads time, range and volts, and how many lines were left out: those where one is empty or no number, or range or volts are not above zero.
pub fn read(file: &Path, columns: [&str; 3]) -> Result<(Vec<Reading>, usize), FileError> {
    let text = input_file::read(file)?;
    // Spreadsheets put a byte order mark before the header.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut lines = text.lines().enumerate();
    let header: Vec<&str> = lines.next().map_or_else(Vec::new, |(_, line)| line.split(',').map(str::trim).collect());
    let mut places = [0; 3];
    for (place, column) in places.iter_mut().zip(columns) {
        *place = header.iter().position(|name| *name == column).ok_or_else(|| {
            let message = format!("is not in the header; there are {}", header.join(", "));
            FileError::new(file, message).at_line(1).at(column)
        })?;
    }
    let (mut readings, mut left_out) = (Vec::new(), 0);
    for (i, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != header.len() {
            let message = format!("there are {}; the header names {}", cells.len(), header.len());
            return Err(FileError::new(file, message).at_line(i + 1).at("columns"));
        }
        let mut numbers = [0.0_f64; 3];
        for ((number, place), column) in numbers.iter_mut().zip(&places).zip(columns) {
            let cell = cells[*place].trim();
            *number = if cell.is_empty() { "nan" } else { cell }.parse().map_err(|_| {
                FileError::new(file, format!("is {cell:?}; it must be a number")).at_line(i + 1).at(column)
            })?;
        }
        let [time_s, range_m, volts] = numbers;
        if time_s.is_finite() && range_m > 0.0 && volts > 0.0 {
            readings.push(Reading { time_s, range_m, volts });
        } else {
            left_out += 1;
        }
    }
    Ok((readings, left_out))
}
