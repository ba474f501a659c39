//! One scalar update for every reading: association, gate, Jacobian (Rousse & Qiu 3.1 and 3.2).

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::{THETA, X, Y};
use crate::geometry::angle::sin_cos;
use crate::measurement::MeasurementSettings;
use crate::measurement::beam::{Beam, Prediction};
use crate::measurement::data_association;
use crate::measurement::derivatives::by_pose_and_wall;
use crate::measurement::first_estimates::{FirstEstimates, Linearisation};
use crate::measurement::line_of_sight::{Candidate, first_met, prolongation_m};
use crate::measurement::sensor::Sensor;
use crate::report::{Outcome, Refusal};
use crate::rig::RangeSensor;
use crate::sample::Increment;
use crate::sensing::SensingSettings;
use crate::sensing::correlation::{Hit, SurfaceCorrelationView};
use crate::sensing::latency::Timing;
use crate::sensing::noise_level::{Expected, NoiseLevels};
use crate::sensing::range::{NEAR_SHARE, Noise, Reading, SURFACE_M, is_folded};
use crate::walls::WallSettings;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapView;
use crate::walls::wall::{Wall, WallPolicy};

/// Number of walls that one beam is compared with: a wall may go on beyond its end, and two may meet at a corner.
const MAX_CANDIDATES: usize = 4;

/// Distance from a wall's ends within which the beam may have met another surface, metres.
const END_M: f32 = 0.1;

/// Share of a sensor's maximum range within which a wall that is there is seen.
const ABSENCE_SHARE: f32 = 0.7;

/// Distance from a wall's ends beyond which a beam that finds nothing shows that the wall is gone, metres: it tells less
/// than a beam that goes on.
const ABSENCE_M: f32 = 0.08;

/// Gate near a wall's ends: 95 % of a chi-square distribution with one degree of freedom.
const END_GATE: f32 = 3.84;

/// Distance inside a wall's extent at which a passing beam went through the wall, metres: what an extent is known to. A row
/// of two chair legs is half a metre long, and beams go through most of it.
const PASS_M: f32 = 0.05;

/// Where the pose tells a range to this share of the sensor's span, one reading can tell which wall it is of. Where it does
/// not, it takes a line of them. At a quarter two walls half a span apart are still told from one another by two sigma; at an
/// eighth a robot with five samples a second refuses the readings that would mend its heading (tests/tests/slow_logs.rs).
const TOLD_SHARE: f32 = 0.25;

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
    /// Why a reading outside the gate may be its own: so near to the wall, and to its end, or folded back.
    doubt: Option<Refusal>,
}

impl Hypothesis {
    /// A tenth of a millimetre behind this wall, so that rounding does not bring it again.
    fn beyond_m(&self) -> f32 {
        self.candidate.range_m + 1e-4
    }

    fn updated(&self, noise_m2: f32) -> Outcome {
        Outcome::Updated { wall: self.wall, innovation_m: self.innovation_m, variance_m2: self.variance_m2, noise_m2 }
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
    // A reading that only its noise brought inside the sensor's limits is a biased one. A square root takes longer.
    let is_less = |room_m: f32| room_m < 0.0 || room_m * room_m < 4.0 * met.sensor_m2;
    if is_less(limits.max_m - met.predicted_m) {
        return Err(Refusal::TooFar);
    }
    let from_near_m = met.predicted_m - limits.min_m;
    if is_less(from_near_m) || from_near_m < NEAR_SHARE * limits.min_m {
        return Err(Refusal::TooNear);
    }
    Ok(())
}

/// The readings of one step against the map: what they are held against, and what they change.
pub struct Observer<'a> {
    /// Settings of this stage.
    pub settings: &'a MeasurementSettings,
    /// What is learned of the errors of readings.
    pub sensing: &'a SensingSettings,
    /// What walls there are, and how far their surfaces are from planes.
    pub walls: &'a WallSettings,
    /// The state.
    pub ekf: &'a mut EkfView,
    /// The walls.
    pub map: &'a mut MapView,
    /// How large the noise is.
    pub levels: &'a mut NoiseLevels,
    /// How readings repeat one another.
    pub correlation: &'a mut SurfaceCorrelationView,
    /// What the models are differentiated at.
    pub first: &'a FirstEstimates,
    /// When the readings were made.
    pub timing: Timing<'a>,
    /// Length of the path so far, metres.
    pub path_m: f32,
    /// Number of the step, from 1.
    pub number: u32,
    /// Where the last reading was due that met or should have met a wall, metres along that.
    pub along_m: f32,
}

