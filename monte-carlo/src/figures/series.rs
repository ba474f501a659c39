//! One run in figures: its errors over time within the filter's own bounds, and its innovations.

use std::path::{Path, PathBuf};

use super::{FOLDER, Figure, WIDTH, density_panel, slug, write};
use crate::unit::Outcome;
use input_file::FileError;
use lab::recording::Step;
use lab::show::chart::{Axis, Panel, svg};

/// Most points of a curve.
const POINTS: usize = 600;

/// One axis of the pose's error: time, error, two sigmas.
type Errors = Vec<(f64, f64, f64)>;

fn errors(steps: &[Step], axis: usize) -> Errors {
    let stride = steps.len().div_ceil(POINTS).max(1);
    let error = |step: &Step| {
        let error = step.error()?;
        let (error, factor) = match axis {
            0 => (error.x_m, 100.0),
            1 => (error.y_m, 100.0),
            _ => (error.theta_rad, 1f64.to_degrees()),
        };
        Some((step.t_s, factor * error, 2.0 * factor * f64::from(step.covariance[axis][axis]).max(0.0).sqrt()))
    };
    steps.iter().step_by(stride).filter_map(error).collect()
}

fn panel(label: &str, errors: &Errors) -> Panel {
    let x = Axis::linear("time, s", errors.iter().map(|error| error.0));
    let y = Axis::linear(label, errors.iter().flat_map(|(_, error, bound)| [*error, *bound, -*bound]));
    let mut panel = Panel::new(label, x, y, WIDTH, 220.0);
    let band: Vec<(f64, f64, f64)> = errors.iter().map(|(t_s, _, bound)| (*t_s, -bound, *bound)).collect();
    panel.band(&band, 5);
    panel.line(&errors.iter().map(|(t_s, error, _)| (*t_s, *error)).collect::<Vec<_>>(), 1);
    panel
}

/// The figures of one run.
fn figures(outcome: &Outcome) -> [Figure; 2] {
    let key = &outcome.row.key;
    let run = format!("{}, {}, {}, seed {}", key.plan, key.case, key.variant, key.seed);
    let file = format!("{}-{}-{}", slug(&key.plan), slug(&key.case), slug(&key.variant));
    let steps = &outcome.track.steps;
    let panels = ["error of x, cm", "error of y, cm", "error of heading, degrees"];
    let panels = [0, 1, 2].map(|axis| panel(panels[axis], &errors(steps, axis)));
    let legend = [(1, "error in the start frame".to_owned()), (5, "two sigmas of the filter".to_owned())];
    let over_time = Figure {
        name: format!("{file}-errors.svg"),
        caption: format!("{run}: errors over time, with two of the filter's own sigmas."),
        svg: svg(&panels, &legend),
    };
    let innovations = &outcome.track.innovations;
    let stride = innovations.len().div_ceil(1500).max(1);
    let shown: Vec<(f64, f64)> = innovations.iter().copied().step_by(stride).collect();
    let x = Axis::linear("time, s", shown.iter().map(|point| point.0));
    let y = Axis::linear("innovation / sigma", [-4.0, 4.0]);
    let mut scatter = Panel::new("innovations of the readings used", x, y, WIDTH, 240.0);
    scatter.dots(&shown, 1.2, 5);
    let values: Vec<f64> = innovations.iter().map(|point| point.1).collect();
    let density =
        density_panel("their density, and the standard normal one", "innovation / sigma", &values, WIDTH, 240.0);
    [
        over_time,
        Figure {
            name: format!("{file}-innovations.svg"),
            caption: format!("{run}: innovations of the readings used, over their own sigmas."),
            svg: svg(&[scatter, density], &[]),
        },
    ]
}

/// Draws one run into the folder of figures, with each caption beside its figure.
///
/// # Errors
/// A file cannot be written.
pub fn write_series(out: &Path, outcome: &Outcome) -> Result<(), FileError> {
    write_captioned(out, &figures(outcome))
}

fn write_captioned(out: &Path, figures: &[Figure]) -> Result<(), FileError> {
    write(out, figures)?;
    for figure in figures {
        let file = out.join(FOLDER).join(&figure.name).with_extension("txt");
        std::fs::write(&file, &figure.caption).map_err(|cause| FileError::system(&file, "write", &cause))?;
    }
    Ok(())
}

/// The figures of single runs in an output folder, which were drawn while they ran.
///
/// # Errors
/// A file cannot be read.
pub fn read_series(out: &Path) -> Result<Vec<Figure>, FileError> {
    let folder = out.join(FOLDER);
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let entries = std::fs::read_dir(&folder).map_err(|cause| FileError::system(&folder, "read", &cause))?;
    let mut captions: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    captions.retain(|path| path.extension().is_some_and(|extension| extension == "txt"));
    captions.sort();
    let figure = |path: &PathBuf| {
        let file = path.with_extension("svg");
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Figure { name, caption: input_file::read(path)?, svg: input_file::read(&file)? })
    };
    captions.iter().map(figure).collect()
}

/// Puts the figures of single runs that are in one output folder into another one.
///
/// # Errors
/// A file cannot be read or written.
pub fn copy_series(from: &Path, to: &Path) -> Result<(), FileError> {
    write_captioned(to, &read_series(from)?)
}
