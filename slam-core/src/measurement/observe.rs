//! One scalar update for every reading: association, gate, Jacobian (report 3.1 and 3.2).

use crate::config::WallPolicy;
use crate::filter::ekf::Jacobian;
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::geometry::angle::sin_cos;
use crate::measurement::beam::{Beam, FixedMount, Prediction};
use crate::measurement::data_association;
use crate::measurement::line_of_sight::{Candidate, first_met, prolongation_m};
use crate::report::{Outcome, Refusal, StepReport};
use crate::rig::{RangeModel, RangeSensor};
use crate::sample::{Increment, RangeInput, Sample};
use crate::sensing::correlation::Hit;
use crate::sensing::noise_level::Expected;
use crate::sensing::range::{Noise, Reading, SHARP_HOLD_S, SURFACE_M};
use crate::slam::Slam;
use crate::walls::manhattan::GridDirection;
use crate::walls::wall::{Direction, Wall};

/// Walls that one beam is held against: beyond its end a wall may go on or not, and at a corner two may.
const MAX_CANDIDATES: usize = 4;

/// Readings are used from this share above the minimum range on: under it the curve bends before it folds back, and a
/// folded reading looks like one just above it.
const NEAR_SHARE: f32 = 0.15;

/// Within this distance of a wall's ends, and beyond them, another surface may be the one that was met, metres.
const END_M: f32 = 0.1;

/// A wall nearer than this share of a sensor's maximum range is seen, if it is there.
const ABSENCE_SHARE: f32 = 0.7;

/// And if the beam meets it this far from its ends, metres: a beam that finds nothing tells less than one that goes on.
const ABSENCE_M: f32 = 0.08;

/// Gate near a wall's ends: 95 % of a chi-square distribution with one degree of freedom.
const END_GATE: f32 = 3.84;

/// A beam that passes this far inside a wall's extent went through it: an extent is known to that, metres. A row of two
/// chair legs is half a metre long, and beams go through most of it.
const PASS_M: f32 = 0.05;

/// "This reading came from that wall."
struct Hypothesis {
    /// Identifier of the wall.
    wall: u16,
    candidate: Candidate,
    /// What the sensor should report, metres.
    predicted_m: f32,
    /// Variance of the sensor's own noise there, m^2.
    sensor_m2: f32,
    innovation_m: f32,
    jacobian: Jacobian,
    /// Variance of the prediction, m^2.
    known_m2: f32,
    /// Variance of the noise with which the filter takes the reading, m^2.
    noise_m2: f32,
    /// Innovation variance, m^2.
    variance_m2: f32,
    /// What else may be met, metres of the beam.
    span_m: f32,
    /// So near the wall's end, or past it, that another surface is possible.
    at_end: bool,
    /// Inside the gate.
    explains: bool,
    /// Outside the gate, but so near to the wall's end, and to the wall, that it may be its own.
    nearly: bool,
}

impl Hypothesis {
    /// A tenth of a millimetre behind this wall, so that rounding does not bring it again.
    fn beyond_m(&self) -> f32 {
        self.candidate.range_m + 1e-4
    }

    fn updated(&self) -> Outcome {
        Outcome::Updated { wall: self.wall, innovation_m: self.innovation_m, variance_m2: self.variance_m2 }
    }

    fn gated(&self) -> Outcome {
        Outcome::Gated { wall: self.wall, innovation_m: self.innovation_m, variance_m2: self.variance_m2 }
    }
}

/// How much a motion in the robot's frame changes the range, metres.
fn change_m(prediction: &Prediction, (sin, cos): (f32, f32), i: Increment) -> f32 {
    let moved = [cos * i.forward_m - sin * i.left_m, sin * i.forward_m + cos * i.left_m];
    prediction.by_position[0] * moved[0] + prediction.by_position[1] * moved[1] + prediction.by_heading * i.turn_rad
}

/// Whether the sensor can see the wall that it is said to have seen.
fn check_limits(limits: &RangeSensor, min_cos: f32, met: &Hypothesis) -> Result<(), Refusal> {
    if met.candidate.cos_incidence < min_cos {
        return Err(Refusal::Incidence);
    }
    // A reading that only its noise brought inside the sensor's limits is a biased one.
    let margin_m = 2.0 * libm::sqrtf(met.sensor_m2);
    if met.predicted_m > limits.max_m - margin_m {
        return Err(Refusal::TooFar);
    }
    if met.predicted_m < limits.min_m + margin_m.max(NEAR_SHARE * limits.min_m) {
        return Err(Refusal::TooNear);
    }
    Ok(())
}