/// A reading and the beam that it was made along.
struct Sight<'a> {
    sensor: &'a Sensor<'a>,
    reading: &'a Reading,
    beam: Beam,
    /// Sine and cosine of the robot's heading.
    heading: (f32, f32),
}

impl Observer<'_> {
    /// Direction of the normal of the wall of this identifier in the robot's frame, radians.
    pub fn normal_rad(&self, wall: u16) -> Option<f32> {
        let wall = self.map.walls().iter().find(|other| other.id == wall)?;
        Some(wall.beta_rad(self.ekf) - self.ekf.mean(THETA))
    }

    /// Finds the wall that the beam met and updates with the reading (Rousse & Qiu eq. 3).
    ///
    /// # Errors
    /// Why the reading is neither used nor an outlier.
    pub fn observe(&mut self, sensor: &Sensor, reading: &Reading) -> Result<Outcome, Refusal> {
        let heading = sin_cos(self.ekf.mean(THETA));
        let sight = Sight { sensor, reading, beam: self.beam(sensor, heading), heading };
        let mut outcome = Outcome::Unexplained;
        let mut beyond_m = 0.0;
        let mut doubt = None;
        for _ in 0..MAX_CANDIDATES {
            let Some(met) = &self.hypothesis(&sight, beyond_m) else { break };
            // Not a number is not a variance, either.
            if !(met.variance_m2 > 0.0 && met.variance_m2 <= f32::MAX) {
                return Err(Refusal::Degenerate);
            }
            if beyond_m == 0.0 {
                self.learn_noise(&sight, met);
            }
            beyond_m = met.beyond_m();
            if met.explains {
                check_limits(sensor.limits, sensor.state.min_cos, met)?;
                // Past a wall's end the beam may have gone on: then the reading must not fit what stands there, too.
                if met.at_end && self.hypothesis(&sight, beyond_m).is_some_and(|next| next.explains) {
                    return Err(Refusal::Ambiguous);
                }
                self.along_m = met.candidate.along_m;
                let noise_m2 = self.update(&sight, met)?;
                self.map.met(met.candidate.index, met.candidate.along_m, self.path_m);
                return Ok(met.updated(noise_m2));
            }
            doubt = doubt.or(met.doubt);
            if outcome == Outcome::Unexplained {
                (outcome, self.along_m) = (met.gated(), met.candidate.along_m);
            }
            if met.candidate.inside_m > 0.0 {
                self.judge_pass(met);
                break;
            }
        }
        // A reading of a known wall that is taken for a new one's turns the new one.
        doubt.map_or(Ok(outcome), Err)
    }

    /// Why a reading is not used while it is in doubt where the robot is.
    pub fn why_not(&self, sensor: &Sensor, reading: &Reading) -> Refusal {
        let limits = sensor.limits;
        let beam = self.beam(sensor, sin_cos(self.ekf.mean(THETA)));
        let met = self.first_met(&beam, 0.0, 2.0 * limits.min_m).filter(|met| met.inside_m > 0.0);
        match met {
            Some(met) if is_folded(limits, met.range_m, reading.range_m) => Refusal::FoldBack,
            _ => Refusal::Ambiguous,
        }
    }

    /// Corrects the estimate: with which variance of noise, m^2.
    fn update(&mut self, sight: &Sight, met: &Hypothesis) -> Result<f32, Refusal> {
        let own_m2 = self.weighed(met);
        // An analogue sensor's noise is electric, and new with each reading.
        if matches!(sight.reading.noise, Noise::Volts { .. }) {
            return self.correct(met, own_m2);
        }
        let noise_m2 = own_m2 * self.repeated(sight, met);
        if !self.sensing.bends {
            return self.correct(met, noise_m2);
        }
        let [before_rad, before_rad2] = [self.ekf.mean(THETA), self.ekf.covariance(THETA, THETA)];
        let noise_m2 = self.correct(met, noise_m2 * self.correlation.bends.excess(met.wall))?;
        let turned_rad = self.ekf.mean(THETA) - before_rad;
        let taken_rad2 = before_rad2 - self.ekf.covariance(THETA, THETA);
        self.correlation.bends.note(met.wall, self.path_m, turned_rad, taken_rad2);
        Ok(noise_m2)
    }

    fn correct(&mut self, met: &Hypothesis, noise_m2: f32) -> Result<f32, Refusal> {
        self.ekf.update(met.innovation_m, &met.jacobian, noise_m2).map(|()| noise_m2).or(Err(Refusal::Degenerate))
    }

    /// A beam that found nothing within its range, where it should have met a wall well within it, went through the wall: its identifier, and
    /// where, metres.
    pub fn judge_absence(&mut self, sensor: &Sensor) -> Option<(u16, f32)> {
        let beam = self.beam(sensor, sin_cos(self.ekf.mean(THETA)));
        let met = self.first_met(&beam, 0.0, ABSENCE_SHARE * sensor.limits.max_m)?;
        if met.inside_m > ABSENCE_M && met.cos_incidence > sensor.state.min_cos {
            self.map.passed_through(met.index, met.along_m);
            return self.map.walls().get(met.index).map(|wall| (wall.id, met.along_m));
        }
        None
    }

    fn beam(&self, sensor: &Sensor, heading: (f32, f32)) -> Beam {
        let mount = sensor.state.mount_then(&sensor.limits.model, &self.timing, self.ekf);
        mount.beam([self.ekf.mean(X), self.ekf.mean(Y)], heading)
    }

    fn first_met(&self, beam: &Beam, beyond_m: f32, within_m: f32) -> Option<Candidate> {
        let grid = ManhattanFrame::of(self.ekf);
        let prolongation_m = prolongation_m(self.timing.step.path_m);
        first_met(self.ekf, &grid, self.map.walls(), beam, beyond_m, within_m, prolongation_m)
    }

    /// The next wall along the beam, and how the reading would fit it.
    fn hypothesis(&self, sight: &Sight, beyond_m: f32) -> Option<Hypothesis> {
        let Sight { sensor, reading, beam, heading } = sight;
        let limits = sensor.limits;
        let candidate = self.first_met(beam, beyond_m, 1.5 * limits.max_m)?;
        let wall = self.map.walls().get(candidate.index)?;
        let gain = sensor.state.gain(self.ekf);
        let prediction = beam.predict(&candidate.line);
        let predicted_m = gain * prediction.range_m;
        let innovation = reading.innovation(predicted_m);
        let derivatives = match self.settings.linearisation {
            Linearisation::Latest => prediction,
            Linearisation::FirstEstimates => self.first.of_reading(wall, &prediction),
        };
        let mut jacobian = self.jacobian(sensor, gain, wall, &derivatives);
        if let Some(age) = self.timing.latency.of(&limits.model) {
            // What is older shows less of the change. The capacity is more than twice what a measurement has.
            let by_age = -gain * change_m(&prediction, *heading, self.timing.latency.rate());
            let _ = jacobian.push((age, by_age));
            if let Some(offset) = self.timing.latency.stamps.state.map(usize::from) {
                let _ = jacobian.push((offset, by_age));
            }
        }
        // What stands out of a wall's plane is met so much earlier along a slanting beam.
        let relief_m = self.walls.relief_m / candidate.cos_incidence;
        let surface_m2 = SURFACE_M * SURFACE_M + relief_m * relief_m;
        let white_m2 = innovation.noise_m2 + surface_m2 + self.timing_variance(sensor, &prediction, *heading);
        let step = self.timing.step;
        let stride_m = step.path_m + (step.increment.turn_rad * candidate.range_m).abs();
        let at_end = candidate.inside_m < END_M.max(stride_m);
        // Where two surfaces are possible, the reading says half as much. But it must fit by its own noise: in a gate of twice that, the
        // side of an opening turned the wall that ends there, and the robot with it.
        let noise_m2 = if at_end { 4.0 * white_m2 } else { white_m2 };
        let is_analogue = matches!(reading.noise, Noise::Volts { .. });
        let gate = if at_end { self.settings.gate.min(END_GATE) } else { self.settings.gate };
        let known_m2 = self.ekf.variance(&jacobian);
        let level = self.levels.readings.factor();
        let variance_m2 = known_m2 + level * noise_m2;
        let (innovation_m, span_m) = (innovation.value_m, limits.span_m());
        let square_m2 = innovation_m * innovation_m;
        let fits_m2 = known_m2 + level * white_m2;
        let is_told = known_m2 <= TOLD_SHARE * TOLD_SHARE * span_m * span_m;
        let likelier = match self.settings.clutter {
            true => data_association::odds(innovation_m, fits_m2, span_m) >= 1.0,
            false => is_told,
        };
        let is_nearly = at_end && is_analogue && square_m2 <= self.settings.gate * variance_m2;
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
            doubt: if candidate.inside_m > 0.0 && is_folded(limits, predicted_m, reading.range_m) {
                Some(Refusal::FoldBack)
            } else {
                is_nearly.then_some(Refusal::Ambiguous)
            },
        })
    }

    /// The noise of a reading that may yet be of something else.
    fn weighed(&self, met: &Hypothesis) -> f32 {
        if !self.settings.clutter {
            return met.noise_m2;
        }
        let odds = data_association::odds(met.innovation_m, met.variance_m2, met.span_m);
        data_association::noise_m2(met.noise_m2, met.known_m2 + met.noise_m2, odds)
    }

    /// What the nearest wall's innovation says of the noise of readings and of motion, as far as the reading is its.
    fn learn_noise(&mut self, sight: &Sight, met: &Hypothesis) {
        if !self.sensing.learn_noise || !matches!(sight.reading.noise, Noise::Metres { .. }) {
            return;
        }
        let odds = data_association::odds(met.innovation_m, met.variance_m2, met.span_m);
        let alike = self.correlation.count(sight.sensor.index, met.wall, met.candidate.along_m, self.number);
        let [.., by_heading, _] = *met.jacobian.head();
        let expected = Expected {
            innovation_m: met.innovation_m,
            variance_m2: met.variance_m2,
            noise_m2: met.variance_m2 - met.known_m2,
            heading_m2: by_heading * by_heading * self.ekf.covariance(THETA, THETA),
        };
        self.levels.note(&expected, odds / (1.0 + odds) / alike);
    }

    /// Effective number of readings that this one repeats, at least 1; also records it.
    fn repeated(&mut self, sight: &Sight, met: &Hypothesis) -> f32 {
        if !self.sensing.repeats {
            return 1.0;
        }
        let (sensor, wall, along_m, step) = (sight.sensor.index, met.wall, met.candidate.along_m, self.number);
        let count = self.correlation.count(sensor, wall, along_m, step);
        let normalised = met.innovation_m / float::sqrtf(met.variance_m2);
        self.correlation.note(sensor, Hit { wall, along_m, step, normalised });
        count
    }

    /// A reading well beyond a wall, well inside its extent, went through it.
    fn judge_pass(&mut self, met: &Hypothesis) {
        let margin_m = 0.1 + 3.0 * float::sqrtf(met.variance_m2);
        if met.doubt.is_none() && met.innovation_m > margin_m && met.candidate.inside_m > PASS_M {
            self.map.passed_through(met.candidate.index, met.candidate.along_m);
        }
    }

    /// Variance of a reading from not knowing when it was made, m^2.
    fn timing_variance(&self, sensor: &Sensor, prediction: &Prediction, heading: (f32, f32)) -> f32 {
        let share = self.timing.uncertain_share(&sensor.limits.model);
        let spread_m = change_m(prediction, heading, self.timing.step.increment) * share;
        spread_m * spread_m
    }

    /// Row of the measurement Jacobian without the age, at most seven entries.
    fn jacobian(&self, sensor: &Sensor, gain: f32, wall: &Wall, prediction: &Prediction) -> Jacobian {
        // A snapped wall's own direction moves with the grid's (eq. 5 as printed).
        let theta_moves = self.walls.policy == WallPolicy::Snapped { theta_moves: true };
        let mut row = by_pose_and_wall(gain, wall, prediction, theta_moves);
        if let Some(state) = sensor.state.gain_state() {
            // The capacity is more than twice what a measurement has.
            let _ = row.push((state, prediction.range_m));
        }
        row
    }
}
