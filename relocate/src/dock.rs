//! What a dock that is not where the map has it says for the robot being elsewhere.

/// A robot that backs out from nearer than the first before its dock to farther than the second, metres, came for it in vain: one that only turns
/// about before the wall beside it does not back so far.
const TRY_M: [f32; 2] = [0.5, 0.55];

/// The dock is missed where the robot did that so often.
const TRIES: i8 = 2;

/// What that says, as logarithm of odds: a hundred to one. Where the pose is right the first or second try closes the contact, unless somebody
/// moved the dock or stands before it.
const MISSED: f32 = 4.605_17;

/// How often the robot came for its dock in vain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DockTries {
    /// Since it stood in it.
    count: i8,
    /// It is so near that backing out is one more.
    is_near: bool,
}

impl DockTries {
    pub(crate) const NONE: Self = Self { count: 0, is_near: false };

    /// Takes in whether the robot stands in a dock, and from how far straight in front it looks to the one that its map has, metres.
    pub(crate) fn step(&mut self, is_docked: bool, before_m: Option<f32>) {
        let [near_m, far_m] = TRY_M;
        match before_m {
            // It backs out of it, too.
            _ if is_docked => *self = Self { count: -1, is_near: false },
            Some(before_m) if before_m < near_m => self.is_near = true,
            Some(before_m) if before_m < far_m => {}
            Some(_) if core::mem::take(&mut self.is_near) => self.count = self.count.saturating_add(1),
            _ => self.is_near = false,
        }
    }

    /// Logarithm of the odds that the robot is elsewhere, by that alone.
    pub(crate) fn log_odds(self) -> f32 {
        if self.count < TRIES { 0.0 } else { MISSED }
    }
}

#[cfg(test)]
mod tests {
    use super::DockTries;

    fn said(tries: &mut DockTries, seen: &[(bool, Option<f32>)]) -> f32 {
        seen.iter().for_each(|(is_docked, before_m)| tries.step(*is_docked, *before_m));
        tries.log_odds()
    }

    const TRY: [(bool, Option<f32>); 4] =
        [(false, Some(0.6)), (false, Some(0.3)), (false, Some(0.52)), (false, Some(0.6))];

    #[test]
    fn a_dock_that_two_tries_do_not_find_is_missed_until_it_is_found() {
        let mut tries = DockTries::NONE;
        assert_eq!(said(&mut tries, &TRY), 0.0);
        assert!(said(&mut tries, &TRY) > 4.6);
        // It stands in it, and backs out.
        assert_eq!(said(&mut tries, &[(true, Some(0.0)), (false, Some(0.3)), (false, Some(0.6))]), 0.0);
        assert_eq!(said(&mut tries, &TRY), 0.0);
        assert!(said(&mut tries, &TRY) > 4.6);
    }

    #[test]
    fn a_robot_that_turns_about_before_the_wall_beside_the_dock_tries_nothing() {
        let turns_about = [(false, Some(0.6)), (false, Some(0.1)), (false, None), (false, Some(0.6))];
        let mut tries = DockTries::NONE;
        assert_eq!(said(&mut tries, &turns_about.repeat(9)), 0.0);
    }
}