impl<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> Slam<S, W, B, NB, BLOCKS> {
    /// One scalar update for every reading (report eq. 3).
    pub(crate) fn observe(&mut self, sample: &Sample<S>, report: &mut StepReport<S>) {
        for (i, (input, report)) in sample.ranges.iter().zip(&mut report.readings).enumerate() {
            let (Some(sensor), Some(front_end)) = (self.rig.sensors.get(i), self.front_ends.get_mut(i)) else { break };
            if *input == RangeInput::Missing {
                continue;
            }
            let path_m = self.odometry.path_m;
            let reading = match front_end.read(sensor, self.rig.adc.as_ref(), *input, self.dt_s, path_m) {
                Ok(reading) => reading,
                Err(refusal) => {
                    if matches!(refusal, Refusal::TooFar | Refusal::Floor) {
                        self.judge_absence(i);
                    }
                    report.outcome = self.refuse(refusal);
                    continue;
                }
            };
            let gain = self.gain(i);
            report.range_m = Some(reading.range_m / gain);
            report.outcome = match self.associate(i, &reading) {
                Ok(outcome) => outcome,
                Err(refusal) => self.refuse(refusal),
            };
            let count = match report.outcome {
                Outcome::Unexplained => &mut self.counters.unexplained,
                Outcome::Gated { .. } => &mut self.counters.gated,
                _ => continue,
            };
            *count = count.saturating_add(1);
            self.keep_outlier(i, &reading);
        }
    }

    fn refuse(&mut self, refusal: Refusal) -> Outcome {
        if let Some(count) = self.counters.refused.get_mut(refusal as usize) {
            *count = count.saturating_add(1);
        }
        Outcome::Refused(refusal)
    }

    /// The mount as it was when the reading was made: an analogue sensor's is half a hold old when it comes out, and has
    /// been held for half a sampling period, or hold, on average. How old one in metres is, is estimated.
    pub(crate) fn mount_then(&self, sensor: usize) -> FixedMount {
        let mount = self.mounts.get(sensor).copied().unwrap_or_else(|| FixedMount::new(&Default::default()));
        let lagging =
            |ratio: f32, i: Increment| mount.lagging([ratio * i.forward_m, ratio * i.left_m], ratio * i.turn_rad);
        if let Some(latency) = self.latency_of(sensor) {
            return lagging(1.0, self.pace.over(self.ekf.mean(latency)));
        }
        let holds = self.rig.sensors.get(sensor).is_some_and(|s| matches!(s.model, RangeModel::Sharp { .. }));
        if !holds || self.dt_s <= 0.0 {
            return mount;
        }
        let age_s = 0.5 * (SHARP_HOLD_S + self.dt_s.min(SHARP_HOLD_S));
        lagging(age_s / self.dt_s, self.last_step.increment)
    }

    fn position(&self) -> [f32; 2] {
        [self.ekf.mean(X), self.ekf.mean(Y)]
    }

    /// Finds the wall that the beam meets and updates with it.
    fn associate(&mut self, sensor: usize, reading: &Reading) -> Result<Outcome, Refusal> {
        let heading = sin_cos(self.ekf.mean(THETA));
        let beam = self.mount_then(sensor).beam(self.position(), heading);
        let (Some(&limits), Some(&min_cos)) = (self.rig.sensors.get(sensor), self.min_cos.get(sensor)) else {
            return Err(Refusal::Invalid);
        };
        let mut outcome = Outcome::Unexplained;
        let mut beyond_m = 0.0;
        let mut nearly = false;
        for _ in 0..MAX_CANDIDATES {
            let met = self.hypothesis(sensor, reading, &beam, heading, beyond_m);
            let Some(met) = &met else { break };
            if beyond_m == 0.0 {
                self.learn_noise(sensor, reading, met);
            }
            beyond_m = met.beyond_m();
            if met.explains {
                check_limits(&limits, min_cos, met)?;
                // Past a wall's end the beam may have gone on: then the reading must not fit what stands there, too.
                if met.at_end {
                    let next = self.hypothesis(sensor, reading, &beam, heading, beyond_m);
                    if next.is_some_and(|next| next.explains) {
                        return Err(Refusal::Ambiguous);
                    }
                }
                let noise_m2 = self.weighed(met) * self.repeated(sensor, reading, met);
                self.ekf.update(met.innovation_m, &met.jacobian, noise_m2).map_err(|_| Refusal::Degenerate)?;
                self.counters.updates = self.counters.updates.saturating_add(1);
                self.map.met(met.candidate.index, met.candidate.along_m, self.odometry.path_m);
                return Ok(met.updated());
            }
            nearly |= met.nearly;
            if outcome == Outcome::Unexplained {
                outcome = met.gated();
            }
            if met.candidate.inside_m > 0.0 {
                self.judge_pass(met);
                break;
            }
        }
        // At an end it is in doubt whose reading this is: as a new wall's it would turn that one.
        if nearly { Err(Refusal::Ambiguous) } else { Ok(outcome) }
    }

