//! Which wall each reading ended on.

use super::graph::Graph;
use super::seen::{Beam, Meeting, SIGMAS, STRETCH_M, Seen};

/// A wall may go on so far beyond the readings that are on it, metres: half a stretch.
const BEYOND_M: f64 = 0.5 * STRETCH_M;

/// Gives each reading to the wall that it ended on, whatever the filter took it for: of those within three sigma the nearest.
/// A wall that more readings went through than ended on is not there. How many readings were given to another one.
pub fn renew(graph: &mut Graph) -> usize {
    let (seen, beams) = (graph.seen(), graph.beams());
    let most = seen.iter().map(|wall| wall.wall + 1).max().unwrap_or(0);
    let (mut on, mut through) = (vec![0usize; most], vec![0usize; most]);
    let mut labels = Vec::with_capacity(beams.len());
    for beam in &beams {
        let met: Vec<(&Seen, Meeting)> = seen.iter().filter_map(|wall| Some((wall, wall.meet(beam)?))).collect();
        for (wall, _) in met.iter().filter(|(wall, meeting)| went_through(wall, meeting, beam)) {
            through[wall.wall] += 1;
        }
        let ended_on = met.iter().filter(|(wall, meeting)| is_on(wall, meeting, beam));
        let nearest = ended_on.min_by(|a, b| a.1.behind_m.abs().total_cmp(&b.1.behind_m.abs()));
        let label = nearest.map(|(wall, _)| wall.wall);
        if let Some(wall) = label {
            on[wall] += 1;
        }
        labels.push(label);
    }
    for label in &mut labels {
        *label = label.filter(|wall| on[*wall] >= through[*wall]);
    }
    let changed = labels.iter().zip(&beams).filter(|(label, beam)| **label != beam.wall).count();
    graph.give(&labels);
    changed
}

fn is_on(wall: &Seen, meeting: &Meeting, beam: &Beam) -> bool {
    let [begin_m, end_m] = wall.span_m;
    let is_along = (begin_m - BEYOND_M..=end_m + BEYOND_M).contains(&meeting.along_m);
    is_along && meeting.behind_m.abs() < SIGMAS * beam.sigma_m
}

fn went_through(wall: &Seen, meeting: &Meeting, beam: &Beam) -> bool {
    let is_within = |along_m: f64| (wall.span_m[0]..=wall.span_m[1]).contains(&along_m);
    meeting.through_m.is_some_and(is_within) && meeting.behind_m > SIGMAS * beam.sigma_m
}
