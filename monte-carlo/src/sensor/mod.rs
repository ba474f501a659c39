//! `lab experiment sensor`: a real analogue range sensor's log against the sensor model, range = a volts^b.

pub mod fit;
mod log;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;

use crate::figures::{self, Figure, density_panel};
use fit::{Fit, Reading};
use input_file::FileError;
use lab::evaluate::statistics::{median, quantile};
use lab::show::chart::{Axis, Panel, svg};

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 300.0;

/// What the table begins with.
const HEAD: &str = "| figure | value |\n|---|---|\n";

/// Most points of a figure.
const POINTS: usize = 1500;

/// Lags that are tried, in steps of a hundredth of a second.
const LAGS: i32 = 40;

/// Fit the sensor model to a log of volts against true ranges.
#[derive(Debug, Args)]
pub struct SensorArgs {
    /// CSV file with a header.
    log: PathBuf,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "out/sensor")]
    out: PathBuf,
    /// Column of the time, seconds.
    #[arg(long, value_name = "COLUMN", default_value = "time")]
    time: String,
    /// Column of the true range, metres.
    #[arg(long, value_name = "COLUMN", default_value = "range")]
    range: String,
    /// Column of the output, volts.
    #[arg(long, value_name = "COLUMN")]
    volts: String,
    /// Shortest range that the model is fitted to, metres.
    #[arg(long, value_name = "M", default_value_t = 0.15)]
    min: f64,
    /// Longest range that the model is fitted to, metres.
    #[arg(long, value_name = "M", default_value_t = 0.7)]
    max: f64,
    /// From here on the output is taken for the far-wall floor, metres.
    #[arg(long, value_name = "M", default_value_t = 1.0)]
    floor: f64,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
struct Found {
    fit: Fit,
    residuals_v: Vec<f64>,
    /// 1-sigma by the median absolute residual, volts.
    sigma_v: f64,
    /// Shares of the residuals beyond three and five of these.
    tails: [f64; 2],
    /// Correlation of one reading's residual with the next one's.
    correlation: f64,
    /// (lag, RMS residual): seconds, volts.
    lags: Vec<(f64, f64)>,
    /// 10 %, median and 90 % of the output beyond the floor's beginning, volts.
    floor_v: Option<[f64; 3]>,
}

impl SensorArgs {
    /// Fits, and writes figures and a table.
    ///
    /// # Errors
    /// The log cannot be used, or a file cannot be written.
    pub fn run(&self) -> Result<(), FileError> {
        let file = self.out.join("sensor.md");
        if !std::fs::read(&file).map_or(true, |present| present.is_empty() || present.starts_with(HEAD.as_bytes())) {
            return Err(FileError::new(
                &file,
                "is no table of this command and would be lost; name another --out folder",
            ));
        }
        let (readings, left_out) = log::read(&self.log, [&self.time, &self.range, &self.volts])?;
        let found = self.find(&readings)?;
        figures::write(&self.out, &self.figures(&readings, &found))?;
        let text = self.table(readings.len(), left_out, &found);
        std::fs::write(&file, &text).map_err(|cause| FileError::system(&file, "write", &cause))?;
        let _ = writeln!(std::io::stdout(), "{text}results in {}", self.out.display());
        Ok(())
    }

    fn find(&self, readings: &[Reading]) -> Result<Found, FileError> {
        let near = |reading: &&Reading| (self.min..=self.max).contains(&reading.range_m);
        let fitted: Vec<Reading> = readings.iter().filter(near).copied().collect();
        let fit = Fit::of(&fitted).ok_or_else(|| {
            let message = format!("has too few readings from {} to {} m to fit a curve to", self.min, self.max);
            FileError::new(&self.log, message)
        })?;
        let residuals_v: Vec<f64> = fitted.iter().map(|reading| fit.residual_v(reading)).collect();
        let sizes: Vec<f64> = residuals_v.iter().map(|residual| residual.abs()).collect();
        let sigma_v = fit::SIGMA_PER_MAD * median(&sizes).unwrap_or(0.0);
        let beyond = |sigmas: f64| {
            sizes.iter().filter(|size| **size > sigmas * sigma_v).count() as f64 / sizes.len().max(1) as f64
        };
        let floor: Vec<f64> = readings.iter().filter(|r| r.range_m >= self.floor).map(|r| r.volts).collect();
        let quantiles = [0.1, 0.5, 0.9].map(|share| quantile(&floor, share));
        Ok(Found {
            tails: [beyond(3.0), beyond(5.0)],
            correlation: fit::correlation(&residuals_v),
            lags: (0..=LAGS)
                .map(|i| 0.01 * f64::from(i))
                .filter_map(|lag_s| Some((lag_s, fit::lagged_rms_v(&fit, readings, self.min..=self.max, lag_s)?)))
                .collect(),
            floor_v: if let [Some(low), Some(middle), Some(high)] = quantiles {
                Some([low, middle, high])
            } else {
                None
            },
            fit,
            residuals_v,
            sigma_v,
        })
    }

