//! How much of the floor a drive swept: a raster of the true floor plan under the true path.

mod holes;
mod rebuilt;

use std::collections::VecDeque;

use robot::Bounds;

use crate::plan::{Cliff, Plan};
use crate::pose::Pose2;
use crate::world::World;

/// Edge of a cell, metres.
pub const CELL_M: f64 = 0.025;

/// Width of the brush, metres: what lies within half of it of the robot's centre is swept.
pub const BRUSH_M: f64 = 0.25;

/// A cell that was not under the brush for this long is swept once more when it comes there again, seconds.
const PASS_S: f64 = 2.0;

/// Progress is noted this often, seconds.
const PROGRESS_S: f64 = 1.0;

/// Poses farther apart than this are not joined by a path, metres: the robot was carried.
const CARRIED_M: f64 = 0.1;

/// How a drive swept the floor that the brush can reach.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorScore {
    /// The floor that can be reached, m^2.
    pub floor_m2: f64,
    /// Share of it that was swept.
    pub swept: f64,
    /// Share of it that was swept twice or more.
    pub twice: f64,
    /// The largest piece in one that was missed, m^2.
    pub largest_hole_m2: f64,
    /// Lower and upper corner of the box around it in the plan's frame, metres; none where nothing was missed.
    pub hole_m: Option<[[f64; 2]; 2]>,
    /// Length of the true path, metres.
    pub path_m: f64,
    /// Area of the path, as wide as the brush, over the area swept.
    pub overlap: f64,
    /// How often the bumper was pressed.
    pub bumps: u32,
    /// Distance from where the drive started to where it ended, metres.
    pub home_m: f64,
    /// What the robot did, and for how many seconds.
    pub time: Vec<(String, f64)>,
    /// What the robot did, and how far it drove and how much floor it swept for the first time meanwhile.
    pub ways: Vec<Way>,
    /// The shares over time.
    pub progress: Vec<FloorShare>,
    /// The floor from above.
    pub picture: FloorPicture,
}

/// What part of the path was driven for.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// What the robot did, in a word.
    pub doing: &'static str,
    /// Length of this part, metres.
    pub path_m: f64,
    /// Floor swept in it for the first time, m^2.
    pub new_m2: f64,
}

/// How much of the floor was swept by some time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FloorShare {
    /// Time since the start, seconds.
    pub t_s: f64,
    /// Share that was swept.
    pub swept: f64,
    /// Share that was swept twice or more.
    pub twice: f64,
}

/// The floor from above, in the plan's frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorPicture {
    /// Lower corner, metres.
    pub corner_m: [f64; 2],
    /// Edge of a cell, metres.
    pub cell_m: f64,
    /// Cells in a row.
    pub columns: usize,
    /// Cells row by row, along x first: 0 out of reach, 1 missed, 2 swept once, 3 twice or more.
    pub cells: Vec<u8>,
    /// When each cell was swept first, and again, seconds since the start; infinity where it was not.
    pub swept_s: Vec<[f32; 2]>,
    /// Origin of the frame that true poses are in, in the plan's frame.
    pub origin: Pose2,
    /// Where the robot must not go, and what it is to clean, in the plan's frame.
    pub bounds: Bounds,
}

/// The floor as it is swept, in the plan's frame.
#[derive(Clone, Debug)]
pub struct FloorRaster {
    corner_m: [f64; 2],
    columns: usize,
    rows: usize,
    is_floor: Vec<bool>,
    /// When each cell was swept first and again, seconds since the start; infinite where it was not.
    swept_s: Vec<[f32; 2]>,
    last_s: Vec<f64>,
    floor: usize,
    swept: usize,
    twice: usize,
    path_m: f64,
    last: Option<Pose2>,
    start: Pose2,
    origin: Pose2,
    bounds: Bounds,
    radius_m: f64,
    progress: Vec<FloorShare>,
    time: Vec<(&'static str, f64)>,
    ways: Vec<Way>,
    last_t_s: f64,
    bumps: u32,
    was_pressed: bool,
}

/// What the robot is at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time since the start, seconds.
    pub t_s: f64,
    /// The true pose in the plan's frame.
    pub pose: Pose2,
    /// What it does, in a word.
    pub doing: &'static str,
    /// The bumper is pressed.
    pub is_pressed: bool,
    /// The brush is on the floor.
    pub is_on_floor: bool,
}

