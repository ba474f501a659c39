//! New walls, and the map kept tidy.

use crate::births::extend::Extension;
use crate::filter::layout;
use crate::measurement::first_estimates::Linearisation;
use crate::motion::step::start_variance;
use crate::report::StepReport;
use crate::slam::Slam;
use crate::walls::upkeep::upkeep;

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Finds new walls among the outliers (Rousse & Qiu 3.3), and keeps the map tidy. Its variables are on the stack only while it runs.
    #[inline(never)]
    pub(crate) fn extend_map(&mut self, turns: usize, report: &mut StepReport<S>) {
        if let Some(times) = self.output_noise.settle() {
            self.candidates.buffer.widen(times);
        }
        let turns = if self.output_noise.is_settling() { 0 } else { turns };
        let (epoch, there) = (self.map.epoch(), layout::pose(&self.ekf));
        let born = Extension {
            settings: &self.config.births,
            walls: &self.config.walls,
            ekf: &mut self.ekf,
            map: &mut self.map,
            candidates: &mut self.candidates,
            drive: &self.drive,
            sensors: &self.sensors,
            in_rig: self.rig.sensors.len(),
            latency: &self.latency,
            first: &mut self.first,
            start_variance: start_variance(&self.rig.drive),
        }
        .extend(turns);
        if self.map.epoch() != epoch {
            // The filter's frame begins where the robot is.
            self.holds.go_with(&there, &layout::pose(&self.ekf));
        }
        let (number, path_m) = (self.counters.steps as usize, self.drive.dead_reckoning.path_m);
        let tidied = upkeep(&mut self.map, &mut self.ekf, self.config.walls.policy, number, path_m);
        if self.config.measurement.linearisation == Linearisation::FirstEstimates
            && let Some(wall) = number.checked_rem(self.map.walls().len()).and_then(|index| self.map.wall_mut(index))
        {
            self.first.renew(wall, &mut self.ekf);
        }
        for changes in [born, tidied] {
            self.counters.add_changes(&changes);
            report.add(&changes);
        }
    }
}
