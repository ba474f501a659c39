//! What a search for a displacement comes to: a robot that is displaced, or that may be.

use crate::jolts::confirmation::SURE;
use crate::jolts::search::Displacement;

/// The likeliest displacement of a search so far.
#[derive(Clone, Copy, Debug)]
pub struct Likeliest {
    /// About where the robot is, once it was followed there.
    by: [f32; 3],
    /// The lower triangle of its covariance, row by row.
    covariance: [f32; 6],
    /// Log of its odds, and of those of the likeliest of the others.
    log_odds: f32,
    other: f32,
    /// Where the robot was last, in the map, metres.
    at_m: [f32; 2],
}

/// By how much the pose is off, in the map.
#[derive(Clone, Copy, Debug)]
pub struct Finding {
    /// x and y, metres, and turn, radians.
    pub by: [f32; 3],
    /// Their covariance.
    pub covariance: [[f32; 3]; 3],
    /// Whether it was confirmed.
    pub is_confirmed: bool,
}

impl Likeliest {
    /// None was found.
    pub const NONE: Self = Self {
        by: [0.0; 3],
        covariance: [0.0; 6],
        log_odds: f32::NEG_INFINITY,
        other: f32::NEG_INFINITY,
        at_m: [0.0; 2],
    };

    /// This one is, found where the robot was followed to, with the log odds of the likeliest of the others.
    pub fn found(&mut self, displacement: &Displacement, other: f32) {
        let [[xx, ..], [yx, yy, _], [tx, ty, tt]] = displacement.covariance;
        *self = Self {
            by: displacement.by,
            covariance: [xx, yx, yy, tx, ty, tt],
            log_odds: displacement.log_odds,
            other,
            at_m: self.at_m,
        };
    }

    /// The displacement.
    pub fn displacement(&self) -> Displacement {
        let [xx, yx, yy, tx, ty, tt] = self.covariance;
        let covariance = [[xx, yx, tx], [yx, yy, ty], [tx, ty, tt]];
        Displacement { by: self.by, covariance, log_odds: self.log_odds }
    }

    /// Follows the robot there, in the map, metres.
    pub fn follow(&mut self, at_m: [f32; 2]) {
        let moved_m = [at_m[0] - self.at_m[0], at_m[1] - self.at_m[1]];
        (self.by, self.at_m) = (self.displacement().seen_from(moved_m).by, at_m);
    }

    /// What is to be done where it was not confirmed, by the log of its odds with all else that is known of it: mean and covariance of a
    /// robot that is displaced by those odds and else is not (the moments of a mixture). None where it is less likely than one in twenty.
    pub fn in_doubt(&self, log_odds: f32) -> Option<Finding> {
        if log_odds < -SURE {
            return None;
        }
        let Displacement { by, covariance, .. } = self.displacement();
        let share = 1.0 / (1.0 + libm::expf(-log_odds) + libm::expf(self.other - self.log_odds));
        let spread = share * (1.0 - share);
        Some(Finding {
            by: by.map(|by| share * by),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| share * covariance[i][j] + spread * by[i] * by[j])
            }),
            is_confirmed: false,
        })
    }
}

impl From<Displacement> for Finding {
    fn from(Displacement { by, covariance, .. }: Displacement) -> Self {
        Self { by, covariance, is_confirmed: true }
    }
}

#[cfg(test)]
mod tests {
    use crate::jolts::confirmation::SURE;
    use crate::jolts::finding::Likeliest;
    use crate::jolts::search::Displacement;

    /// Ten centimetres ahead, to one, with another displacement of these log odds.
    fn likeliest(other: f32) -> Likeliest {
        let mut covariance = [[0.0; 3]; 3];
        covariance[0][0] = 1e-4;
        let mut likeliest = Likeliest::NONE;
        likeliest.found(&Displacement { by: [0.1, 0.0, 0.0], covariance, log_odds: 12.0 }, other);
        likeliest
    }

    #[test]
    fn at_even_odds_it_is_half_way_give_or_take_the_other_half() {
        let found = likeliest(f32::NEG_INFINITY).in_doubt(0.0).expect("even odds");
        assert!((found.by[0] - 0.05).abs() < 1e-6 && !found.is_confirmed);
        assert!((found.covariance[0][0] - (0.5e-4 + 0.0025)).abs() < 1e-7);
    }

    #[test]
    fn a_rival_takes_its_share() {
        let found = likeliest(12.0).in_doubt(20.0).expect("beyond doubt, but for the rival");
        assert!((found.by[0] - 0.05).abs() < 1e-6);
    }

    #[test]
    fn at_less_than_one_to_twenty_nothing_is_done() {
        assert!(likeliest(f32::NEG_INFINITY).in_doubt(-SURE - 0.01).is_none());
    }
}
