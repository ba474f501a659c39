//! What somebody does to the robot and its home while it drives, beyond what the plan has in store.

use super::Simulation;
use crate::coverage::Coverage;
use crate::mishap::{Hold, Kick, Kidnap, Mishaps};
use crate::plan::Plan;
use crate::pose::Pose2;
use crate::sim_error::SimError;
use crate::world::World;

impl Simulation {
    /// Somebody lifts the robot now, carries it for a time and puts it down, here in the plan's frame, or in a free place of one
    /// of the plan's rooms where no place is given.
    ///
    /// # Errors
    /// There is no room for the robot.
    pub fn carry(&mut self, to: Option<Pose2>, carried_s: f64) -> Result<(), SimError> {
        let radius_m = self.options.body_radius_m;
        let clearance_m = to.map_or(f64::INFINITY, |to| self.world.clearance_m([to.x_m, to.y_m]));
        if clearance_m < radius_m {
            return Err(SimError::PlaceBlocked(0, clearance_m, radius_m));
        }
        let kidnap = Kidnap { at_s: self.time_s, carried_s, to };
        self.fate.add(Mishaps { kidnaps: vec![kidnap], ..Mishaps::default() });
        Ok(())
    }

    /// Something kicks the robot now: it slides (metres) and turns (radians), to sides drawn from the seed.
    pub fn kick(&mut self, slide_m: f64, turn_rad: f64) {
        let at_s = self.time_s + 0.5 * self.options.tick_s;
        self.fate.add(Mishaps { kicks: vec![Kick { at_s, slide_m, turn_rad }], ..Mishaps::default() });
    }

    /// Something holds the robot from now on, seconds, and its wheels turn on the spot.
    pub fn hold(&mut self, held_s: f64) {
        self.fate
            .add(Mishaps { holds: vec![Hold { is_jammed: false, at_s: self.time_s, held_s }], ..Mishaps::default() });
    }

    /// Covers a range sensor, which then sees nothing, or uncovers it.
    pub fn cover(&mut self, sensor: usize, is_covered: bool) {
        if let Some(sensor) = self.sensors.get_mut(sensor) {
            sensor.is_covered = is_covered;
        }
    }

    /// Whether each range sensor is covered.
    pub fn covered(&self) -> impl Iterator<Item = bool> + '_ {
        self.sensors.iter().map(|sensor| sensor.is_covered)
    }

    /// Puts this plan's walls, things, doors, people, cliffs, rugs and sills in the place of those that are there. The robot stays where it
    /// is, and truths stay in the frame of the first plan's start. What was seen of walls so far is forgotten.
    pub fn rebuild(&mut self, plan: &Plan) {
        self.world = World::new(plan).in_place_of(&self.world, self.time_s);
        self.cliffs.clone_from(&plan.cliffs);
        self.coverage = Coverage::new(&plan.faces);
        self.fate.furnish(plan, &self.body.pose);
    }

    /// Where each of the plan's people is, metres, and their radii.
    pub fn people(&self) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        self.world.people()
    }

    /// The frame of truths in the plan's frame: where the first plan's start is.
    pub fn start_in_plan(&self) -> Pose2 {
        self.start
    }

    /// After a step that ended at this time (seconds since the start): people turn round, and who pressed the robot into something
    /// did not.
    pub(super) fn let_people_turn(&mut self, end_s: f64) {
        let Pose2 { x_m, y_m, .. } = self.body.pose;
        if self.world.turn_round([x_m, y_m], self.options.body_radius_m, end_s) {
            self.body.put(self.last_pose);
        }
    }
}