impl FloorRaster {
    /// Nothing swept yet of the floor that a round body of this radius (metres) can reach from `start` with its brush. Doors
    /// that shut for good are shut.
    pub fn new(plan: &Plan, radius_m: f64, start: Pose2) -> Self {
        let ends = plan.faces.iter().flat_map(|face| [face.from_m, face.to_m]);
        let (mut low, mut high) = ([start.x_m, start.y_m], [start.x_m, start.y_m]);
        for end in ends {
            for axis in 0..2 {
                low[axis] = low[axis].min(end[axis]);
                high[axis] = high[axis].max(end[axis]);
            }
        }
        let cells = |axis: usize| ((high[axis] - low[axis]) / CELL_M).ceil() as usize + 1;
        let (columns, rows) = (cells(0), cells(1));
        let mut raster = Self {
            corner_m: low,
            columns,
            rows,
            is_floor: vec![false; columns * rows],
            swept_s: vec![[f32::INFINITY; 2]; columns * rows],
            last_s: vec![f64::NEG_INFINITY; columns * rows],
            floor: 0,
            swept: 0,
            twice: 0,
            path_m: 0.0,
            last: None,
            start,
            origin: plan.start,
            bounds: plan.bounds.clone(),
            radius_m,
            progress: Vec::new(),
            time: Vec::new(),
            ways: Vec::new(),
            last_t_s: 0.0,
            bumps: 0,
            was_pressed: false,
        };
        for index in raster.places(&still(plan), &plan.cliffs, radius_m, start) {
            let centre_m = raster.centre_m(index);
            for cell in raster.within(centre_m, 0.5 * BRUSH_M) {
                if !raster.bounds.is_to_clean(raster.centre_m(cell).map(|value_m| value_m as f32)) {
                    continue;
                }
                raster.floor += usize::from(!raster.is_floor[cell]);
                raster.is_floor[cell] = true;
            }
        }
        raster
    }

    /// The cells that the body's centre can reach from where it starts.
    fn places(&self, world: &World, cliffs: &[Cliff], radius_m: f64, start: Pose2) -> Vec<usize> {
        let count = self.columns * self.rows;
        let is_free: Vec<bool> = (0..count)
            .map(|index| {
                let centre_m = self.centre_m(index);
                world.clearance_m(centre_m) >= radius_m
                    && cliffs.iter().all(|cliff| beside_m(cliff, centre_m) >= radius_m)
            })
            .collect();
        let mut is_reached = vec![false; count];
        let near = self.within([start.x_m, start.y_m], 2.0 * CELL_M);
        let mut front: VecDeque<usize> = near.into_iter().filter(|&cell| is_free[cell]).take(1).collect();
        let mut places = Vec::new();
        while let Some(cell) = front.pop_front() {
            if core::mem::replace(&mut is_reached[cell], true) {
                continue;
            }
            places.push(cell);
            front.extend(self.neighbours(cell).filter(|&next| is_free[next] && !is_reached[next]));
        }
        places
    }

    fn centre_m(&self, index: usize) -> [f64; 2] {
        let middle = |axis: usize, cell: usize| self.corner_m[axis] + (cell as f64 + 0.5) * CELL_M;
        [middle(0, index % self.columns), middle(1, index / self.columns)]
    }

