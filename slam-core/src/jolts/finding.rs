//! What a search for a displacement comes to: a robot that is displaced, or that may be.

use core::array;

use crate::jolts::confirmation::SURE;
use crate::jolts::search::{Displacement, JOLT, SLIP};

/// Wheels slip, and readings are taken for another wall's, so many times as often as somebody kicks the robot: once in a hundred metres or so.
const SLIPS: f32 = 10.0;

/// The likeliest displacement of a search, once it is likely enough to wait for its confirmation.
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
    /// Of a robot that is here in the map, metres, with the log odds of the likeliest of the others.
    pub fn new(displacement: &Displacement, other: f32, at_m: [f32; 2]) -> Self {
        let [[xx, ..], [yx, yy, _], [tx, ty, tt]] = displacement.covariance;
        let covariance = [xx, yx, yy, tx, ty, tt];
        Self { by: displacement.by, covariance, log_odds: displacement.log_odds, other, at_m }
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
    /// robot that is displaced by those odds and else is not (the moments of a mixture). What displaced it was a jolt, or no more than a
    /// slip. None where it is less likely than one in twenty.
    pub fn in_doubt(&self, log_odds: f32) -> Option<Finding> {
        if log_odds < -SURE {
            return None;
        }
        let share = 1.0 / (1.0 + libm::expf(-log_odds) + libm::expf(self.other - self.log_odds));
        let jolted = self.displacement();
        let (slipped, rather) = slip(&jolted);
        let slips = 1.0 / (1.0 + libm::expf(-rather) / SLIPS);
        let parts = [(share * (1.0 - slips), jolted), (share * slips, slipped)];
        let add = |sum: [f32; 3], (share, part): &(f32, Displacement)| array::from_fn(|i| sum[i] + share * part.by[i]);
        let by = parts.iter().fold([0.0; 3], add);
        let mut covariance = by.map(|i| by.map(|j| -i * j));
        for (share, part) in parts {
            for ((row, known), i) in covariance.iter_mut().zip(part.covariance).zip(part.by) {
                for ((entry, known), j) in row.iter_mut().zip(known).zip(part.by) {
                    *entry += share * (known + i * j);
                }
            }
        }
        Some(Finding { by, covariance, is_confirmed: false })
    }
}

/// What a displacement that was looked for as a jolt's is if it is a slip's, which is smaller, along what no reading tells as well; and the
/// log of the odds of a slip against a jolt by that.
fn slip(jolted: &Displacement) -> (Displacement, f32) {
    let Displacement { mut by, mut covariance, log_odds } = *jolted;
    let mut rather = 0.0;
    for (axis, (jolt, slip)) in JOLT.into_iter().zip(SLIP).enumerate() {
        // What is known of slips beyond what is known of jolts is like a reading that says none along this axis.
        let noise = 1.0 / (1.0 / (slip * slip) - 1.0 / (jolt * jolt));
        let (off, row) = (by[axis], covariance[axis]);
        let variance = row[axis] + noise;
        rather += libm::logf(jolt / slip) + 0.5 * libm::logf(noise / variance) - 0.5 * off * off / variance;
        for ((by, entries), with) in by.iter_mut().zip(&mut covariance).zip(row) {
            let gain = with / variance;
            *by -= gain * off;
            for (entry, with) in entries.iter_mut().zip(row) {
                *entry -= gain * with;
            }
        }
    }
    (Displacement { by, covariance, log_odds }, rather)
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
    use crate::jolts::search::{Displacement, JOLT, SLIP};

    /// So far ahead, metres, to a centimetre, and anywhere to the sides, with another displacement of these log odds.
    fn ahead(by_m: f32, other: f32) -> Likeliest {
        let mut covariance = [[0.0; 3]; 3];
        covariance[0][0] = 1e-4;
        covariance[1][1] = JOLT[1] * JOLT[1];
        Likeliest::new(&Displacement { by: [by_m, 0.0, 0.0], covariance, log_odds: 12.0 }, other, [0.0; 2])
    }

    /// Beyond doubt.
    const CERTAIN: f32 = 20.0;

    #[test]
    fn at_even_odds_it_is_half_way_give_or_take_the_other_half() {
        let found = ahead(0.3, f32::NEG_INFINITY).in_doubt(0.0).expect("even odds");
        assert!((found.by[0] - 0.15).abs() < 1e-3 && !found.is_confirmed, "{found:?}");
        assert!((found.covariance[0][0] - (0.5e-4 + 0.0225)).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_small_one_is_a_slip_and_goes_no_farther_where_no_reading_tells() {
        let aside_m = |by_m| {
            let found = ahead(by_m, f32::NEG_INFINITY).in_doubt(CERTAIN).expect("beyond doubt");
            assert!((found.by[0] - by_m).abs() < 0.1 * by_m, "{found:?}");
            found.covariance[1][1].sqrt()
        };
        assert!(aside_m(0.02) < 1.6 * SLIP[1], "{}", aside_m(0.02));
        assert!(aside_m(0.3) > 0.95 * JOLT[1], "{}", aside_m(0.3));
    }

    #[test]
    fn a_rival_takes_its_share() {
        let found = ahead(0.3, 12.0).in_doubt(CERTAIN).expect("beyond doubt, but for the rival");
        assert!((found.by[0] - 0.15).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn at_less_than_one_to_twenty_nothing_is_done() {
        assert!(ahead(0.3, f32::NEG_INFINITY).in_doubt(-SURE - 0.01).is_none());
    }
}
