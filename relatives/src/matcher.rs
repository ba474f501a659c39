//! Occupancy grids, and where a cloud of points fits one best: branch and bound over shifts (Hess et al. 2016).

use std::collections::HashMap;

use crate::geometry::{Point, Pose, Segment, rotation};

/// Edge of a cell, metres.
pub const CELL: f64 = 0.1;
/// Probability of a cell that a beam ended in, and of one that it passed.
const HIT: f64 = 0.7;
const MISS: f64 = 0.4;
/// Log-odds stay between these, negative and positive: probabilities of 12 and 97 per cent.
const LIMITS: [f64; 2] = [-2.0, 3.5];
/// Largest shift of one search is two to this many cells.
const LEVELS: usize = 5;

/// A cell's place.
type Cell = [i32; 2];

/// A grid of log-odds.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    cells: HashMap<Cell, f64>,
}

fn cell(point: Point) -> Cell {
    [(point.x / CELL).floor() as i32, (point.y / CELL).floor() as i32]
}

impl Grid {
    /// Draws a beam from where it began to where it ended, in the grid's frame.
    pub fn draw(&mut self, beam: &Segment) {
        let steps = (beam.length() / (0.5 * CELL)).ceil().max(1.0) as usize;
        let end = cell(beam.to);
        let mut last = end;
        for i in 0..steps {
            let passed = cell(beam.from + (beam.to - beam.from) * (i as f64 / steps as f64));
            if passed != last && passed != end {
                self.add(passed, (MISS / (1.0 - MISS)).ln());
                last = passed;
            }
        }
        self.add(end, (HIT / (1.0 - HIT)).ln());
    }

    fn add(&mut self, cell: Cell, by: f64) {
        let odds = self.cells.entry(cell).or_insert(0.0);
        *odds = (*odds + by).clamp(LIMITS[0], LIMITS[1]);
    }

    /// The levels of the search: in level k a cell has the largest probability of the 2^k by 2^k cells up and right of it. What
    /// is known to be free counts nothing; each cell takes the largest of its neighbours first.
    pub fn pyramid(&self) -> Pyramid {
        let occupied = self.cells.iter().filter(|(_, odds)| **odds > 0.0);
        let probability = |odds: f64| 1.0 - 1.0 / (1.0 + odds.exp());
        let mut blurred: HashMap<Cell, f32> = HashMap::new();
        for ([x, y], odds) in occupied {
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let value = blurred.entry([x + dx, y + dy]).or_insert(0.0);
                *value = value.max(probability(*odds) as f32);
            }
        }
        let fine = self.cells.iter().filter(|(_, odds)| **odds > 0.0);
        let fine = fine.map(|(cell, odds)| (*cell, probability(*odds) as f32)).collect();
        let mut levels = vec![blurred];
        for level in 0..LEVELS {
            let half = 1 << level;
            let mut next: HashMap<Cell, f32> = HashMap::new();
            for ([x, y], value) in &levels[level] {
                for at in [[*x, *y], [x - half, *y], [*x, y - half], [x - half, y - half]] {
                    let entry = next.entry(at).or_insert(0.0);
                    *entry = entry.max(*value);
                }
            }
            levels.push(next);
        }
        Pyramid { levels, fine }
    }

    /// Memory that the cells take, bytes.
    pub fn bytes(&self) -> usize {
        self.cells.len() * size_of::<(Cell, f64)>()
    }
}

/// A grid made ready for a search.
pub struct Pyramid {
    levels: Vec<HashMap<Cell, f32>>,
    /// The probabilities themselves.
    fine: HashMap<Cell, f32>,
}

/// A place where a cloud fits.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// The cloud's frame in the grid's.
    pub pose: Pose,
    /// Mean probability of the cells that its points are in.
    pub score: f64,
    /// The turn of the best cell, radians.
    pub coarse: f64,
}

/// How far around a guess is searched.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Shift each way, metres.
    pub shift: f64,
    /// Turn each way, radians.
    pub turn: f64,
    /// Least score.
    pub score: f64,
}

/// A square of shifts of one turn: its bound, its level, its lower corner and the turn's index.
type Branch = (f64, usize, Cell, usize);

impl Pyramid {
    /// Mean probability where the points are, between the middles of the cells.
    fn smooth(&self, cloud: &[Point], pose: &Pose) -> f64 {
        let value = |point: &Point| {
            let at = pose.transform(*point) / CELL - Point::new(0.5, 0.5);
            let (low, share) = (at.map(f64::floor), at - at.map(f64::floor));
            let corner = |dx: i32, dy: i32| {
                let weight =
                    (if dx == 1 { share.x } else { 1.0 - share.x }) * (if dy == 1 { share.y } else { 1.0 - share.y });
                let cell = [low.x as i32 + dx, low.y as i32 + dy];
                weight * f64::from(self.fine.get(&cell).copied().unwrap_or(0.0))
            };
            corner(0, 0) + corner(1, 0) + corner(0, 1) + corner(1, 1)
        };
        cloud.iter().map(value).sum::<f64>() / cloud.len().max(1) as f64
    }

