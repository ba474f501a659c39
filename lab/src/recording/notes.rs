//! What a user should know of a run though it is no error.

use std::collections::BTreeMap;

use slam_core::{Outcome, Refusal};

use super::{Pose2, Recording, Step, TruthFrame};
use crate::evaluate::statistics;
use crate::show::output::summary::refusal_name;

/// Longest time between two rows at which drives were tested, seconds, and what is as long but for its clock.
const SLOWEST_S: f64 = 0.34;
/// Rows so far apart are those of a clock that counts in something else than seconds.
const NO_SECONDS_S: f64 = 5.0;

/// No robot with wheels drives faster, m/s, and a row is not off by more than this, metres.
const FASTEST_MPS: f64 = 10.0;
const OFF_M: f64 = 1.0;
/// None turns faster, rad/s, and a row is not off by more than this, radians.
const FASTEST_RADPS: f64 = 10.0;
const OFF_RAD: f64 = 0.5;

/// A way, metres, and a turn, radians, over which odometry that is a few percent off is still good for millimetres.
const LEFT_M: f64 = 0.1;
const LEFT_RAD: f64 = 0.1;

/// Of fewer readings than these it is no wonder if none was used.
const MANY: usize = 500;

impl Recording {
    /// What a user should know of the run though it is no error.
    pub fn findings(&self) -> Vec<String> {
        let one =
            [self.never_found(), self.late_truth(), self.slow_rows(), self.jump(), self.spin(), self.bad_motion()];
        one.into_iter().flatten().chain(self.sensor_findings()).collect()
    }

    /// Of a robot that began in a kept map and never found itself there.
    fn never_found(&self) -> Option<String> {
        let is_lost = !self.steps.is_empty() && self.steps.iter().all(|step| step.carried);
        is_lost.then(|| {
            "the robot never found itself in the map that it began in: every pose and wall is of a fresh map, and map.bin is as it was; \
             is it another home's map? If it is this one's, a longer drive past more of its walls helps"
                .to_owned()
        })
    }

    /// Whether the first true pose is of a robot that had left its start, so that the truth's frame is not known in the map's.
    pub(crate) fn truth_begins_late(&self) -> bool {
        let Some(first) = self.steps.iter().position(|step| step.truth.is_some()) else { return false };
        let has_left =
            |Step { dead_reckoning: at, .. }: &Step| at.x_m.hypot(at.y_m) > LEFT_M || at.theta_rad.abs() > LEFT_RAD;
        self.truth_frame == TruthFrame::FirstPose && self.steps[..=first].iter().any(has_left)
    }

    pub(crate) fn late_truth(&self) -> Option<String> {
        let first = self.steps.iter().find(|step| step.truth.is_some()).filter(|_| self.truth_begins_late())?;
        Some(format!(
            "the first true pose is of t_s = {}, when the robot had left its start: true poses are moved to fit the estimate best, and \
             there is no error in the start frame and no NEES",
            first.t_text
        ))
    }

    fn slow_rows(&self) -> Option<String> {
        let apart: Vec<f64> = self.steps.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
        let apart_s = statistics::median(&apart)?;
        if apart_s >= NO_SECONDS_S {
            return Some(format!(
                "rows are {apart_s:.0} s apart; times are in seconds: are those of the log in milliseconds?"
            ));
        }
        (apart_s > SLOWEST_S)
            .then(|| format!("there are {:.1} rows a second; three are needed, five or more are good", 1.0 / apart_s))
    }

    /// A motion that no wheels make.
    fn jump(&self) -> Option<String> {
        let moved_m = |moved: &Pose2| moved.x_m.hypot(moved.y_m);
        let (first, apart_s, moved, count) = self.beyond(|moved, s| moved_m(moved) > FASTEST_MPS * s + OFF_M)?;
        Some(format!(
            "at t_s = {} the odometry goes {:.0} m in {apart_s:.2} s, the first of {count} such leaps: are counts or poses damaged or set anew there?",
            first.t_text,
            moved_m(&moved)
        ))
    }

