//! A robot that seems to be held, until readings of other places confirm it.

use crate::geometry::angle::wrap;
use crate::geometry::pose::Pose;
use crate::holds::stillness::HELD;
use crate::jolts::confirmation::Confirmation;
use crate::jolts::recent::{Moment, Recent};
use crate::jolts::search::{SLIP, Scene};

/// Log odds by walls from which on a hold is claimed: more than the 3.9 that one look of one sensor says at most, so that it takes
/// two. That holds are as rare as one in an hour of driving is left to the confirmation.
pub const WORTH: f32 = 4.0;

/// Log odds by readings of other places that confirm it: with those of the claim, as many as a robot that is held takes where no map tells.
const CONFIRMED: f32 = HELD - WORTH;

/// What is known of where readings last agreed with what the robot does, 1-sigma, each axis, metres, and heading, radians: in 76 of 80 holds
/// it had driven less than 7 cm between.
const AGREED: [f32; 3] = [0.05, 0.05, 0.1];

/// A robot that is elsewhere than the filter has it, because it was held or no longer is, or that may be.
#[derive(Clone, Copy, Debug)]
pub struct Correction {
    /// Where it is, in the map.
    pub pose: Pose,
    /// 1-sigma vector of the motion of its wheels that is in doubt, metres and radians, all of it at once.
    pub in_doubt: [f32; 3],
    /// Whether it is held from now on.
    pub is_held: bool,
}

impl Correction {
    /// What the pose is known to, metres and radians: by that, and by when readings told.
    #[inline(never)]
    pub fn covariance(&self) -> [[f32; 3]; 3] {
        let mut covariance = self.in_doubt.map(|a| self.in_doubt.map(|b| a * b));
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] += AGREED[i] * AGREED[i];
        }
        covariance
    }
}

/// What all sensors say together, until readings of other places confirm it.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    pub correction: Correction,
    pub confirmation: Confirmation,
}

/// What those readings say in the end.
pub struct Verdict {
    /// Whether the robot is held.
    pub is_held: bool,
    /// Where it is otherwise than the filter has it, or less surely there.
    pub found: Option<Correction>,
}

impl Claim {
    /// By readings since, of a robot that stands against one that moved as its wheels say, from where the filter has it or from somewhat
    /// beside that; none until they tell. Along a wall it is all the same to the readings whether a robot stands or drives on, once a wheel
    /// that slipped has turned it back from where the wheels would have it head. Such slips are as rare as holds.
    pub fn verdict(&self, scene: &Scene, recent: &Recent, moment: &Moment, is_witnessed: bool) -> Option<Verdict> {
        let Self { correction, confirmation } = self;
        let moved = recent.since(confirmation.onset(), moment);
        let stayed = recent.standing_since(confirmation.onset(), &correction.pose);
        let stands = scene.rather(&stayed, &moved, &SLIP);
        let slipped = if stands > 0.0 { scene.rather(&moved, &moved, &SLIP) } else { 0.0 };
        let said = stands - slipped.max(0.0);
        // A robot taken to stand where it drives is silently wrong; one whose hold is found a little later is not.
        let is_held = confirmation.verdict(said, CONFIRMED)? && is_witnessed;
        let found = is_held.then_some(*correction);
        Some(Verdict {
            is_held,
            found: found.or_else(|| (stands > CONFIRMED).then(|| self.in_doubt(&moment.map, said))),
        })
    }

    /// It stood, or a wheel slipped: by these odds it is where the claim has it, and not where the filter does.
    fn in_doubt(&self, filter: &Pose, log_odds: f32) -> Correction {
        let from = &self.correction.pose;
        let share = float::sqrtf(1.0 / (1.0 + libm::expf(-log_odds)));
        let off = [filter.x_m - from.x_m, filter.y_m - from.y_m, wrap(filter.theta_rad - from.theta_rad)];
        Correction { pose: *filter, in_doubt: off.map(|off| share * off), is_held: false }
    }
}
