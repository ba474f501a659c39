//! Where a wall is of which nothing but its groups is known yet.

use slam_core::Standing;
use slam_core::angle::wrap;

use crate::diary::Diary;
use crate::frame::{Frame, dot};
use crate::group::Group;
use crate::rows::{grid_rad, off_grid};
use crate::wall::{Line, Wall};

/// Walls that are farther than six degrees from the grid are not on it, radians.
const OFF_GRID_RAD: f32 = 0.1;

/// Groups farther from a line than this say less about it, metres: some of those that the filter had on one wall lie where it
/// had lost its way, or are of something beside it.
const NEAR_M: f32 = 0.1;

/// Rounds in which a line is drawn to where most groups are.
const ROUNDS: usize = 6;

/// Multiply-adds of drawing a line, for each group of the diary.
const PLACE_COST: u32 = 20;

/// Draws the line of a wall that has none, and says of every wall whether it stands on the grid.
pub fn place_wall<const K: usize, const G: usize, const W: usize>(diary: &mut Diary<K, G, W>, index: usize) -> u32 {
    let Some(wall) = diary.walls.get(index).copied().flatten() else { return 1 };
    let placed = if wall.is_placed { Some(wall) } else { place(diary, index) };
    if let (Some(slot), Some(mut found)) = (diary.walls.get_mut(index), placed) {
        found.on_grid = is_on_grid(&found, diary.alpha_rad);
        *slot = Some(found);
    }
    if wall.is_placed { 1 } else { PLACE_COST * diary.groups.len() as u32 }
}

/// Draws the line of wall `index` through its groups: least squares across it, in rounds, of groups weighted by how near they
/// are to the last round's line. Says whether it stands on the grid. None where it has no groups.
pub fn place<const K: usize, const G: usize, const W: usize>(diary: &Diary<K, G, W>, index: usize) -> Option<Wall> {
    let mut line: Option<Line> = None;
    let mut mean_m = [0.0; 2];
    for _ in 0..ROUNDS {
        let mut all: Option<Group> = None;
        let mut towards = [0.0; 2];
        for (frame, group) in seen(diary, index) {
            let mut group = diary.gains.correct(group).moved(&frame);
            let off_m = line.map_or(0.0, |line| dot(line.normal, group.mean_m) - line.rho_m) / NEAR_M;
            // Every group counts by its hits: a wall's groups lie on it, whatever their sensors' noise.
            let weight = f32::from(group.hits) / (1.0 + off_m * off_m) / group.weight;
            group.weight *= weight;
            group.scatter = group.scatter.map(|value| value * weight);
            let way = [group.mean_m[0] - group.from_m[0], group.mean_m[1] - group.from_m[1]];
            towards = [towards[0] + group.weight * way[0], towards[1] + group.weight * way[1]];
            match &mut all {
                Some(all) => all.add(&group),
                None => all = Some(group),
            }
        }
        let all = all?;
        mean_m = all.mean_m;
        line = Some(through(&all, towards));
    }
    let before = diary.walls.get(index).copied().flatten()?;
    let line = told(&before, diary.alpha_rad, mean_m).or(line)?;
    let beta_rad = wrap(libm::atan2f(line.normal[1], line.normal[0]));
    Some(Wall { rho_m: line.rho_m, beta_rad, anchor_m: dot(line.tangent(), mean_m), is_placed: true, ..before })
}

/// The line through a point in the grid's direction that the filter has the wall in: a wall that was seen along a hand's breadth would
/// be drawn in any.
fn told(wall: &Wall, alpha_rad: Option<f32>, at_m: [f32; 2]) -> Option<Line> {
    let (Standing::Near(quarter) | Standing::Exact(quarter)) = wall.told else { return None };
    let (s, c) = slam_core::angle::sin_cos(wrap(grid_rad(alpha_rad?, quarter)));
    Some(Line { rho_m: dot([c, s], at_m), normal: [c, s] })
}

/// Whether a wall stands on the grid: as the filter has it, or by its direction.
pub fn is_on_grid(wall: &Wall, alpha_rad: Option<f32>) -> bool {
    match wall.told {
        Standing::Unknown => alpha_rad.is_some_and(|alpha_rad| off_grid(wall.beta_rad, alpha_rad).abs() < OFF_GRID_RAD),
        told => told != Standing::Off,
    }
}

/// A wall's groups, each with the frame of its keyframe.
fn seen<const K: usize, const G: usize, const W: usize>(
    diary: &Diary<K, G, W>,
    wall: usize,
) -> impl Iterator<Item = (Frame, &Group)> {
    let on_wall = move |group: &&Group| group.wall() == Some(wall);
    diary
        .sightings()
        .flat_map(move |(key, groups)| groups.iter().filter(on_wall).map(move |group| (Frame::of(&key.pose), group)))
}

/// The line with the least squares across it through what is spread about its mean so; its normal points along `towards`.
fn through(all: &Group, towards: [f32; 2]) -> Line {
    let [xx, xy, yy] = all.scatter;
    let (s, c) = slam_core::angle::sin_cos(0.5 * libm::atan2f(2.0 * xy, xx - yy));
    let normal = if dot([-s, c], towards) >= 0.0 { [-s, c] } else { [s, -c] };
    Line { rho_m: dot(normal, all.mean_m), normal }
}
