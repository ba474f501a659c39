//! Range sensors that are frozen are found, and not believed.

use crate::holds::frozen::View;
use crate::measurement::sensor::Sensor;
use crate::report::{Outcome, Refusal, StepReport};
use crate::sample::RangeInput;
use crate::slam::Slam;

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Updates with the readings of all sensors that are not frozen, and looks at one of them, whether it is.
    pub(crate) fn observe_unfrozen(&mut self, inputs: &[RangeInput; S], dt_s: f32, report: &mut StepReport<S>) {
        let updates = self.counters.updates;
        match self.frozen.sensors() {
            0 => self.observe(inputs, dt_s, report),
            frozen => self.observe_without(frozen, inputs, dt_s, report),
        }
        // Where every reading is a wall's none is to be suspected, and the step has no time.
        if self.counters.updates.wrapping_sub(updates) < self.rig.sensors.len() as u32 {
            self.watch_sensors(inputs, report);
        }
    }

    /// Looks at a sensor, whether it is frozen.
    #[inline(never)]
    fn watch_sensors(&mut self, inputs: &[RangeInput; S], report: &StepReport<S>) {
        let Self { rig, sensors, drive, output_noise, .. } = self;
        let index = self.frozen.next(rig.sensors.len());
        if let (Some(limits), Some(state), Some(input)) =
            (rig.sensors.get(index), sensors.get(index), inputs.get(index))
        {
            let fits =
                report.readings.get(index).is_some_and(|reading| matches!(reading.outcome, Outcome::Updated { .. }));
            let (motion, path_m) = (&drive.last_motion, drive.dead_reckoning.path_m);
            let (noise, true_noise) = (output_noise.factor(), output_noise.true_factor());
            let view = View { rig, noise, true_noise, motion, wheels: &drive.nominal, path_m, fits };
            if self.frozen.look(&Sensor { index, limits, state }, *input, &view) {
                self.counters.add_frozen();
                // What it said of late was no surface.
                self.candidates.clear();
            }
        }
    }

    /// Refuses what these sensors say, a bit each, for they are frozen, and updates with the others.
    #[cold]
    #[inline(never)]
    fn observe_without(&mut self, frozen: u16, inputs: &[RangeInput; S], dt_s: f32, report: &mut StepReport<S>) {
        let mut others = *inputs;
        for (index, (input, report)) in others.iter_mut().zip(&mut report.readings).enumerate() {
            if *input != RangeInput::Missing && frozen >> (index & 15) & 1 != 0 {
                *input = RangeInput::Missing;
                report.outcome = Outcome::Refused(Refusal::Frozen);
                self.counters.add_reading(&report.outcome);
            }
        }
        self.observe(&others, dt_s, report);
    }
}
