//! A robot that seems to be held, until readings of other places confirm it.

use crate::geometry::angle::wrap;
use crate::geometry::pose::Pose;
use crate::holds::stillness::HELD;
use crate::holds::{Correction, WORTH};
use crate::jolts::confirmation::Confirmation;
use crate::jolts::recent::{Moment, Recent};
use crate::jolts::search::{SLIP, Scene};

/// Log odds by readings of other places that confirm it: with those of the claim, as many as a robot that is held takes where no map tells.
const CONFIRMED: f32 = HELD - WORTH;

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
