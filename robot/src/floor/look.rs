//! What the sensors show: into the picture, and what is near the robot.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::wave::Aim;
use super::{FloorJob, Phase};
use crate::pilot::Senses;
use crate::pilot::beam::{Passed, draw_beam};

/// A beam's end counts where the one before was this near, metres: a spike has none.
const STEADY_M: f32 = 0.05;

impl<const S: usize> FloorJob<S> {
    /// Takes in what the sensors show; whether it planned on cells that are called otherwise now.
    pub(super) fn look(&mut self, senses: &Senses<S>, pose: &Pose) -> bool {
        let mut is_renamed = false;
        if self.take_picture_along(pose) {
            self.rename_cells();
            if let Phase::Transit { aim, .. } | Phase::Trace { aim, .. } | Phase::Plan { aim, .. } = self.phase {
                let aim = if let Aim::Floor | Aim::Beyond = aim { aim } else { self.aim() };
                self.plan(aim, senses.time_us);
                is_renamed = true;
            }
        }
        let here = self.sheet.picture.cell_at(pose.x_m, pose.y_m);
        if self.sheet.picture.is_obstacle(here) {
            self.traction.go_through();
        }
        self.sheet.picture.stand_on(here);
        self.steps = self.steps.wrapping_add(1);
        // Beams clear obstacles in one step of four only: a chair leg is hit by few beams and passed by many.
        let passed = if self.steps.is_multiple_of(4) { Passed::Vanish } else { Passed::Stay };
        self.feel(senses, pose, Some(passed));
        is_renamed
    }

    /// Takes in the ranges: what is near, and, where the pose is known, the picture, with what becomes of obstacles that beams pass.
    pub(super) fn feel(&mut self, senses: &Senses<S>, pose: &Pose, passed: Option<Passed>) {
        // Where the robot was when the readings were made.
        let last = self.last.unwrap_or(*pose);
        let share = self.config.reading_age_s * 25.0;
        let then = Pose {
            x_m: pose.x_m - share * (pose.x_m - last.x_m),
            y_m: pose.y_m - share * (pose.y_m - last.y_m),
            theta_rad: pose.theta_rad - share * wrap(pose.theta_rad - last.theta_rad),
        };
        for ((beam, before), range_m) in self.beams.iter_mut().zip(&mut self.before).zip(senses.ranges_m) {
            beam.take(range_m);
            if beam.max_m <= 0.0 {
                continue;
            }
            let before_m = 1e-4
                * f32::from(core::mem::replace(before, range_m.map_or(u16::MAX, |range_m| (1e4 * range_m) as u16)));
            // What a blinded sensor shows, and what it does not, says nothing of what is beyond.
            if self.near.is_blinded(beam, &then, senses.time_us) {
                continue;
            }
            if let Some(passed) = passed {
                let passed = if beam.age == 0 { passed } else { Passed::End };
                draw_beam(&mut self.sheet.picture, beam, &then, &self.config.drive, passed);
            }
            if beam.age == 0 && (beam.range_m - before_m).abs() < STEADY_M {
                self.near.see(beam, &then, pose, senses.time_us);
            }
        }
    }
}