    fn table(&self, readings: usize, left_out: usize, found: &Found) -> String {
        let Found { fit, sigma_v, tails, correlation, lags, floor_v, residuals_v } = found;
        let best = lags.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let mut text = HEAD.to_owned();
        let mut put = |name: &str, value: String| {
            let _ = writeln!(text, "| {name} | {value} |");
        };
        put("readings", format!("{readings}, of which {} from {} to {} m", residuals_v.len(), self.min, self.max));
        if left_out > 0 {
            put("left out", format!("{left_out} lines without a time, or a range and an output above 0"));
        }
        put("range", format!("{:.4} m x volts^{:.3}", fit.scale_m, fit.exponent));
        put("noise, 1-sigma", format!("{:.1} mV", 1000.0 * sigma_v));
        put("beyond 3 sigma", format!("{:.2} % (normal: 0.27 %)", 100.0 * tails[0]));
        put("beyond 5 sigma", format!("{:.2} % (normal: 0.00006 %)", 100.0 * tails[1]));
        put("correlation of neighbours", format!("{correlation:.3}"));
        if let (Some((lag_s, rms_v)), Some(none)) = (best, lags.first()) {
            put("best lag", format!("{lag_s:.2} s: {:.1} mV, without {:.1} mV", 1000.0 * rms_v, 1000.0 * none.1));
        }
        if let Some([low, middle, high]) = floor_v {
            put(&format!("output from {} m on", self.floor), format!("{middle:.3} V (80 %: {low:.3} to {high:.3} V)"));
        }
        text
    }

    fn figures(&self, readings: &[Reading], found: &Found) -> Vec<Figure> {
        let stride = readings.len().div_ceil(POINTS).max(1);
        let some = || readings.iter().step_by(stride);
        let far_m = readings.iter().map(|reading| reading.range_m).fold(0.0, f64::max);
        let curve: Vec<(f64, f64)> = (1..=200)
            .map(|i| self.min + (far_m - self.min) * f64::from(i) / 200.0)
            .map(|m| (m, found.fit.volts(m)))
            .collect();
        let ranges = || readings.iter().map(|reading| reading.range_m);
        let volts = Axis::linear("output, V", readings.iter().map(|reading| reading.volts));
        let mut law =
            Panel::new("output and fitted curve", Axis::linear("true range, m", ranges()), volts, WIDTH, HEIGHT);
        law.dots(&some().map(|reading| (reading.range_m, reading.volts)).collect::<Vec<_>>(), 1.2, 5);
        law.line(&curve, 1);
        let residual = |reading: &Reading| (reading.range_m, 1000.0 * found.fit.residual_v(reading));
        let near = || readings.iter().filter(|reading| (self.min..=self.max).contains(&reading.range_m)).map(residual);
        let across = Axis::linear("residual, mV", near().map(|point| point.1));
        let along = Axis::linear("true range, m", near().map(|point| point.0));
        let mut rest = Panel::new("residuals where the curve was fitted", along, across, WIDTH, HEIGHT);
        rest.dots(&near().collect::<Vec<_>>(), 1.2, 5);
        let normalised: Vec<f64> = found.residuals_v.iter().map(|residual| residual / found.sigma_v).collect();
        let density =
            density_panel("their density, and the standard normal one", "residual / sigma", &normalised, WIDTH, HEIGHT);
        let lags: Vec<(f64, f64)> = found.lags.iter().map(|(lag_s, rms_v)| (*lag_s, 1000.0 * rms_v)).collect();
        let delay = Axis::linear("assumed lag, s", lags.iter().map(|point| point.0));
        let rms = Axis::linear("RMS residual, mV", lags.iter().map(|point| point.1));
        let mut lag = Panel::new("residual against assumed lag", delay, rms, WIDTH, HEIGHT);
        lag.line(&lags, 5);
        let figure = |name: &str, caption: &str, panels: &[Panel]| Figure {
            name: format!("sensor-{name}.svg"),
            caption: caption.to_owned(),
            svg: svg(panels, &[]),
        };
        vec![
            figure("curve", "A real sensor's output against the true range, with the fitted curve.", &[law]),
            figure("residuals", "Residuals of the fitted curve, and their density.", &[rest, density]),
            figure("lag", "RMS residual against an assumed lag of the output behind the range.", &[lag]),
        ]
    }
}