    /// A turn that no wheels make.
    fn spin(&self) -> Option<String> {
        let (first, apart_s, moved, count) =
            self.beyond(|moved, s| moved.theta_rad.abs() > FASTEST_RADPS * s + OFF_RAD)?;
        Some(format!(
            "at t_s = {} the odometry turns {:.1} rad in {apart_s:.2} s, the first of {count} such turns: are headings in degrees, or damaged there?",
            first.t_text,
            moved.theta_rad.abs()
        ))
    }

    /// The first step whose motion from the one before is too far for the seconds between: these, the motion, and how many there are.
    fn beyond(&self, is_too_far: impl Fn(&Pose2, f64) -> bool) -> Option<(&Step, f64, Pose2, usize)> {
        let mut found = self.steps.windows(2).filter_map(|pair| {
            let moved = pair[0].dead_reckoning.relative(&pair[1].dead_reckoning);
            let apart_s = pair[1].t_s - pair[0].t_s;
            is_too_far(&moved, apart_s).then_some((&pair[1], apart_s, moved))
        });
        let (step, apart_s, moved) = found.next()?;
        Some((step, apart_s, moved, 1 + found.count()))
    }

    fn bad_motion(&self) -> Option<String> {
        let count = self.counters.bad_motion;
        let rows = if count == 1 { "a row".to_owned() } else { format!("{count} rows") };
        (count > 0).then(|| {
            format!("the motion of {rows} was left out: no robot moves so far, or so long, from one to the next")
        })
    }

    /// Of sensors whose readings are none, or are of no use.
    fn sensor_findings(&self) -> Vec<String> {
        let sensors: Vec<(&str, Readings)> =
            self.sensors.iter().enumerate().map(|(index, sensor)| (&*sensor.name, Readings::of(self, index))).collect();
        let mut all = Readings::default();
        sensors.iter().for_each(|(_, readings)| all.add(readings));
        let of_no_use = |of: &str, readings: &Readings| {
            format!("none of the {} readings{of} was used: {}", readings.all, readings.why())
        };
        let mut found = Vec::new();
        for (name, readings) in &sensors {
            if readings.invalid > 0 {
                found.push(format!(
                    "{} readings of sensor {name} are none: counts above 2^bits - 1, or ranges below 0 or without end",
                    readings.invalid
                ));
            }
            if all.used > 0 && readings.used == 0 && readings.all >= MANY {
                found.push(of_no_use(&format!(" of sensor {name}"), readings));
            }
        }
        if all.used == 0 && all.all >= MANY && 10 * all.refused() > 9 * all.all {
            let what =
                "the path is dead reckoning's; do min_m, max_m, curve and units of the rig file suit the sensors?";
            found.push(format!("{}; {what}", of_no_use("", &all)));
        }
        found
    }
}

/// What became of the readings of one sensor.
#[derive(Default)]
struct Readings {
    all: usize,
    used: usize,
    invalid: usize,
    refused: BTreeMap<&'static str, usize>,
}

impl Readings {
    fn of(recording: &Recording, sensor: usize) -> Self {
        let mut found = Self::default();
        for reading in recording.readings.iter().skip(sensor).step_by(recording.sensors.len()) {
            match reading.outcome {
                Outcome::Missing => continue,
                Outcome::Updated { .. } => found.used += 1,
                Outcome::Gated { .. } | Outcome::Unexplained => {}
                Outcome::Refused(refusal) => {
                    found.invalid += usize::from(refusal == Refusal::Invalid);
                    *found.refused.entry(refusal_name(refusal)).or_default() += 1;
                }
            }
            found.all += 1;
        }
        found
    }

    fn add(&mut self, other: &Self) {
        self.all += other.all;
        self.used += other.used;
        self.invalid += other.invalid;
        for (name, count) in &other.refused {
            *self.refused.entry(name).or_default() += count;
        }
    }