    /// A place made finer than a cell: uphill in steps that are halved.
    fn climb(&self, cloud: &[Point], from: Pose) -> Pose {
        let (mut pose, mut step, mut best) = (from, CELL, self.smooth(cloud, &from));
        while step > 0.1 * CELL {
            let moves = [(step, 0.0, 0.0), (0.0, step, 0.0), (0.0, 0.0, 0.2 * step)];
            let tried = moves.into_iter().flat_map(|(x, y, turn)| [(x, y, turn), (-x, -y, -turn)]);
            let rated = tried.map(|(x, y, turn)| {
                let moved = Pose::new(pose.at.x + x, pose.at.y + y, pose.theta + turn);
                (self.smooth(cloud, &moved), moved)
            });
            match rated.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((value, next)) if value > best => (best, pose) = (value, next),
                _ => step *= 0.5,
            }
        }
        pose
    }

    fn score(&self, level: usize, cells: &[Cell], shift: Cell) -> f64 {
        let grid = &self.levels[level];
        let value = |c: &Cell| grid.get(&[c[0] + shift[0], c[1] + shift[1]]).copied().unwrap_or(0.0);
        cells.iter().map(|c| f64::from(value(c))).sum::<f64>() / cells.len().max(1) as f64
    }

    /// The best place of a cloud near a guess; none under the least score.
    pub fn find(&self, cloud: &[Point], guess: &Pose, range: &Range) -> Option<Match> {
        let farthest = cloud.iter().map(|point| point.norm()).fold(1.0, f64::max);
        // A turn that moves the farthest point by a cell.
        let step = (1.0 - 0.5 * (CELL / farthest).powi(2)).acos();
        let turns = (range.turn / step).ceil() as i32;
        let turned = |i: i32| -> Vec<Cell> {
            let turn = rotation(guess.theta + f64::from(i) * step);
            cloud.iter().map(|point| cell(turn * point + guess.at)).collect()
        };
        let clouds: Vec<Vec<Cell>> = (-turns..=turns).map(turned).collect();
        let span = (range.shift / CELL).ceil() as i32;
        let whole = 1 << LEVELS;
        let mut open: Vec<Branch> = Vec::new();
        for (turn, cells) in clouds.iter().enumerate() {
            for x in (-span..=span).step_by(whole) {
                for y in (-span..=span).step_by(whole) {
                    open.push((self.score(LEVELS, cells, [x, y]), LEVELS, [x, y], turn));
                }
            }
        }
        open.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<Branch> = None;
        while let Some((bound, level, at, turn)) = open.pop() {
            if bound < range.score || best.is_some_and(|best| bound <= best.0) {
                continue;
            }
            if level == 0 {
                best = Some((bound, level, at, turn));
                continue;
            }
            let half = 1 << (level - 1);
            let mut children: Vec<Branch> = [[0, 0], [half, 0], [0, half], [half, half]]
                .into_iter()
                .map(|d| [at[0] + d[0], at[1] + d[1]])
                .filter(|at| at.iter().all(|shift| shift.abs() <= span))
                .map(|at| (self.score(level - 1, &clouds[turn], at), level - 1, at, turn))
                .collect();
            children.sort_by(|a, b| a.0.total_cmp(&b.0));
            open.extend(children);
        }
        best.map(|(score, _, at, turn)| {
            let shift = Point::new(f64::from(at[0]), f64::from(at[1])) * CELL;
            let theta = guess.theta + (turn as i32 - turns) as f64 * step;
            let pose = Pose::new(guess.at.x + shift.x, guess.at.y + shift.y, theta);
            let pose = self.climb(cloud, pose);
            Match { pose, score, coarse: theta }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corner of a room with a niche, as end points seen from the origin.
    fn corner() -> Vec<Point> {
        let wall = (0..60).map(|i| Point::new(0.05 * f64::from(i), 2.05));
        let side = (0..40).map(|i| Point::new(3.05, 2.0 - 0.05 * f64::from(i)));
        let niche = (0..10).map(|i| Point::new(1.0 + 0.05 * f64::from(i), 2.55));
        wall.chain(side).chain(niche).collect()
    }

    #[test]
    fn the_search_finds_what_trying_every_place_finds() {
        let mut grid = Grid::default();
        for to in corner() {
            grid.draw(&Segment { from: Point::zeros(), to });
        }
        let pyramid = grid.pyramid();
        let truth = Pose::new(0.4, -0.3, 0.1);
        let cloud: Vec<Point> = corner().iter().map(|point| truth.inverse_transform(*point)).collect();
        let range = Range { shift: 0.9, turn: 0.2, score: 0.3 };
        let found = pyramid.find(&cloud, &Pose::default(), &range).expect("a place");
        assert!((found.pose.at - truth.at).norm() < 0.05 && (found.pose.theta - 0.1).abs() < 0.03, "{found:?}");
        // Every shift at the turn that was found, against the search's best.
        let turn = rotation(found.coarse);
        let cells: Vec<Cell> = cloud.iter().map(|point| cell(turn * point)).collect();
        let all = (-9..=9).flat_map(|x| (-9..=9).map(move |y| [x, y]));
        let best = all.map(|shift| pyramid.score(0, &cells, shift)).fold(0.0, f64::max);
        assert!((best - found.score).abs() < 1e-9, "{best} {}", found.score);
    }
}
