//! The path and the map as they look from the end.
//!
//! The robot's filter knows at each moment what was sensed until then. What it drew before a loop closed stays where it was
//! drawn. A workbench has the whole log: here all poses, all walls and the scales of the odometry are placed together so
//! that the motion that was sensed and the readings are likeliest (full SLAM: Thrun and Montemerlo 2006; robust weights:
//! Cauchy): first each reading on the wall that the filter took it for, until walls that turn out to be one have become one;
//! then on the wall that it ended on, in rounds, as the points of a scan are matched (Besl and McKay 1992).
//!
//! It is a look back, never an input: nothing of it reaches the filter.

mod graph;
mod keyframes;
mod labels;
mod line;
mod parts;
mod seen;
mod sightings;
mod twins;

use slam_core::{Rig, WallView};

use crate::evaluate::score;
use crate::input::rig_file::MAX_SENSORS;
use crate::recording::{Figures, LookingBack, MapSnapshot, Pose2, Recording, Step};
use graph::Graph;
use keyframes::Keyframes;
pub use sightings::{Expected, Noise};

/// Rounds of merging walls that turn out to be one, at most.
const MERGING_ROUNDS: usize = 40;

/// Rounds of giving readings to the walls that they ended on, at most.
const LABELLING_ROUNDS: usize = 8;

/// Rounds until it is settled, at most, and between two mergers, when it need not be.
const ROUNDS: usize = 25;
const ROUNDS_BETWEEN: usize = 4;

/// The record of a scored run as it looks from the end, with its own scores, which are also put among the run's figures.
/// None where no wall was seen or nothing can be solved. `progress` is told the rounds so far: a long log takes minutes.
pub fn add(recording: &mut Recording, rig: &Rig<MAX_SENSORS>, progress: &mut dyn FnMut(usize)) -> Option<Recording> {
    if !recording.is_one_frame() {
        return None;
    }
    let back = look_back(recording, rig, progress)?;
    Some(scored(recording, back))
}

/// A record as it looks from the end with its own scores, which are also put among the run's figures.
pub fn scored(recording: &mut Recording, mut back: Recording) -> Recording {
    back.figures = Figures { estimate: None, map: None, ..back.figures };
    score::score(&mut back, &[], None);
    let Figures { estimate, consistency, .. } = &back.figures;
    recording.figures.looking_back = Some(LookingBack { estimate: *estimate, consistency: consistency.clone() });
    back
}

/// The path, the end points and the final map moved, the truth and all else as it was.
fn look_back(recording: &Recording, rig: &Rig<MAX_SENSORS>, progress: &mut dyn FnMut(usize)) -> Option<Recording> {
    let keyframes = Keyframes::of(recording);
    let mut graph = Graph::new(recording, rig, &keyframes)?;
    let mut done = 0;
    let mut round = || {
        done += 1;
        progress(done);
    };
    graph.solve(ROUNDS, &mut round)?;
    unite(&mut graph, &mut round)?;
    for _ in 0..LABELLING_ROUNDS {
        let changed = labels::renew(&mut graph);
        graph.solve(ROUNDS_BETWEEN, &mut round)?;
        unite(&mut graph, &mut round)?;
        if changed == 0 {
            break;
        }
    }
    graph.solve(ROUNDS, &mut round)?;
    Some(moved(recording, &keyframes.path(recording, &graph.poses()), graph.walls()?))
}

/// Makes walls one that turn out to be one, as long as there are any.
fn unite(graph: &mut Graph, mut round: impl FnMut()) -> Option<()> {
    for _ in 0..MERGING_ROUNDS {
        if !twins::merge(graph) {
            break;
        }
        graph.solve(ROUNDS_BETWEEN, &mut round)?;
    }
    Some(())
}

/// The record with this path and map.
pub fn moved(recording: &Recording, path: &[Pose2], walls: Vec<WallView>) -> Recording {
    let mut back = recording.clone();
    let per_step = recording.sensors.len().max(1);
    for ((step, readings), pose) in back.steps.iter_mut().zip(back.readings.chunks_mut(per_step)).zip(path) {
        for hit in readings.iter_mut().filter_map(|reading| reading.hit_m.as_mut()) {
            let local = step.pose.relative(&Pose2::new(hit[0].into(), hit[1].into(), 0.0));
            *hit = pose.transform([local.x_m, local.y_m]).map(|metres| metres as f32);
        }
        // How sure a look back is was not asked. All of it is in one frame.
        *step = Step {
            pose: *pose,
            start: path[0],
            covariance: [[f32::NAN; 3]; 3],
            walls: walls.len(),
            searching: false,
            ..step.clone()
        };
    }
    back.figures.walls = walls.len();
    back.looks_back = true;
    back.title = format!("{}, looking back", recording.title);
    back.maps = vec![MapSnapshot { step: 0, walls }];
    back
}
