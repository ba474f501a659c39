//! The Hough transform over the points of a window: plain, weighted, and constrained to some directions.

use crate::fit::{Fit, fit};
use crate::geometry::{Line, unit, wrap};
use crate::window::{Seen, Window};

/// Cells and peaks.
#[derive(Clone, Copy, Debug)]
pub struct Hough {
    /// Directions in a full turn.
    pub angles: usize,
    /// Width of a cell across, metres.
    pub width: f64,
    /// Largest distance of a line, metres.
    pub reach: f64,
    /// Least votes of a peak.
    pub votes: f64,
    /// Points this near to a peak's line are its, metres.
    pub inlier: f64,
    /// Points along it farther apart than this are of two lines, metres.
    pub gap: f64,
}

/// A beam that meets a wall at a smaller cosine than this did not see it.
const GRAZING: f64 = 0.15;

impl Hough {
    /// The strongest line of these points: each votes with its weight, in the directions that are allowed.
    pub fn peak(
        &self,
        points: &[&Seen],
        allowed: impl Fn(f64) -> bool,
        weight: impl Fn(&Seen) -> f64,
    ) -> Option<(Line, f64)> {
        let cells = (self.reach / self.width).ceil() as usize;
        let mut best: Option<(Line, f64)> = None;
        let mut row = vec![0.0; cells];
        let turn = std::f64::consts::TAU / self.angles as f64;
        for a in (0..self.angles).map(|i| wrap(turn * i as f64)).filter(|a| allowed(*a)) {
            row.fill(0.0);
            let n = unit(a);
            for seen in points {
                let rho = seen.at.dot(&n);
                if rho >= 0.0 && rho < self.reach && unit(seen.bearing).dot(&n) > GRAZING {
                    row[((rho / self.width) as usize).min(cells - 1)] += weight(seen);
                }
            }
            for (i, votes) in row.iter().enumerate() {
                if *votes >= self.votes && best.is_none_or(|(_, most)| *votes > most) {
                    best = Some((Line { rho: (i as f64 + 0.5) * self.width, a }, *votes));
                }
            }
        }
        best
    }

    /// Every line, the strongest first: a peak's points are fitted and taken out before the next peak is looked for.
    pub fn lines(&self, window: &Window, allowed: impl Fn(f64) -> bool, weight: impl Fn(&Seen) -> f64) -> Vec<Fit> {
        let mut left: Vec<usize> = (0..window.points.len()).collect();
        let mut found = Vec::new();
        loop {
            let points: Vec<&Seen> = left.iter().map(|i| &window.points[*i]).collect();
            let Some((line, _)) = self.peak(&points, &allowed, &weight) else { return found };
            let own = self.inliers(window, &left, &line);
            let votes: f64 = own.iter().map(|i| weight(&window.points[*i])).sum();
            if own.is_empty() {
                return found;
            }
            left.retain(|i| !own.contains(i));
            if votes >= self.votes && own.len() >= 3 {
                found.push(fit(window, &own));
            }
        }
    }

    /// The longest run of points on a line.
    pub fn inliers(&self, window: &Window, among: &[usize], line: &Line) -> Vec<usize> {
        let near = |seen: &Seen| {
            line.beyond(seen.at).abs() <= self.inlier.max(self.width) && unit(seen.bearing).dot(&unit(line.a)) > GRAZING
        };
        let mut own: Vec<(f64, usize)> = among
            .iter()
            .filter(|i| near(&window.points[**i]))
            .map(|i| (line.along(window.points[*i].at), *i))
            .collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0));
        let runs = own.chunk_by(|a, b| b.0 - a.0 <= self.gap);
        runs.max_by_key(|run| run.len()).map_or(Vec::new(), |run| run.iter().map(|(_, i)| *i).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    const HOUGH: Hough = Hough { angles: 360, width: 0.02, reach: 4.0, votes: 8.0, inlier: 0.03, gap: 0.5 };

    fn window() -> Window {
        let wall = (0..20).map(|i| Point::new(0.05 * f64::from(i), 1.013));
        let slanted = (0..12).map(|i| Point::new(1.5 + 0.06 * f64::from(i), -0.1 * f64::from(i)));
        Window::of_points(wall.chain(slanted), 0.01)
    }

    #[test]
    fn both_walls_are_found_and_the_slanted_one_not_under_the_constraint() {
        let window = window();
        let free = HOUGH.lines(&window, |_| true, |_| 1.0);
        assert_eq!(free.len(), 2, "{free:?}");
        assert!((free[0].line.rho - 1.013).abs() < 1e-9 && free[0].points.len() == 20);
        let ten = 10f64.to_radians();
        let held = HOUGH.lines(&window, |a| crate::fit::off_quarter(a, 0.0).abs() <= ten, |_| 1.0);
        assert_eq!(held.len(), 1);
    }
}