    fn refused(&self) -> usize {
        self.refused.values().sum()
    }

    /// What most of them were refused for.
    fn why(&self) -> String {
        match self.refused.iter().max_by_key(|(_, count)| **count) {
            Some((name, count)) => format!("{:.0} % were refused as {name}", 100.0 * *count as f64 / self.all as f64),
            None => "they met no wall that is known, or did not fit it".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::SensorInfo;
    use slam_core::ReadingReport;

    /// Rows so far apart in time of a robot that drives a centimetre from one to the next.
    fn drive(rows: usize, apart_s: f64) -> Recording {
        let step = |i: usize| Step {
            t_text: format!("{i}"),
            t_s: i as f64 * apart_s,
            dead_reckoning: Pose2::new(0.01 * i as f64, 0.0, 0.0),
            ..Step::default()
        };
        Recording { steps: (0..rows).map(step).collect(), ..Recording::default() }
    }

    fn only(recording: &Recording, words: &str) {
        let found = recording.findings();
        assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
    }

    #[test]
    fn a_good_drive_has_none() {
        assert!(drive(100, 0.04).findings().is_empty() && drive(100, 1.0 / 3.0).findings().is_empty());
        assert!(Recording::default().findings().is_empty());
    }

    #[test]
    fn rows_that_are_far_apart_are_told() {
        only(&drive(10, 1.0), "there are 1.0 rows a second; three are needed");
        only(&drive(10, 40.0), "in milliseconds?");
    }

    #[test]
    fn a_leap_of_the_odometry_is_told_with_its_row() {
        let mut leaping = drive(100, 0.04);
        leaping.steps[50..].iter_mut().for_each(|step| step.dead_reckoning.y_m = 445.0);
        only(&leaping, "at t_s = 50 the odometry goes 445 m in 0.04 s, the first of 1");
    }

    #[test]
    fn headings_in_degrees_are_told() {
        let mut turning = drive(100, 0.04);
        // A robot that turns 30 degrees a second.
        turning.steps.iter_mut().for_each(|step| step.dead_reckoning.theta_rad = (30.0 * step.t_s).to_radians());
        assert!(turning.findings().is_empty());
        turning.steps.iter_mut().for_each(|step| {
            step.dead_reckoning = Pose2::new(step.dead_reckoning.x_m, 0.0, 30.0 * step.t_s);
        });
        only(
            &turning,
            "at t_s = 1 the odometry turns 1.2 rad in 0.04 s, the first of 99 such turns: are headings in degrees",
        );
    }

    #[test]
    fn a_robot_that_never_found_itself_is_told() {
        let mut lost = drive(100, 0.04);
        lost.steps[..99].iter_mut().for_each(|step| step.carried = true);
        assert!(lost.findings().is_empty(), "it found itself in the last row");
        lost.steps[99].carried = true;
        only(&lost, "is it another home's map?");
    }

    #[test]
    fn a_sensor_without_use_is_told() {
        let mut recording = drive(MANY, 0.04);
        recording.sensors =
            ["front", "left"].map(|name| SensorInfo { name: name.into(), ..SensorInfo::default() }).into();
        let reading = |outcome| ReadingReport { outcome, ..ReadingReport::default() };
        let used = reading(Outcome::Updated { wall: 1, innovation_m: 0.0, variance_m2: 1.0, noise_m2: 1.0 });
        let floor = reading(Outcome::Refused(Refusal::Floor));
        recording.readings = [used, floor].repeat(MANY);
        only(&recording, "none of the 500 readings of sensor left was used: 100 % were refused as floor");
        recording.readings[0] = reading(Outcome::Refused(Refusal::Invalid));
        assert!(recording.findings()[0].contains("1 readings of sensor front are none: counts above 2^bits - 1"));
        recording.readings = vec![floor; 2 * MANY];
        only(
            &recording,
            "none of the 1000 readings was used: 100 % were refused as floor; the path is dead reckoning's; do min_m",
        );
    }
}
