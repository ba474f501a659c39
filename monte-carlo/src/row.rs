//! One result: what one variant made of one drive.

use std::fmt::Write as _;

/// A figure of one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// Length of the true path, metres.
    Path,
    /// Rooms of the plan that the robot was in.
    RoomsVisited,
    /// Rooms of the plan that it was not in.
    RoomsMissed,
    /// RMSE of position after the best rigid alignment, metres.
    Ate,
    /// RMSE of position in the start frame, metres.
    Start,
    /// RMSE of heading after the alignment's rotation, degrees.
    Heading,
    /// Mean over time of the pose's normalised error squared, three axes.
    Nees,
    /// Share of the time that the robot claims no place, 0 to 1; errors and their normalised values are of the rest.
    Lost,
    /// Mean normalised innovation squared of the readings used.
    Nis,
    /// RMS offset of the mapped walls from the true ones, metres.
    Offset,
    /// Mapped walls that match a true one.
    Matched,
    /// True walls over a metre that were passed within range and are not in the map.
    Missed,
    /// Mapped walls that match no true one.
    Invented,
    /// Readings used.
    Updates,
    /// RMS distance of the readings' end points, placed by the aligned path, from the nearest true wall, at most 0.3 m each.
    EndPoints,
    /// RMSE of position of the whole path as it is known in the end, after the best rigid alignment, metres.
    Back,
    /// Memory of the state in the end, kilobytes of 1024.
    Memory,
    /// Estimator time per step, microseconds of this machine.
    StepCost,
}

impl Metric {
    /// Every metric, in the order of the columns.
    pub const ALL: [Metric; 18] = [
        Self::Path,
        Self::RoomsVisited,
        Self::RoomsMissed,
        Self::Ate,
        Self::Start,
        Self::Heading,
        Self::Nees,
        Self::Lost,
        Self::Nis,
        Self::Offset,
        Self::Matched,
        Self::Missed,
        Self::Invented,
        Self::Updates,
        Self::EndPoints,
        Self::Back,
        Self::Memory,
        Self::StepCost,
    ];

    /// Its column.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Path => "path_m",
            Self::RoomsVisited => "rooms_visited",
            Self::RoomsMissed => "rooms_missed",
            Self::Ate => "ate_m",
            Self::Start => "start_m",
            Self::Heading => "heading_deg",
            Self::Nees => "nees",
            Self::Lost => "lost",
            Self::Nis => "nis",
            Self::Offset => "offset_m",
            Self::Matched => "matched",
            Self::Missed => "missed",
            Self::Invented => "invented",
            Self::Updates => "updates",
            Self::EndPoints => "end_points_m",
            Self::Back => "back_m",
            Self::Memory => "memory_kb",
            Self::StepCost => "step_us",
        }
    }

    /// The metric of this column.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|metric| metric.name() == name)
    }
}

/// Which run a result is of.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RunKey {
    /// The plan, as the experiment file names it.
    pub plan: String,
    /// The case's name.
    pub case: String,
    /// The seed.
    pub seed: u64,
    /// The variant's name.
    pub variant: String,
}

/// One result.
#[derive(Clone, Debug, PartialEq)]
pub struct RunRow {
    /// Which run.
    pub key: RunKey,
    /// The figures, in the order of [`Metric::ALL`]; none where the variant has no such figure.
    pub figures: [Option<f64>; Metric::ALL.len()],
}

impl RunRow {
    /// A row without figures.
    pub fn new(key: RunKey) -> Self {
        Self { key, figures: [None; Metric::ALL.len()] }
    }

    /// A figure.
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.figures[metric as usize]
    }

    /// Sets a figure; what is not finite is no figure.
    pub fn set(&mut self, metric: Metric, value: f64) {
        self.figures[metric as usize] = value.is_finite().then_some(value);
    }

    /// The header of the file of rows.
    pub fn header() -> String {
        Metric::ALL.iter().fold("plan,case,seed,variant".to_owned(), |header, metric| header + "," + metric.name())
    }

    /// One line of that file, without its end.
    pub fn line(&self) -> String {
        let RunKey { plan, case, seed, variant } = &self.key;
        let mut line = format!("{},{},{seed},{}", quoted(plan), quoted(case), quoted(variant));
        for figure in self.figures {
            // Writing to a String cannot fail.
            let _ = match figure {
                Some(value) => write!(line, ",{value}"),
                None => write!(line, ","),
            };
        }
        line
    }

    /// Reads a line; none when it is no row.
    pub fn parse(line: &str) -> Option<Self> {
        let cells = cells(line)?;
        let [plan, case, seed, variant, figures @ ..] = cells.as_slice() else { return None };
        let key = RunKey { plan: plan.clone(), case: case.clone(), seed: seed.parse().ok()?, variant: variant.clone() };
        let mut row = Self::new(key);
        if figures.len() != row.figures.len() {
            return None;
        }
        for (figure, cell) in row.figures.iter_mut().zip(figures) {
            *figure = if cell.is_empty() { None } else { Some(cell.parse().ok()?) };
        }
        Some(row)
    }
}

/// A text as a CSV cell.
pub fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The cells of a CSV line; none where a quote is not closed.
pub fn cells(line: &str) -> Option<Vec<String>> {
    let mut cells = vec![String::new()];
    let mut inside = false;
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        let cell = cells.last_mut()?;
        match letter {
            '"' if inside && letters.peek() == Some(&'"') => {
                cell.push('"');
                letters.next();
            }
            '"' => inside = !inside,
            ',' if !inside => cells.push(String::new()),
            _ => cell.push(letter),
        }
    }
    (!inside).then_some(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_reads_back_as_it_was() {
        let key = RunKey { plan: "a,b".into(), case: "1 \"x\"".into(), seed: 7, variant: "report 3.1, free".into() };
        let mut row = RunRow::new(key);
        row.set(Metric::Ate, 0.1 + 0.2);
        row.set(Metric::Nees, f64::NAN);
        let back = RunRow::parse(&row.line()).expect("a row");
        assert_eq!(back, row);
        assert_eq!(back.get(Metric::Nees), None);
    }

    #[test]
    fn half_a_line_is_no_row() {
        let line = RunRow::new(RunKey { plan: "p".into(), case: "c".into(), seed: 1, variant: "v, w".into() }).line();
        assert!(RunRow::parse(&line).is_some());
        assert!((0..line.len()).all(|end| RunRow::parse(&line[..end]).is_none()));
    }

    #[test]
    fn metrics_index_their_own_columns() {
        assert!(Metric::ALL.iter().enumerate().all(|(i, metric)| *metric as usize == i));
    }
}
