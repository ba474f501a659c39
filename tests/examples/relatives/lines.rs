//! Two more ways from points to lines, for the comparison of extractors: the probabilistic Hough transform after Stephens 1991, and
//! clusters of near points after Ester and others 1996, of each of which a line is fitted. The numbers are ours.

use nalgebra::Matrix2;
use relatives::fit::{Fit, fit};
use relatives::geometry::{Line, Point, unit, wrap};
use relatives::window::{Seen, Window};

/// Share of the points that a line has, and the density of the others across it, per metre: within 3 m.
const SHARE: f64 = 0.3;
const OTHERS: f64 = 1.0 / 3.0;
/// A line must be likelier than none by this, nats: two numbers are chosen among some thousand cells.
const EVIDENCE: f64 = 12.0;
/// Cells: directions in a full turn, and width in metres.
const ANGLES: usize = 180;
const WIDTH: f64 = 0.02;
const REACH: f64 = 3.0;
/// Steps from the best cell uphill.
const STEPS: usize = 6;
/// Least sigma of a point, metres, and least cosine of its incidence.
const LEAST: f64 = 0.01;
const GRAZING: f64 = 0.15;

/// How much likelier a point is with a line than without, and the probability that it is of the line.
fn likeness(seen: &Seen, line: &Line) -> (f64, f64) {
    let n = unit(line.a);
    if unit(seen.bearing).dot(&n) < GRAZING {
        return ((1.0 - SHARE).ln(), 0.0);
    }
    let variance = (n.transpose() * seen.covariance() * n)[(0, 0)].max(LEAST * LEAST);
    let off = line.beyond(seen.at);
    let density = (-0.5 * off * off / variance).exp() / (std::f64::consts::TAU * variance).sqrt();
    let (own, other) = (SHARE * density / OTHERS, 1.0 - SHARE);
    ((own + other).ln(), own / (own + other))
}

/// Lines by the likelihood of all points at once: the best cell, uphill from there, its points taken out, and so on.
pub fn probabilistic(window: &Window) -> Vec<Fit> {
    let mut left: Vec<usize> = (0..window.points.len()).collect();
    let mut found = Vec::new();
    loop {
        let points: Vec<&Seen> = left.iter().map(|i| &window.points[*i]).collect();
        let gain = |line: &Line| points.iter().map(|seen| likeness(seen, line).0).sum::<f64>();
        let cells = candidates(&points).into_iter().map(|line| (gain(&line), line));
        let Some((_, mut line)) = cells.max_by(|a, b| a.0.total_cmp(&b.0)) else { return found };
        for _ in 0..STEPS {
            line = weighted(&points, |seen| likeness(seen, &line).1).unwrap_or(line);
        }
        let own: Vec<usize> = left.iter().copied().filter(|i| likeness(&window.points[*i], &line).1 > 0.5).collect();
        if gain(&line) < EVIDENCE || own.len() < 3 {
            return found;
        }
        left.retain(|i| !own.contains(i));
        found.push(fit(window, &own));
    }
}

/// The cells with the most points of each direction: the others cannot be the likeliest.
fn candidates(points: &[&Seen]) -> Vec<Line> {
    let direction = |i: usize| wrap(std::f64::consts::TAU * i as f64 / ANGLES as f64);
    let fullest = |a: f64| {
        let mut cells = vec![0; (REACH / WIDTH) as usize];
        for rho in points.iter().map(|seen| seen.at.dot(&unit(a))).filter(|rho| (0.0..REACH - WIDTH).contains(rho)) {
            cells[(rho / WIDTH) as usize] += 1;
        }
        let best = cells.iter().enumerate().max_by_key(|cell| cell.1).filter(|cell| *cell.1 > 2);
        best.map(|(cell, _)| Line { rho: (cell as f64 + 0.5) * WIDTH, a })
    };
    (0..ANGLES).filter_map(|i| fullest(direction(i))).collect()
}

/// The line with the least weighted sum of squared distances.
fn weighted(points: &[&Seen], weight: impl Fn(&Seen) -> f64) -> Option<Line> {
    let all = || points.iter().map(|seen| (weight(seen), seen.at));
    let sum: f64 = all().map(|(w, _)| w).sum();
    let mean = all().fold(Point::zeros(), |mean, (w, at)| mean + at * (w / sum));
    let scatter = all().fold(Matrix2::zeros(), |s, (w, at)| s + (at - mean) * (at - mean).transpose() * w);
    let a = 0.5 * (-2.0 * scatter[(0, 1)]).atan2(scatter[(1, 1)] - scatter[(0, 0)]);
    (sum > 1.0).then(|| Line { rho: mean.dot(&unit(a)), a }.facing())
}

/// Neighbours are within this, metres, and a point with so many of them is inside a cluster.
const NEIGHBOURS: (f64, usize) = (0.1, 5);
/// A cluster is a line where its points lie as near to it, RMS metres.
const FLAT: f64 = 0.05;

/// Clusters of points, each as one line.
pub fn clusters(window: &Window) -> Vec<Fit> {
    let n = window.points.len();
    let near = |i: usize| -> Vec<usize> {
        (0..n).filter(|j| (window.points[i].at - window.points[*j].at).norm() < NEIGHBOURS.0).collect()
    };
    let mut is_taken = vec![false; n];
    let mut found = Vec::new();
    for first in 0..n {
        let mut own = Vec::new();
        let mut open = vec![first];
        while let Some(i) = open.pop() {
            let around = if is_taken[i] { Vec::new() } else { near(i) };
            if around.len() >= NEIGHBOURS.1 || (!is_taken[i] && !own.is_empty()) {
                is_taken[i] = true;
                own.push(i);
            }
            if around.len() >= NEIGHBOURS.1 {
                open.extend(around.into_iter().filter(|j| !is_taken[*j]));
            }
        }
        if own.len() > NEIGHBOURS.1 {
            found.push(fit(window, &own));
        }
    }
    found.retain(|fit| fit.rms <= FLAT);
    found
}
