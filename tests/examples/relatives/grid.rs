//! After Grossmann and Poli 2001: where a robot is in a home whose walls are given, by the Hough lines of its readings and a grid of
//! probabilities over its poses. Their text was not at hand: what is written here but that is ours.

use relatives::Input;
use relatives::fit::Fit;
use relatives::geometry::{Chain, Line, Point, Pose, rotation, wrap};
use relatives::hough::Hough;
use relatives::known::Known;
use relatives::window::{Extent, Window};
use std::f64::consts::TAU;

/// Edge of a cell, metres, and headings in a full turn.
const CELL: f64 = 0.1;
const HEADINGS: usize = 72;
const HEADING: f64 = TAU / HEADINGS as f64;
/// Way between two updates, and how far a wall may be to be seen, metres.
const EVERY: f64 = 0.5;
const REACH: f64 = 1.7;
const WINDOW: Extent = Extent { path: 1.0, turn: 1.5, points: 800, step: 0.01 };
const HOUGH: Hough = Hough { angles: 360, width: 0.02, reach: 3.0, votes: 12.0, inlier: 0.03, gap: 0.3 };
/// Shortest line that is used, metres.
const LENGTH: f64 = 0.3;
/// 1-sigma of a line against a wall, metres and radians, and the weight of a line that is of no wall.
const SIGMA: (f64, f64) = (0.08, 4.0 * std::f64::consts::PI / 180.0);
const NO_WALL: f64 = 0.1;
/// Cells with less are not looked at.
const NOTHING: f64 = 1e-9;
/// What is as near as this to the best cell counts as the same place, metres and radians.
const SAME: (f64, f64) = (0.3, 10.0 * std::f64::consts::PI / 180.0);

/// A place, and how probable it is.
#[derive(Clone, Copy, Debug)]
pub struct Belief {
    /// The most probable cell, in the frame of the walls.
    pub pose: Pose,
    /// Probability of its surroundings.
    pub mass: f64,
}

/// The grid.
pub struct Localiser {
    low: Point,
    size: [usize; 2],
    /// The walls that can be seen from each place, as lines from there.
    seen: Vec<Vec<Line>>,
    /// Probabilities by heading, then place.
    mass: Vec<f64>,
    window: Window,
    since: Chain,
    updated: f64,
}

impl Localiser {
    /// Anywhere among these walls.
    pub fn new(known: &Known) -> Self {
        let ends = || known.walls.iter().flat_map(|wall| [wall.from, wall.to]);
        let low = ends().fold(Point::repeat(f64::INFINITY), |low, end| low.inf(&end));
        let high = ends().fold(Point::repeat(f64::NEG_INFINITY), |high, end| high.sup(&end));
        let size = [0, 1].map(|axis| ((high - low)[axis] / CELL).ceil().max(1.0) as usize);
        let place = |i: usize| low + Point::new((i % size[0]) as f64 + 0.5, (i / size[0]) as f64 + 0.5) * CELL;
        let from = |i: usize| {
            let pose = Pose { at: place(i), theta: 0.0 };
            known.visible(&pose, REACH).into_iter().map(|wall| known.seen(wall, &pose)).collect()
        };
        let places = size[0] * size[1];
        let mass = vec![1.0 / (places * HEADINGS) as f64; places * HEADINGS];
        let seen = (0..places).map(from).collect();
        Self { low, size, seen, mass, window: Window::new(WINDOW), since: Chain::default(), updated: 0.0 }
    }

    /// Takes in one step; what is believed, where there was enough way for an update.
    pub fn step(&mut self, input: &Input<'_>) -> Option<Belief> {
        self.since = self.since.then(&input.motion, &input.motion_cov);
        self.window.step(input);
        let way = self.window.path + self.window.turned / 3.0;
        if way - self.updated < EVERY {
            return None;
        }
        self.updated = way;
        self.move_on();
        let mut fits = HOUGH.lines(&self.window, |_| true, |_| 1.0);
        fits.retain(|fit| fit.length() >= LENGTH);
        self.weigh(&fits);
        let used: Vec<usize> = fits.into_iter().flat_map(|fit| fit.points).collect();
        self.window.drop(&used);
        Some(self.best())
    }