    /// The cells whose centres are this near to a point (metres).
    fn within(&self, point_m: [f64; 2], radius_m: f64) -> Vec<usize> {
        let range = |axis: usize, cells: usize| {
            let at = |offset_m: f64| ((point_m[axis] + offset_m - self.corner_m[axis]) / CELL_M - 0.5).max(0.0);
            at(-radius_m).ceil() as usize..(at(radius_m).floor() as usize + 1).min(cells)
        };
        let is_near = |&index: &usize| {
            let [x_m, y_m] = self.centre_m(index);
            let [x_m, y_m] = [x_m - point_m[0], y_m - point_m[1]];
            x_m * x_m + y_m * y_m <= radius_m * radius_m
        };
        let columns = range(0, self.columns);
        let in_row = |row: usize| columns.clone().map(move |column| row * self.columns + column);
        range(1, self.rows).flat_map(in_row).filter(is_near).collect()
    }

    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, row, columns, rows) = (index % self.columns, index / self.columns, self.columns, self.rows);
        let west = (column > 0).then(|| index - 1);
        let east = (column + 1 < columns).then(|| index + 1);
        let south = (row > 0).then(|| index - columns);
        let north = (row + 1 < rows).then(|| index + columns);
        [west, east, south, north].into_iter().flatten()
    }

    /// The robot is here now.
    pub fn record(&mut self, moment: &Moment) {
        let Moment { t_s, pose, doing, is_pressed, is_on_floor } = *moment;
        let passed_s = t_s - self.last_t_s;
        match self.time.iter_mut().find(|(name, _)| *name == doing) {
            Some((_, sum_s)) => *sum_s += passed_s,
            None => self.time.push((doing, passed_s)),
        }
        self.last_t_s = t_s;
        self.bumps += u32::from(is_pressed && !self.was_pressed);
        self.was_pressed = is_pressed;
        let from = self.last.replace(pose).unwrap_or(pose);
        let moved_m = libm::hypot(pose.x_m - from.x_m, pose.y_m - from.y_m);
        if is_on_floor && moved_m < CARRIED_M {
            let swept = self.swept;
            self.path_m += moved_m;
            self.sweep(t_s, [0.5 * (from.x_m + pose.x_m), 0.5 * (from.y_m + pose.y_m)]);
            self.sweep(t_s, [pose.x_m, pose.y_m]);
            let new_m2 = (self.swept - swept) as f64 * CELL_M * CELL_M;
            match self.ways.iter_mut().find(|way| way.doing == doing) {
                Some(way) => (way.path_m, way.new_m2) = (way.path_m + moved_m, way.new_m2 + new_m2),
                None => self.ways.push(Way { doing, path_m: moved_m, new_m2 }),
            }
        }
        if self.progress.last().is_none_or(|last| t_s - last.t_s >= PROGRESS_S) {
            self.progress.push(self.share(t_s));
        }
    }

    fn sweep(&mut self, t_s: f64, centre_m: [f64; 2]) {
        for cell in self.within(centre_m, 0.5 * BRUSH_M) {
            if self.is_floor[cell] && t_s - self.last_s[cell] > PASS_S {
                let [first_s, again_s] = &mut self.swept_s[cell];
                if first_s.is_infinite() {
                    *first_s = t_s as f32;
                    self.swept += 1;
                } else if again_s.is_infinite() {
                    *again_s = t_s as f32;
                    self.twice += 1;
                }
            }
            self.last_s[cell] = t_s;
        }
    }

    /// Where the raster lies: its lower corner in the plan's frame, metres, and its cells in a row.
    pub fn place(&self) -> ([f64; 2], usize) {
        (self.corner_m, self.columns)
    }

    /// When each cell was swept first and again, seconds since the start, row by row, along x first: infinite where it was not,
    /// NaN where the brush cannot reach.
    pub fn swept_s(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        self.is_floor.iter().zip(&self.swept_s).map(|(is_floor, at_s)| if *is_floor { *at_s } else { [f32::NAN; 2] })
    }

    /// How much of the floor is swept now.
    pub fn now(&self) -> FloorShare {
        self.share(self.last_t_s)
    }

    fn share(&self, t_s: f64) -> FloorShare {
        let floor = self.floor.max(1) as f64;
        FloorShare { t_s, swept: self.swept as f64 / floor, twice: self.twice as f64 / floor }
    }

    /// What was swept so far.
    pub fn score(&self) -> FloorScore {
        let area_m2 = |cells: usize| cells as f64 * CELL_M * CELL_M;
        let share = self.now();
        let hole = self.largest_hole();
        let home_m = self.last.map_or(0.0, |pose| libm::hypot(pose.x_m - self.start.x_m, pose.y_m - self.start.y_m));
        let mut progress = self.progress.clone();
        if progress.last().is_none_or(|last| last.t_s < share.t_s) {
            progress.push(share);
        }
        let code = |swept_s: &[f32; 2]| 1 + swept_s.iter().filter(|at_s| at_s.is_finite()).count() as u8;
        let codes = self.is_floor.iter().zip(&self.swept_s).map(|(is_floor, at)| if *is_floor { code(at) } else { 0 });
        FloorScore {
            floor_m2: area_m2(self.floor),
            swept: share.swept,
            twice: share.twice,
            largest_hole_m2: area_m2(hole.len()),
            hole_m: self.box_around(&hole),
            path_m: self.path_m,
            overlap: self.path_m * BRUSH_M / area_m2(self.swept).max(CELL_M * CELL_M),
            bumps: self.bumps,
            home_m,
            time: self.time.iter().map(|(name, sum_s)| ((*name).to_owned(), *sum_s)).collect(),
            ways: self.ways.clone(),
            progress,
            picture: FloorPicture {
                corner_m: self.corner_m,
                cell_m: CELL_M,
                columns: self.columns,
                cells: codes.collect(),
                swept_s: self.swept_s.clone(),
                origin: self.origin,
                bounds: self.bounds.clone(),
            },
        }
    }
}

/// What stands in the home for good: no people, and of the doors those that stay shut. Where the robot must not go there is a wall
/// around.
fn still(plan: &Plan) -> World {
    let mut plan = plan.clone();
    plan.people.clear();
    plan.faces.extend(plan.fences());
    plan.doors.retain(|door| door.opens_at_s.is_infinite());
    for door in &mut plan.doors {
        door.closes_at_s = 0.0;
    }
    World::new(&plan)
}

/// Distance of a point from a place without a floor, metres.
fn beside_m(cliff: &Cliff, point_m: [f64; 2]) -> f64 {
    let off = |axis: usize| (cliff.min_m[axis] - point_m[axis]).max(point_m[axis] - cliff.max_m[axis]).max(0.0);
    libm::hypot(off(0), off(1))
}

#[cfg(test)]
mod tests;
