//! How the estimator was over a run.

use slam_core::{Health, Outcome, Refusal};

use super::Recording;

/// A stretch of time in which the estimator was not well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illness {
    /// What it was.
    pub health: Health,
    /// When it began, seconds after the first row.
    pub begin_s: f64,
    /// When it was over; none where it lasted to the end.
    pub end_s: Option<f64>,
}

/// A stretch of time in which a range sensor was frozen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Freeze {
    /// Its place in the rig's list.
    pub sensor: usize,
    /// When it was found so, seconds after the first row.
    pub begin_s: f64,
    /// When it was believed again; none where it lasted to the end.
    pub end_s: Option<f64>,
    /// Readings that were refused for it.
    pub refused: usize,
}

/// The word for a health.
pub fn name(health: Health) -> &'static str {
    match health {
        Health::Well => "well",
        Health::Unexplained => "unexplained",
        Health::Contradicted => "contradicted",
        Health::Disoriented => "disoriented",
        Health::Degenerate => "degenerate",
    }
}

impl Recording {
    /// Every stretch of time in which the estimator was not well, in order.
    pub fn illnesses(&self) -> Vec<Illness> {
        let mut found: Vec<Illness> = Vec::new();
        let mut last = Health::Well;
        for step in &self.steps {
            if step.health == last {
                continue;
            }
            if let Some(illness) = found.last_mut().filter(|illness| illness.end_s.is_none()) {
                illness.end_s = Some(step.t_s);
            }
            if step.health != Health::Well {
                found.push(Illness { health: step.health, begin_s: step.t_s, end_s: None });
            }
            last = step.health;
        }
        found
    }

    /// Every stretch of time in which a range sensor was frozen, in order.
    pub fn freezes(&self) -> Vec<Freeze> {
        let mut found: Vec<Freeze> = Vec::new();
        for (row, step) in self.steps.iter().enumerate() {
            for (sensor, reading) in self.readings(row).iter().enumerate() {
                let last = found.iter_mut().rfind(|freeze| freeze.sensor == sensor && freeze.end_s.is_none());
                match (reading.outcome, last) {
                    (Outcome::Refused(Refusal::Frozen), Some(freeze)) => freeze.refused += 1,
                    (Outcome::Refused(Refusal::Frozen), None) => {
                        found.push(Freeze { sensor, begin_s: step.t_s, end_s: None, refused: 1 });
                    }
                    (Outcome::Missing | Outcome::Refused(Refusal::Held), _) | (_, None) => {}
                    (_, Some(freeze)) => freeze.end_s = Some(step.t_s),
                }
            }
        }
        found
    }

    /// What is wrong with the estimate in the end, in words: a number that is none, or an estimator that is not well.
    pub fn complaint(&self) -> Option<String> {
        let unwell = || {
            let illness = self.illnesses().into_iter().next_back().filter(|illness| illness.end_s.is_none())?;
            let what = match illness.health {
                Health::Well => return None,
                Health::Unexplained => {
                    "no reading fits a wall; do bearings, ranges and noise of the rig file suit the robot?"
                }
                Health::Contradicted => "most readings contradict the map, which was begun anew",
                Health::Disoriented => "the heading is not known against the map, which was begun anew",
                Health::Degenerate => "the covariance was none, and the map was begun anew",
            };
            Some(format!(
                "from {:.1} s to the end the estimator is not well ({}): {what}",
                illness.begin_s,
                name(illness.health)
            ))
        };
        self.fault().or_else(unwell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Step;

    fn recording(healths: &[Health]) -> Recording {
        let step = |(i, health): (usize, &Health)| Step { t_s: i as f64, health: *health, ..Step::default() };
        Recording { steps: healths.iter().enumerate().map(step).collect(), ..Recording::default() }
    }

    #[test]
    fn illnesses_begin_and_end() {
        use Health::{Contradicted, Degenerate, Well};
        let found = recording(&[Well, Contradicted, Contradicted, Degenerate, Well, Well, Degenerate]).illnesses();
        let expected = [(Contradicted, 1.0, Some(3.0)), (Degenerate, 3.0, Some(4.0)), (Degenerate, 6.0, None)];
        assert_eq!(found, expected.map(|(health, begin_s, end_s)| Illness { health, begin_s, end_s }));
    }

    #[test]
    fn what_is_over_is_no_complaint_and_what_lasts_is() {
        assert_eq!(recording(&[Health::Well, Health::Degenerate, Health::Well]).complaint(), None);
        let complaint = recording(&[Health::Well, Health::Unexplained]).complaint().expect("it lasts");
        assert!(complaint.starts_with("from 1.0 s to the end the estimator is not well (unexplained)"), "{complaint}");
    }
}
