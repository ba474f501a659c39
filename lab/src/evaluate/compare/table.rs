//! The comparison as a table for people.

use std::fmt::Write as _;

use super::Comparison;
use super::scores::{Row, Unit};

/// The whole text.
pub fn text(comparison: &Comparison) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut text, comparison);
    text
}

fn write(text: &mut String, comparison: &Comparison) -> std::fmt::Result {
    for (name, summary) in [("A", &comparison.a), ("B", &comparison.b)] {
        writeln!(text, "{name}: {} ({})", summary.folder.display(), summary.title())?;
    }
    for warning in &comparison.warnings {
        writeln!(text, "warning: {warning}")?;
    }
    for (name, a, b) in comparison.a.settings_changed(&comparison.b) {
        writeln!(text, "setting {name}: {a} in A, {b} in B")?;
    }
    writeln!(text, "{:<38}{:>12}{:>12}{:>12}  better", "", "A", "B", "B - A")?;
    let mut group = "";
    for row in &comparison.rows {
        if row.group != group {
            group = row.group;
            writeln!(text, "{group}")?;
        }
        write_row(text, row)?;
    }
    Ok(())
}

fn write_row(text: &mut String, row: &Row) -> std::fmt::Result {
    let cell = |value: Option<f64>| value.map_or("-".to_owned(), |value| number(value, row.unit));
    let difference = row.difference().map_or(String::new(), |value| match number(value, row.unit) {
        text if value > 0.0 && text.contains(|c| matches!(c, '1'..='9')) => format!("+{text}"),
        text => text,
    });
    // What the table rounds away is no difference to its reader.
    let better = match row.winner() {
        Some("a") if cell(row.a) != cell(row.b) => "  A",
        Some("b") if cell(row.a) != cell(row.b) => "  B",
        Some(_) => "  same",
        None => "",
    };
    writeln!(text, "  {:<36}{:>12}{:>12}{difference:>12}{better}", row.label, cell(row.a), cell(row.b))
}

fn number(value: f64, unit: Unit) -> String {
    let text = match unit {
        Unit::Metres => format!("{value:.3} m"),
        Unit::Degrees => format!("{value:.2} deg"),
        Unit::Nats => format!("{value:.2} nats"),
        Unit::Share => format!("{:.1} %", 100.0 * value),
        Unit::Plain => format!("{value:.3}"),
        Unit::Count => format!("{value}"),
    };
    // A difference that rounds to nothing has no sign.
    match text.strip_prefix('-') {
        Some(rest) if !rest.contains(|c| matches!(c, '1'..='9')) => rest.to_owned(),
        _ => text,
    }
}