    /// The motion since the last update: each cell's share goes to the cells around where it leads, wider by its noise.
    fn move_on(&mut self) {
        let Chain { pose: moved, covariance } = std::mem::take(&mut self.since);
        let places = self.seen.len();
        let mut next = vec![0.0; self.mass.len()];
        let spread = |variance: f64, cell: f64| (0.5 * variance / (cell * cell)).min(0.25);
        let turns = kernel(moved.theta / HEADING, spread(covariance[(2, 2)], HEADING));
        let across = spread(0.5 * (covariance[(0, 0)] + covariance[(1, 1)]), CELL);
        for heading in 0..HEADINGS {
            let shift = rotation(heading as f64 * HEADING) * moved.at / CELL;
            let kernels = [kernel(shift.x, across), kernel(shift.y, across)];
            for (place, mass) in self.mass[heading * places..(heading + 1) * places].iter().enumerate() {
                if *mass < NOTHING {
                    continue;
                }
                let at = [(place % self.size[0]) as i64, (place / self.size[0]) as i64];
                for ((x, y), weight) in
                    kernels[0].iter().flat_map(|x| kernels[1].iter().map(move |y| ((x.0, y.0), x.1 * y.1)))
                {
                    let to = [at[0] + x, at[1] + y];
                    if (0..2).any(|axis| to[axis] < 0 || to[axis] >= self.size[axis] as i64) {
                        continue;
                    }
                    let to = to[1] as usize * self.size[0] + to[0] as usize;
                    for (turn, share) in &turns {
                        let heading = (heading as i64 + turn).rem_euclid(HEADINGS as i64) as usize;
                        next[heading * places + to] += mass * weight * share;
                    }
                }
            }
        }
        self.mass = next;
    }

    /// Each line that was seen against the walls that a cell would see.
    fn weigh(&mut self, fits: &[Fit]) {
        let places = self.seen.len();
        let most = self.mass.iter().copied().fold(0.0, f64::max);
        for (cell, mass) in self.mass.iter_mut().enumerate() {
            if *mass < NOTHING * most {
                *mass = 0.0;
                continue;
            }
            let theta = (cell / places) as f64 * HEADING;
            for fit in fits {
                let like = |wall: &Line| {
                    let off = [(fit.line.rho - wall.rho) / SIGMA.0, wrap(fit.line.a + theta - wall.a) / SIGMA.1];
                    (-0.5 * (off[0] * off[0] + off[1] * off[1])).exp()
                };
                *mass *= NO_WALL + self.seen[cell % places].iter().map(like).fold(0.0, f64::max);
            }
        }
        let sum: f64 = self.mass.iter().sum();
        self.mass.iter_mut().for_each(|mass| *mass /= sum);
    }

    fn pose_of(&self, cell: usize) -> Pose {
        let (heading, place) = (cell / self.seen.len(), cell % self.seen.len());
        let at = Point::new((place % self.size[0]) as f64 + 0.5, (place / self.size[0]) as f64 + 0.5);
        Pose { at: self.low + at * CELL, theta: wrap(heading as f64 * HEADING) }
    }

    fn best(&self) -> Belief {
        let best = self.mass.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |best| best.0);
        let pose = self.pose_of(best);
        let probable = self.mass.iter().enumerate().filter(|(_, mass)| **mass > NOTHING);
        let near = probable.filter(|(cell, _)| is_same(&pose, &self.pose_of(*cell)));
        Belief { pose, mass: near.map(|(_, mass)| mass).sum() }
    }
}

/// Whether two poses are one place.
pub fn is_same(one: &Pose, other: &Pose) -> bool {
    (one.at - other.at).norm() <= SAME.0 && wrap(one.theta - other.theta).abs() <= SAME.1
}

/// Where a shift of so many cells leads, and with which shares: between two cells, and wider by a spread to both sides.
fn kernel(shift: f64, spread: f64) -> Vec<(i64, f64)> {
    let (whole, part) = (shift.floor() as i64, shift - shift.floor());
    let share = |cell: i64| match cell {
        0 => 1.0 - part,
        1 => part,
        _ => 0.0,
    };
    let wide = |cell: i64| share(cell) * (1.0 - 2.0 * spread) + spread * (share(cell - 1) + share(cell + 1));
    (-1..=2).map(|cell| (whole + cell, wide(cell))).filter(|(_, share)| *share > 1e-4).collect()
}
