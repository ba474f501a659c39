//! What the simulated robot's range sensors show.

use slam_core::{RangeInput, RangeModel};

use super::{MAX_SENSORS, Simulation};
use crate::fault;
use crate::pose::Pose2;
use crate::sensor::{Analogue, Output, SimSensor};
use crate::sharp::{CycleEvent, counts};
use crate::world::Hit;

impl Simulation {
    /// The sensors have been on for a while when the run begins: their outputs show the view from the start.
    pub(super) fn first_light(&mut self) {
        for i in 0..self.sensors.len() {
            let hit = self.look(i, &self.body.pose.clone());
            let sensor = &mut self.sensors[i];
            let volts = sensor.volts(hit.map(|hit| hit.range_m));
            if let Some(Analogue { output: Output::Cycle(cycle, _), .. }) = &mut sensor.analogue {
                cycle.integrate(volts);
                cycle.show_pending();
            }
        }
    }

    /// What a sensor's light meets from this pose of the robot; none where nothing comes back.
    fn look(&mut self, sensor: usize, pose: &Pose2) -> Option<Hit> {
        if self.body.contacts.lifted {
            return None;
        }
        if let Some(shown_m) = fault::shown(self.fate.faults(), sensor, self.time_s) {
            return shown_m.map(|range_m| Hit { range_m, cos_incidence: 1.0, face: None });
        }
        let SimSensor { sensor, cos_lost, is_covered, .. } = &self.sensors[sensor];
        if *is_covered {
            return None;
        }
        let mount = sensor.mount;
        let origin_m = pose.transform([mount.x_m.into(), mount.y_m.into()]);
        let (s, c) = libm::sincos(pose.theta_rad + f64::from(mount.bearing_rad));
        let hit = self.world.cast(origin_m, [c, s]).filter(|hit| hit.cos_incidence >= *cos_lost)?;
        if let Some(face) = hit.face
            && (f64::from(sensor.min_m)..=f64::from(sensor.max_m)).contains(&hit.range_m)
        {
            self.coverage.record(face, [origin_m[0] + hit.range_m * c, origin_m[1] + hit.range_m * s]);
        }
        Some(hit)
    }

    pub(super) fn run_cycle(&mut self, index: usize, begin_s: f64, end_s: f64) {
        let mut shown_s = begin_s;
        loop {
            let sensor = &mut self.sensors[index];
            let Some(Analogue { output: Output::Cycle(cycle, low_pass), .. }) = &mut sensor.analogue else { return };
            let (before_v, output_s) = (cycle.output_v(), cycle.end_s());
            match cycle.poll(end_s, &mut sensor.noise) {
                None => {
                    low_pass.follow(before_v, end_s - shown_s);
                    return;
                }
                Some(CycleEvent::Output) => {
                    low_pass.follow(before_v, output_s - shown_s);
                    shown_s = output_s;
                }
                Some(CycleEvent::Middle(middle_s)) => {
                    let share = ((middle_s - begin_s) / (end_s - begin_s)).clamp(0.0, 1.0);
                    let pose = self.last_pose.interpolate(&self.body.pose, share);
                    let hit = self.look(index, &pose);
                    let sensor = &mut self.sensors[index];
                    let volts = sensor.volts(hit.map(|hit| hit.range_m));
                    if let Some(Analogue { output: Output::Cycle(cycle, _), .. }) = &mut sensor.analogue {
                        cycle.integrate(volts);
                    }
                }
            }
        }
    }

    /// One conversion of every range sensor.
    pub fn read_ranges(&mut self) -> [RangeInput; MAX_SENSORS] {
        let mut ranges = [RangeInput::Missing; MAX_SENSORS];
        for (i, range) in ranges.iter_mut().enumerate().take(self.sensors.len()) {
            *range = match self.sensors[i].analogue.as_ref().map(|analogue| &analogue.output) {
                Some(Output::Cycle(cycle, low_pass)) => self.convert(i, low_pass.output_v(cycle.output_v())),
                Some(&Output::Late(age_s)) => {
                    let hit = self.look(i, &self.history.at(self.time_s - age_s));
                    let output_v = self.sensors[i].volts(hit.map(|hit| hit.range_m));
                    self.convert(i, output_v)
                }
                None => self.read_metric(i),
            };
        }
        ranges
    }

    fn convert(&mut self, index: usize, output_v: f64) -> RangeInput {
        let sharp = &self.options.sharp;
        let spikes = &mut self.sensors[index].spikes;
        let spike_v = if sharp.spike_probability > 0.0 && spikes.unit() < sharp.spike_probability {
            spikes.uniform(0.1, 1.0) * sharp.spike_v
        } else {
            0.0
        };
        self.adc.map_or(RangeInput::Missing, |adc| RangeInput::Counts(counts(adc, output_v + spike_v)))
    }

    fn read_metric(&mut self, index: usize) -> RangeInput {
        let pose = self.body.pose;
        let hit = self.look(index, &pose);
        let sensor = &mut self.sensors[index];
        let (RangeModel::Metric { noise_m, noise_rel }, Some(hit)) = (sensor.sensor.model, hit) else {
            return RangeInput::Missing;
        };
        let sigma_m = libm::hypot(noise_m.into(), f64::from(noise_rel) * hit.range_m);
        let range_m = sensor.gain * hit.range_m + sigma_m * sensor.noise.gaussian();
        if range_m > 0.0 && range_m <= f64::from(sensor.sensor.max_m) {
            RangeInput::Metres(range_m as f32)
        } else {
            RangeInput::Missing
        }
    }
}
