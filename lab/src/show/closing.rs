//! The table that a run or a replay ends with.

use std::fmt::Write as _;

use crate::recording::health::{self, Freeze, Illness};
use crate::recording::{Consistency, PathScore, Recording};

/// The table, for people.
pub fn table(recording: &Recording) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write_paths(&mut text, recording);
    let _ = write_floor(&mut text, recording);
    let _ = write_filter(&mut text, recording);
    let _ = write_looking_back(&mut text, recording);
    let _ = write_calibration(&mut text, recording);
    text
}

fn write_paths(text: &mut String, recording: &Recording) -> std::fmt::Result {
    let figures = &recording.figures;
    writeln!(
        text,
        "{}: {:.1} m in {:.0} s, {} rows",
        recording.title,
        figures.path_m,
        figures.duration_s,
        recording.steps.len()
    )?;
    let (Some(estimate), Some(odometry)) = (&figures.estimate, &figures.odometry) else {
        return writeln!(text, "  no truth to score against");
    };
    writeln!(text, "  {:<34}{:>12}{:>18}", "error against truth", "estimate", "dead reckoning")?;
    let mut row = |name: &str, unit: &str, value: fn(&PathScore) -> Option<f64>| {
        let (Some(ours), Some(theirs)) = (value(estimate), value(odometry)) else { return Ok(()) };
        let (ours, theirs) = (format!("{ours:.3} {unit}"), format!("{theirs:.3} {unit}"));
        writeln!(text, "  {name:<34}{ours:>12}{theirs:>18}")
    };
    row("position, best alignment (RMSE)", "m", |score| Some(score.ate_m))?;
    row("position, start frame (RMSE)", "m", |score| score.start_m)?;
    row("heading (RMSE)", "deg", |score| Some(score.heading_deg))?;
    match estimate.nees {
        Some(nees) => writeln!(text, "  {:<34}{nees:>12.2}   3 is ideal", "pose NEES (mean)"),
        None => Ok(()),
    }
}

fn write_floor(text: &mut String, recording: &Recording) -> std::fmt::Result {
    let Some(floor) = &recording.figures.floor else { return Ok(()) };
    let swept = format!("{:.1} %", 100.0 * floor.swept);
    writeln!(text, "  {:<34}{swept:>12}   of {:.1} m2 that it can reach", "floor swept", floor.floor_m2)?;
    let overlap = format!("{:.2} x", floor.overlap);
    writeln!(text, "  {:<34}{overlap:>12}   {:.1} % twice or more", "path over swept floor", 100.0 * floor.twice)?;
    let hole = format!("{:.3} m2", floor.largest_hole_m2);
    writeln!(text, "  {:<34}{hole:>12}   {} bumps", "largest piece missed", floor.bumps)?;
    let home = format!("{:.3} m", floor.home_m);
    writeln!(text, "  {:<34}{home:>12}", "end of the drive from its start")?;
    let time = floor.time.iter().map(|(name, sum_s)| format!("{name} {sum_s:.0} s")).collect::<Vec<_>>().join(", ");
    writeln!(text, "  time: {time}")
}

fn write_filter(text: &mut String, recording: &Recording) -> std::fmt::Result {
    let figures = &recording.figures;
    if let Some(nis) = figures.mean_nis {
        write!(text, "  {:<34}{nis:>12.2}   1 is ideal", "innovations NIS (mean)")?;
        if let (Some(associated), Some(share)) = (figures.nis_associated, figures.outside_gate) {
            write!(text, "; {associated:.2} before the gate, {:.1} % outside it", 100.0 * share)?;
        }
        writeln!(text)?;
    }
    if let Some(from_s) = recording.stuck_from_s {
        writeln!(
            text,
            "  {:<34}{:>12}   it cannot get away from where it is",
            "pilot stuck from",
            format!("{from_s:.1} s")
        )?;
    }
    for Illness { health, begin_s, end_s } in recording.illnesses() {
        let end = end_s.map_or("the end".to_owned(), |end_s| format!("{end_s:.1} s"));
        writeln!(text, "  {:<34}{:>12}   from {begin_s:.1} s to {end}", "estimator not well", health::name(health))?;
    }
    for Freeze { sensor, begin_s, end_s, .. } in recording.freezes() {
        let end = end_s.map_or("the end".to_owned(), |end_s| format!("{end_s:.1} s"));
        let name = recording.sensors.get(sensor).map_or("", |sensor| sensor.name.as_str());
        let what = "its output stays the same, whatever the robot does";
        writeln!(text, "  {:<34}{name:>12}   from {begin_s:.1} s to {end}: {what}", "sensor frozen")?;
    }
    if figures.lost > 0.0 {
        let share = format!("{:.1} %", 100.0 * figures.lost);
        writeln!(text, "  {:<34}{share:>12}   of the rows, which no error counts", "place not known")?;
    }
    writeln!(text, "  {:<34}{:>12}", "walls in the map", figures.walls)?;
    if let Some(map) = &figures.map {
        let offset = map.offset_m.map_or_else(|| "-".to_owned(), |offset_m| format!("{offset_m:.3} m"));
        writeln!(text, "  {:<34}{offset:>12}   {} of them true walls", "wall offsets (RMS)", map.matched)?;
        writeln!(text, "  {:<34}{:>12}   passed, longer than 1 m", "walls missed", map.missed)?;
        writeln!(text, "  {:<34}{:>12}", "walls invented", map.invented)?;
    }
    if let Some(score) = &figures.consistency {
        let (ours, theirs) =
            (format!("{:.2} nats", score.entropy_nats), format!("{:.2} nats", score.odometry_entropy_nats));
        writeln!(text, "  {:<34}{ours:>12}{theirs:>18}   less is sharper", "map entropy: estimate, odometry")?;
        write_visits(text, score)?;
    }
    writeln!(text, "  {:<34}{:>12}   {} unexplained", "readings used", figures.updates, figures.outliers)?;
    if figures.estimator_s > 0.0 && figures.duration_s > 0.0 {
        let speed = format!("{:.0} x", figures.duration_s / figures.estimator_s);
        writeln!(text, "  {:<34}{speed:>12}   real time, estimator alone", "speed")?;
    }
    Ok(())
}

