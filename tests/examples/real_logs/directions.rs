//! Where the readings of each mapped wall lie by the true path: whether they are of one wall, and how that wall runs.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use lab::recording::{Pose2, Recording};
use slam_core::Outcome;

use super::Case;

/// Points this near to a line are on it, metres.
const ON_M: f64 = 0.07;

/// Points this far from it were given to the wrong wall, metres.
const OFF_M: f64 = 0.15;

/// A wall with fewer readings has no line worth fitting.
const READINGS: usize = 15;

/// Shorter walls have no direction worth comparing, metres.
const LONG_M: f64 = 1.5;

/// The table, of the logs with a truth.
pub fn write(text: &mut String, defaults: &[(Vec<Recording>, Case)]) -> std::fmt::Result {
    writeln!(
        text,
        "## Mapped walls by the true path\n\n\
         The used readings of each wall, placed by the true path: how many lie more than 15 cm off the wall's line, and of\n\
         the others of walls longer than 1.5 m how far across it (RMS), and how far the lines' directions are from the grid\n\
         that fits them best.\n\n\
         | log | used readings | off their wall | walls over 1.5 m | across | directions, standard deviation | over 1° | \
         over 2° |\n|{}",
        "---|".repeat(8)
    )?;
    for (recordings, case) in defaults {
        let Some(recording) = recordings.first().filter(|recording| recording.figures.estimate.is_some()) else {
            continue;
        };
        writeln!(text, "| {} | {} |", case.title, cells(recording).join(" | "))?;
    }
    writeln!(text)
}

fn cells(recording: &Recording) -> [String; 7] {
    let walls: Vec<Line> = points_by_wall(recording).values().filter_map(|points| Line::through(points)).collect();
    let readings: usize = walls.iter().map(|line| line.readings).sum();
    let off: usize = walls.iter().map(|line| line.off).sum();
    let long: Vec<&Line> = walls.iter().filter(|line| line.length_m > LONG_M).collect();
    let n = long.len().max(1) as f64;
    let across_m = (long.iter().map(|line| line.across_m2).sum::<f64>() / n).sqrt();
    let turned_deg: Vec<f64> = off_grid_rad(&long).iter().map(|angle_rad| angle_rad.to_degrees()).collect();
    let spread_deg = (turned_deg.iter().map(|angle| angle * angle).sum::<f64>() / n).sqrt();
    let over = |limit: f64| 100.0 * turned_deg.iter().filter(|angle| angle.abs() > limit).count() as f64 / n;
    [
        format!("{readings}"),
        format!("{off}"),
        format!("{}", long.len()),
        format!("{:.1} cm", 100.0 * across_m),
        format!("{spread_deg:.1}°"),
        format!("{:.0} %", over(1.0)),
        format!("{:.0} %", over(2.0)),
    ]
}

/// The used readings' end points by the true path, wall by wall.
fn points_by_wall(recording: &Recording) -> BTreeMap<u16, Vec<[f64; 2]>> {
    let mut points: BTreeMap<u16, Vec<[f64; 2]>> = BTreeMap::new();
    for (i, step) in recording.steps.iter().enumerate() {
        let Some(truth) = step.truth else { continue };
        for reading in recording.readings(i) {
            let (Outcome::Updated { wall, .. }, Some(hit_m)) = (reading.outcome, reading.hit_m) else { continue };
            let [x_m, y_m] = hit_m.map(f64::from);
            let seen = step.pose.relative(&Pose2::new(x_m, y_m, 0.0));
            points.entry(wall).or_default().push(truth.transform([seen.x_m, seen.y_m]));
        }
    }
    points
}

/// The line that most points of a wall lie on.
struct Line {
    readings: usize,
    off: usize,
    length_m: f64,
    /// Mean square of the distance from the line of the points on it, m^2.
    across_m2: f64,
    direction_rad: f64,
}

impl Line {
    /// None for few points.
    fn through(points: &[[f64; 2]]) -> Option<Self> {
        let n = points.len();
        if n < READINGS {
            return None;
        }
        // Every point with a few partners across the list: the pair whose line has the most points on it.
        let pairs = (0..n).flat_map(|i| [n / 2, n / 3, n / 5].map(|apart| (points[i], points[(i + apart) % n])));
        let on = |pair: &([f64; 2], [f64; 2])| points.iter().filter(|point| aside_m(pair, point).abs() < ON_M).count();
        let best = pairs.filter(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]) > 0.3).max_by_key(on)?;
        let own: Vec<&[f64; 2]> = points.iter().filter(|point| aside_m(&best, point).abs() < ON_M).collect();
        let count = own.len() as f64;
        let centre = [0, 1].map(|axis| own.iter().map(|point| point[axis]).sum::<f64>() / count);
        let moment = |a: usize, b: usize| {
            own.iter().map(|point| (point[a] - centre[a]) * (point[b] - centre[b])).sum::<f64>() / count
        };
        let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
        let direction_rad = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (s, c) = direction_rad.sin_cos();
        let along = own.iter().map(|point| c * point[0] + s * point[1]);
        let (lo, hi) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), value| (lo.min(value), hi.max(value)));
        let ahead = [centre[0] + c, centre[1] + s];
        Some(Self {
            readings: n,
            off: points.iter().filter(|point| aside_m(&(centre, ahead), point).abs() > OFF_M).count(),
            length_m: hi - lo,
            across_m2: 0.5 * (xx + yy) - (0.5 * (xx - yy)).hypot(xy),
            direction_rad,
        })
    }
}

/// Distance of a point to the left of the line through two others, metres.
fn aside_m((a, b): &([f64; 2], [f64; 2]), point: &[f64; 2]) -> f64 {
    let edge = [b[0] - a[0], b[1] - a[1]];
    (edge[0] * (point[1] - a[1]) - edge[1] * (point[0] - a[0])) / edge[0].hypot(edge[1])
}

/// How far each line's direction is from the grid that fits them all best, radians: the mean of four times the angle.
fn off_grid_rad(lines: &[&Line]) -> Vec<f64> {
    let sum = |part: fn(f64) -> f64| lines.iter().map(|line| part(4.0 * line.direction_rad)).sum::<f64>();
    let grid_rad = 0.25 * sum(f64::sin).atan2(sum(f64::cos));
    let turned =
        |line: &&Line| (line.direction_rad - grid_rad + 0.5 * FRAC_PI_2).rem_euclid(FRAC_PI_2) - 0.5 * FRAC_PI_2;
    lines.iter().map(turned).collect()
}