    fn first_met(&self, beam: &Beam, beyond_m: f32, within_m: f32) -> Option<Candidate> {
        let grid = GridDirection::of(&self.ekf);
        let prolongation_m = prolongation_m(self.last_step.path_m);
        first_met(&self.ekf, &grid, self.map.walls(), beam, beyond_m, within_m, prolongation_m)
    }

    /// The next wall along the beam, and how the reading would fit it.
    fn hypothesis(
        &self,
        sensor: usize,
        reading: &Reading,
        beam: &Beam,
        heading: (f32, f32),
        beyond_m: f32,
    ) -> Option<Hypothesis> {
        let limits = self.rig.sensors.get(sensor)?;
        let within_m = 1.5 * limits.max_m;
        let candidate = self.first_met(beam, beyond_m, within_m)?;
        let wall = self.map.walls().get(candidate.index)?;
        let gain = self.gain(sensor);
        let prediction = beam.predict(&candidate.line);
        let predicted_m = gain * prediction.range_m;
        let innovation = reading.innovation(predicted_m);
        let mut jacobian = self.jacobian(sensor, gain, wall, &self.linearise(wall, &candidate.line, &prediction));
        if let Some(latency) = self.latency_of(sensor) {
            // What is older shows less of the change. The capacity is more than twice what a measurement has.
            let _ = jacobian.push((latency, -gain * change_m(&prediction, heading, self.pace.over(1.0))));
        }
        // What stands out of a wall's plane is met so much earlier along a slanting beam.
        let relief_m = self.config.relief_m / candidate.cos_incidence;
        let surface_m2 = SURFACE_M * SURFACE_M + relief_m * relief_m;
        let white_m2 = innovation.noise_m2 + surface_m2 + self.timing_variance(sensor, &prediction, heading);
        let stride_m = self.last_step.path_m + (self.last_step.increment.turn_rad * candidate.range_m).abs();
        let at_end = candidate.inside_m < END_M.max(stride_m);
        // Where two surfaces are possible, the reading says half as much. But it must fit by its own noise, where that is
        // known: an analogue sensor's is electric, while one that reports metres has errors of the surface, too.
        let noise_m2 = if at_end { 4.0 * white_m2 } else { white_m2 };
        let is_analogue = matches!(reading.noise, Noise::Volts { .. });
        let own_m2 = if is_analogue { white_m2 } else { noise_m2 };
        let gate = if at_end { self.config.gate.min(END_GATE) } else { self.config.gate };
        let known_m2 = self.ekf.variance(&jacobian);
        let level = self.levels.readings.factor();
        let variance_m2 = known_m2 + level * noise_m2;
        let innovation_m = innovation.value_m;
        let square_m2 = innovation_m * innovation_m;
        let fits_m2 = known_m2 + level * own_m2;
        let span_m = limits.max_m - limits.min_m;
        let likelier = !self.config.clutter || data_association::odds(innovation_m, fits_m2, span_m) >= 1.0;
        Some(Hypothesis {
            wall: wall.id,
            candidate,
            predicted_m,
            sensor_m2: innovation.noise_m2,
            innovation_m,
            jacobian,
            known_m2,
            noise_m2,
            variance_m2,
            span_m,
            at_end,
            explains: likelier && square_m2 <= gate * fits_m2,
            nearly: at_end && is_analogue && square_m2 <= self.config.gate * variance_m2,
        })
    }

    /// The noise of a reading that may yet be of something else.
    fn weighed(&self, met: &Hypothesis) -> f32 {
        if !self.config.clutter {
            return met.noise_m2;
        }
        let odds = data_association::odds(met.innovation_m, met.variance_m2, met.span_m);
        data_association::noise_m2(met.noise_m2, met.known_m2 + met.noise_m2, odds)
    }

    /// What the nearest wall's innovation says of the noise of readings and of motion, as far as the reading is its.
    fn learn_noise(&mut self, sensor: usize, reading: &Reading, met: &Hypothesis) {
        if !self.config.learn_noise || !matches!(reading.noise, Noise::Metres { .. }) {
            return;
        }
        let odds = data_association::odds(met.innovation_m, met.variance_m2, met.span_m);
        let alike = self.repeats.count(sensor, met.wall, met.candidate.along_m, self.counters.steps);
        let [.., by_heading, _] = *met.jacobian.head();
        let expected = Expected {
            innovation_m: met.innovation_m,
            variance_m2: met.variance_m2,
            noise_m2: met.variance_m2 - met.known_m2,
            heading_m2: by_heading * by_heading * self.ekf.covariance(THETA, THETA),
        };
        self.levels.note(&expected, odds / (1.0 + odds) / alike);
    }

