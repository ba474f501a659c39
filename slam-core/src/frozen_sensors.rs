//! Range sensors that are frozen are found, and not believed.

use crate::holds::outputs::View;
use crate::measurement::sensor::Sensor;
use crate::report::{Outcome, StepReport};
use crate::sample::RangeInput;
use crate::slam::Slam;

/// Updates in a step that leave no time to look at sensors: those of all sensors of the robot.
const FULL: u32 = 8;

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Looks at the sensors, whether they are frozen, after so many updates in this step.
    pub(crate) fn watch_sensors(&mut self, updates: u32, inputs: &[RangeInput; S], report: &StepReport<S>) {
        if updates < FULL {
            self.look_at_sensors(inputs, report);
        } else {
            self.frozen.skip();
        }
    }

    #[inline(never)]
    fn look_at_sensors(&mut self, inputs: &[RangeInput; S], report: &StepReport<S>) {
        let Self { rig, sensors, drive, output_noise, .. } = self;
        let (wheels, path_m) = (&drive.nominal, drive.dead_reckoning.path_m);
        let (noise, true_noise) = (output_noise.factor(), output_noise.true_factor());
        let rows = rig.sensors.iter().zip(sensors).zip(inputs).zip(&report.readings).enumerate();
        for (index, (((limits, state), input), reading)) in rows {
            let fits = matches!(reading.outcome, Outcome::Updated { .. });
            let view = View { rig, noise, true_noise, wheels, path_m, fits };
            if self.frozen.look(&Sensor { index, limits, state }, *input, &view) {
                self.counters.add_frozen();
                // What it said of late was no surface.
                self.candidates.clear();
            }
            state.front_end.is_frozen = self.frozen.is_frozen(index);
        }
        self.frozen.settle();
        self.holds.forget_stillness(self.frozen.suspects());
    }
}