fn write_looking_back(text: &mut String, recording: &Recording) -> std::fmt::Result {
    let Some(back) = &recording.figures.looking_back else { return Ok(()) };
    writeln!(text, "  looking back, with all of the log")?;
    if let Some(score) = &back.estimate {
        writeln!(text, "  {:<34}{:>12}", "position, best alignment (RMSE)", format!("{:.3} m", score.ate_m))?;
    }
    let Some(score) = &back.consistency else { return Ok(()) };
    writeln!(text, "  {:<34}{:>12}", "map entropy", format!("{:.2} nats", score.entropy_nats))?;
    if let Some(gap_m) = score.widest_gap_m {
        writeln!(text, "  {:<34}{:>12}", "widest gap between two visits", format!("{gap_m:.3} m"))?;
    }
    if let Some(surfels) = &score.surfels {
        writeln!(text, "  {:<34}{:>12}", "visits apart", format!("{:.3} m", surfels.median_m))?;
    }
    Ok(())
}

fn write_visits(text: &mut String, score: &Consistency) -> std::fmt::Result {
    let metres = |value: f64| format!("{value:.3} m");
    if let Some(gap_m) = score.widest_gap_m.map(metres) {
        let name = "widest gap between two visits";
        writeln!(text, "  {name:<34}{gap_m:>12}   of {} walls seen again", score.revisited)?;
    }
    if let (Some(ours), Some(theirs)) = (&score.surfels, &score.odometry_surfels) {
        let (ours, theirs) = (metres(ours.median_m), metres(theirs.median_m));
        writeln!(text, "  {:<34}{ours:>12}{theirs:>18}", "visits apart: ours, odometry")?;
    }
    if let (Some(ours), Some(theirs)) = (score.closure_m.map(metres), score.odometry_closure_m.map(metres)) {
        writeln!(text, "  {:<34}{ours:>12}{theirs:>18}", "first visit to last: ours, odometry")?;
    }
    Ok(())
}

fn write_calibration(text: &mut String, recording: &Recording) -> std::fmt::Result {
    let Some(last) = recording.calibration.last() else { return Ok(()) };
    let estimated: Vec<_> =
        recording.parameters.iter().zip(&last.values).filter(|(_, (_, sigma))| *sigma > 0.0).collect();
    if estimated.is_empty() {
        return Ok(());
    }
    writeln!(text, "  {:<34}{:>12}{:>10}{:>10}", "calibration", "found", "sigma", "true")?;
    for (parameter, (estimate, sigma)) in estimated {
        let truth = parameter.truth.map_or("-".to_owned(), |truth| format!("{truth:.4}"));
        writeln!(text, "  {:<34}{estimate:>12.4}{sigma:>10.4}{truth:>10}", parameter.name)?;
    }
    if let Some((latency_s, sigma_s)) = recording.figures.latency_s {
        let [found, sigma] = [latency_s, sigma_s].map(|seconds| format!("{:.1} ms", 1e3 * seconds));
        writeln!(text, "  {:<34}{found:>12}{sigma:>10}{:>10}", "latency", "-")?;
    }
    Ok(())
}