    /// Of how many readings this is one that say the same; it is taken note of.
    fn repeated(&mut self, sensor: usize, reading: &Reading, met: &Hypothesis) -> f32 {
        // An analogue sensor's noise is electric, and new with each reading.
        if !self.config.repeats || !matches!(reading.noise, Noise::Metres { .. }) {
            return 1.0;
        }
        let (wall, along_m, step) = (met.wall, met.candidate.along_m, self.counters.steps);
        let count = self.repeats.count(sensor, wall, along_m, step);
        let normalised = met.innovation_m / libm::sqrtf(met.variance_m2);
        self.repeats.note(sensor, Hit { wall, along_m, step, normalised });
        count
    }

    /// A reading well beyond a wall, well inside its extent, went through it.
    fn judge_pass(&mut self, met: &Hypothesis) {
        let margin_m = 0.1 + 3.0 * libm::sqrtf(met.variance_m2);
        if met.innovation_m > margin_m && met.candidate.inside_m > PASS_M {
            self.map.passed_through(met.candidate.index);
        }
    }

    /// A beam that found nothing within its range, where it should have met a wall well within it, went through the wall.
    fn judge_absence(&mut self, sensor: usize) {
        let (Some(limits), Some(&min_cos)) = (self.rig.sensors.get(sensor), self.min_cos.get(sensor)) else { return };
        let heading = sin_cos(self.ekf.mean(THETA));
        let beam = self.mount_then(sensor).beam(self.position(), heading);
        let Some(met) = self.first_met(&beam, 0.0, ABSENCE_SHARE * limits.max_m) else { return };
        if met.inside_m > ABSENCE_M && met.cos_incidence > min_cos {
            self.map.passed_through(met.index);
        }
    }

    /// 1-sigma of the time at which an analogue reading was made, as a share of the last step: uniform within a sampling
    /// period or hold. Zero for a sensor that reports metres.
    pub(crate) fn timing_share(&self, sensor: usize) -> f32 {
        let holds = self.rig.sensors.get(sensor).is_some_and(|s| matches!(s.model, RangeModel::Sharp { .. }));
        if !holds || self.dt_s <= 0.0 {
            return 0.0;
        }
        const UNIFORM: f32 = 0.288_675_13; // 1 / sqrt(12)
        UNIFORM * self.dt_s.min(SHARP_HOLD_S) / self.dt_s
    }

    /// Variance of a reading from not knowing when it was made, m^2.
    fn timing_variance(&self, sensor: usize, prediction: &Prediction, heading: (f32, f32)) -> f32 {
        let spread_m = change_m(prediction, heading, self.last_step.increment) * self.timing_share(sensor);
        spread_m * spread_m
    }

    /// Row of the measurement Jacobian, at most seven entries.
    fn jacobian(&self, sensor: usize, gain: f32, wall: &Wall, prediction: &Prediction) -> Jacobian {
        let mut row = Jacobian::new();
        let mut push = |i: usize, derivative: f32| {
            // The capacity is three times what a measurement has.
            let _ = row.push((i, derivative));
        };
        push(X, gain * prediction.by_position[0]);
        push(Y, gain * prediction.by_position[1]);
        push(THETA, gain * prediction.by_heading);
        match wall.direction {
            Direction::Grid(_) => push(ALPHA, gain * prediction.by_beta),
            Direction::Free(theta) | Direction::NearGrid(theta, _) => push(theta, gain * prediction.by_beta),
            Direction::Snapped(theta) => {
                push(ALPHA, gain * prediction.by_beta);
                if self.config.walls == (WallPolicy::Snapped { theta_moves: true }) {
                    push(theta, gain * prediction.by_beta);
                }
            }
        }
        push(wall.rho, gain * prediction.by_rho);
        if let Some(state) = self.layout.gains.get(sensor).copied().flatten() {
            push(state, prediction.range_m);
        }
        row
    }

    /// Where the beams ended, with the pose after the step.
    pub(crate) fn place_hits(&self, report: &mut StepReport<S>) {
        let heading = sin_cos(self.ekf.mean(THETA));
        for (i, reading) in report.readings.iter_mut().enumerate() {
            let beam: Beam = self.mount_then(i).beam(self.position(), heading);
            reading.hit_m = reading.range_m.map(|range_m| self.point_in_map(beam.at(range_m)));
        }
    }
}
