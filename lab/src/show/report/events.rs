//! What befell the map: hand-overs of look backs, searches for the place in the kept map, when that was not known, and how the
//! estimator was.

use serde_json::{Value, json};

use super::data::shown_index;
use crate::recording::health::{self, Illness};
use crate::recording::{HandOver, Recording};
use crate::run::Searched;
use crate::show::output::summary::refused_name;

/// The events for the page, at the steps that it shows; `place.js` of the view modules is the other end.
pub fn events(recording: &Recording, shown: &[usize]) -> Value {
    let hand_over = |found: &HandOver| {
        let step = shown_index(shown, found.step);
        json!({
            "step": step,
            "before": step.saturating_sub(1),
            "refused": found.refused.map(refused_name),
            "moved_m": found.moved.x_m.hypot(found.moved.y_m),
            "turned_rad": found.moved.theta_rad,
        })
    };
    let search = |search: &Searched| json!({ "step": shown_index(shown, search.step), "log_odds": search.log_odds, "walls": search.walls });
    json!({
        "hand_overs": recording.hand_overs.iter().map(hand_over).collect::<Vec<_>>(),
        "searches": recording.searches.iter().map(search).collect::<Vec<_>>(),
        "lost": lost(recording, shown),
        "condition": condition(recording),
    })
}

/// How the estimator was, and what it noticed of what befell the robot.
fn condition(recording: &Recording) -> Value {
    let illness = |Illness { health, begin_s, end_s }| json!({ "what": health::name(health), "begin_s": begin_s, "end_s": end_s });
    let counters = &recording.counters;
    json!({
        "at_end": recording.steps.last().map_or("well", |step| health::name(step.health)),
        "unwell": recording.illnesses().into_iter().map(illness).collect::<Vec<_>>(),
        "jolts": counters.jolts,
        "holds": counters.holds,
        "restarts": counters.restarts,
    })
}

/// First shown step of each stretch in which the place was not known, and the first after it.
fn lost(recording: &Recording, shown: &[usize]) -> Vec<[usize; 2]> {
    let mut stretches: Vec<[usize; 2]> = Vec::new();
    for (at, _) in shown.iter().enumerate().filter(|(_, step)| recording.steps[**step].searching) {
        match stretches.last_mut() {
            Some(stretch) if stretch[1] == at => stretch[1] = at + 1,
            _ => stretches.push([at, at + 1]),
        }
    }
    stretches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Step;

    #[test]
    fn a_stretch_begins_where_the_place_is_lost_and_ends_where_it_is_found() {
        let step = |searching| Step { searching, ..Step::default() };
        let recording =
            Recording { steps: [true, true, false, false, true].map(step).to_vec(), ..Recording::default() };
        assert_eq!(lost(&recording, &[0, 1, 2, 3, 4]), [[0, 2], [4, 5]]);
        assert_eq!(lost(&recording, &[0, 3]), [[0, 1]]);
        assert!(lost(&Recording::default(), &[]).is_empty());
    }
}
