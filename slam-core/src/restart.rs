//! A new map where the estimator is so unwell that the old one is of no use.

use crate::filter::layout::ALPHA;
use crate::geometry::pose::Pose;
use crate::holds::Holds;
use crate::jolts::Jolts;
use crate::measurement::first_estimates::FirstEstimates;
use crate::motion::shortfall::Shortfall;
use crate::motion::step::start_variance;
use crate::report::Health;
use crate::rig::MAX_SENSORS;
use crate::slam::Slam;
use crate::walls::anchor::Anchor;

/// Square of the standard deviations of its prior that a calibration may be off and still be kept where its covariance is
/// lost: three.
const CREDIBLE: f32 = 9.0;

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// How the estimator is after this step; where it is so unwell that its map is of no use, it begins a new one. So many
    /// states are looked at.
    pub(crate) fn examine(&mut self, states: usize) -> Health {
        let is_sound = self.ekf.is_sound(states);
        let heading_variance = (!self.map.walls().is_empty()).then(|| self.map.heading_variance(&self.ekf));
        let doubted = self.monitor.doubted;
        let moved_m = self.drive.step.beams_moved_m();
        match self.monitor.judge(self.drive.dead_reckoning.path_m, moved_m, heading_variance, is_sound) {
            Some(Health::Degenerate) => self.restart_without_covariance(),
            Some(_) => {
                self.map.forget_some(&mut self.ekf, |wall| wall.id.wrapping_sub(doubted) as i16 >= 0);
                self.monitor.steps_left = 1;
            }
            None => {}
        }
        self.monitor.follow(self.map.next_id());
        self.monitor.health()
    }

    /// Whether readings contradict the map, or the heading against it is not known: it is forgotten when the next step begins. Until then
    /// it can be kept, as it is.
    pub fn is_about_to_forget(&self) -> bool {
        self.monitor.steps_left > 0
    }

    /// Goes on in a map about to be forgotten for another step: whoever keeps it cannot do so yet.
    pub fn put_off_forgetting(&mut self) {
        self.monitor.steps_left = 2 * self.monitor.steps_left.min(1);
    }

    /// Begins a step: in a new map where the last one showed that the old one is of no use.
    pub(crate) fn forget_if_due(&mut self) {
        match self.monitor.steps_left {
            0 => {}
            1 => self.restart_map(),
            _ => self.monitor.steps_left = 1,
        }
    }

    /// Begins a new map where the robot is, with the calibration as it is known. The pose goes on in the frame that it was
    /// in; how well it is known there no reading of the new map tells.
    pub fn restart_map(&mut self) {
        self.map.forget_walls(&mut self.ekf);
        self.drop_anchor();
    }

    /// Begins a new map in a frame of its own: how it lies to the old one, where the first drive started and maybe the dock is, is not known.
    pub fn restart_elsewhere(&mut self) {
        self.restart_map();
        (self.map.anchor, self.map.start, self.map.has_dock) = (None, Pose::ORIGIN, false);
    }

    /// Nothing holds the robot any more: somebody lifts it.
    pub fn release(&mut self) {
        self.holds = Holds::NONE;
    }

    /// The same where the covariance is none: the calibration keeps its values, as unsure as at the start.
    fn restart_without_covariance(&mut self) {
        const CALIBRATION: usize = ALPHA + 1;
        let values: [f32; 4 + MAX_SENSORS] = core::array::from_fn(|i| self.ekf.mean(CALIBRATION + i));
        self.map.forget_walls(&mut self.ekf);
        let (pose, covariance) = Anchor::beyond_doubt(&self.ekf);
        self.ekf.clear();
        self.add_states();
        for (i, value) in (CALIBRATION..self.ekf.len()).zip(values) {
            let off = value - self.ekf.mean(i);
            // What is no number is not kept, nor what the prior does not allow.
            if off * off <= CREDIBLE * self.ekf.covariance(i, i) {
                self.ekf.set_mean(i, value);
            }
        }
        self.ekf.predict(pose, &Default::default(), &covariance);
        self.drop_anchor();
    }

    /// Begins anew where the robot is.
    #[cold]
    #[inline(never)]
    fn drop_anchor(&mut self) {
        self.map.drop_anchor(&mut self.ekf, start_variance(&self.rig.drive), &self.drive.states);
        self.begin_anew();
    }

    fn begin_anew(&mut self) {
        self.monitor.begin_map(self.map.next_id());
        self.first = FirstEstimates::START;
        self.shortfall = Shortfall::NONE;
        self.slippage.begin_map();
        self.candidates.clear();
        self.jolts = Jolts::NONE;
        self.holds.forget();
        self.counters.add_restart();
    }
}
