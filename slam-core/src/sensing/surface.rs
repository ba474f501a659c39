//! What a surface that a beam meets tells of which way a robot drives: whether its range changes as it would forwards, or backwards.
//!
//! By how much, the direction of the wall tells that the beam met; where it met none of the map, a surface may stand anyhow and
//! move by itself, so that one such surface alone does not decide. People who walk ahead are no walls: while they say backwards,
//! the walls beside them say forwards, and who says now this and now that says nothing.
//!
//! A surface that is no wall of the map may face any way. So one that gets nearer does so because the robot drives forwards, or is one beside which it
//! drives backwards and that stands askew. How much its range changes is the same for as long as it is the same surface: it tells
//! once what it does.
//!
//! A range is held against the one with which its stretch of some centimetres began and against all that was driven since, not row by row:
//! the odometry of a row may be of another moment than its ranges, and that does not add up.

use core::f32::consts::PI;

use crate::filter::density::density;
use crate::geometry::angle::sin_cos;
use crate::rig::{Mount, RangeModel, RangeSensor};
use crate::sample::RangeInput;

/// Beams tell whose ranges change by at least this share of what is driven, on what faces them: those within 66 degrees of the way, and on
/// a wall of the map within 60.
const LEAST_SHARE: f32 = 0.4;
const LEAST_SHARE_OF_WALL: f32 = 0.5;

/// Least cosine of the incidence on a wall whose reading tells something.
const LEAST_COS: f32 = 0.3;

/// Length of a stretch by how much a range is to change over it, metres: forwards and backwards are ten standard deviations of two
/// centimetres apart then.
const STRETCH_M: f32 = 0.15;

/// Variance of a row's motion by its stamps, as a share of its square: rows five times a second whose stamps are off by 60 ms.
const STAMP_SHARE: f32 = 0.09;

/// The same of a stretch by the odometry's scale, off by 5 %.
const SCALE_SHARE: f32 = 0.0025;

/// Of a surface that may stand anyhow a beam meets the more the more it faces the beam: the sine of the incidence is uniform, and the range changes by its
/// tangent beyond what it would on one that faces the beam. Tangents in the middle of five parts of the sine up to that of 70 degrees, and
/// the standard deviation of the tangent within each.
const PARTS: [(f32, f32); 5] = [(-1.141, 0.379), (-0.406, 0.136), (0.0, 0.109), (0.406, 0.136), (1.141, 0.379)];

/// Share of surfaces that move by themselves, and of those that fitted a wall of the map: one surface tells at most the logarithm of
/// its inverse, 3.9 or 6.9.
const MOVING: f32 = 0.02;
const MOVING_WALLS: f32 = 1e-3;

/// Probability that a beam has come to another surface by the end of a stretch: one of three quarters of a metre.
const ANOTHER: f32 = 0.2;

/// How far the surface of a wall is from its line, metres.
const RELIEF_M: f32 = 0.01;

/// A range that changes by more than this many times what was driven, and by more than its noise and the beam's sweep, is of
/// another surface: one 70 degrees from the beam would change by three times that. One of a wall that is off by more than its noise either way is, too.
const SAME_SURFACE: f32 = 3.0;
const SIGMAS: f32 = 4.0;

/// A row's motion, as the odometry says it.
pub struct Motion {
    pub forward_m: f32,
    pub turn_rad: f32,
    /// How far the longer of this row and the one before went, metres: which of both the ranges are of is not known.
    pub longest_m: f32,
}

/// What a surface says, as log odds of backwards against forwards.
#[derive(Clone, Copy, Debug, Default)]
pub struct Says {
    /// By this stretch alone, as one that is at rest.
    pub at_rest: f32,
    /// As one that may move by itself, beyond what was heard of it.
    pub more: f32,
}

/// A surface that a beam has met for some rows.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The last range, metres; zero where there is none.
    last_m: f32,
    stands: Stands,
    /// By how much its range changed over this stretch besides by the robot's turning, and by how much it would have forwards, metres.
    changed_m: f32,
    forwards_m: f32,
    /// Variance of that by turning, and by the stamp of its first row, m^2.
    variance_m2: f32,
    /// By how much less likely it is at rest, if the robot drives forwards and backwards, than a surface that nothing is known of, as a share.
    doubts: [f32; 2],
    /// What was heard of this stretch, less what was not of the ones before, as log odds of backwards against forwards.
    heard: f32,
}

/// How a surface stands.
#[derive(Clone, Copy, Debug)]
enum Stands {
    /// Anyhow.
    Anyhow,
    /// So that its range changes by so many times what that of one that faces the beam would, forwards.
    Askew(Ratio),
    /// As the wall of the map does that it is.
    AsWall(Normal),
}

impl Stands {
    /// To a robot that has turned by so much, radians.
    fn after(self, turn_rad: f32) -> Self {
        match self {
            Self::AsWall(normal) => Self::AsWall(Normal::new(normal.rad() - turn_rad)),
            _ => self,
        }
    }
}

/// A ratio, in parts of which there are 2^12.
#[derive(Clone, Copy, Debug)]
struct Ratio(i16);

impl Ratio {
    const PER_ONE: f32 = 4096.0;

    fn new(ratio: f32) -> Self {
        Self((ratio * Self::PER_ONE) as i16)
    }

    fn value(self) -> f32 {
        f32::from(self.0) / Self::PER_ONE
    }
}

/// Direction of a normal in the robot's frame, either way, in parts of half a turn of which there are 2^15.
#[derive(Clone, Copy, Debug)]
struct Normal(i16);

impl Normal {
    const PER_RAD: f32 = 32_768.0 / PI;

    fn new(rad: f32) -> Self {
        Self((rad * Self::PER_RAD) as i32 as i16)
    }

    fn rad(self) -> f32 {
        f32::from(self.0) / Self::PER_RAD
    }
}

/// How a range should change in a row.
struct Change {
    /// What it would be had the robot only turned, metres.
    turned_m: f32,
    /// By how much more it changes forwards, metres.
    forwards_m: f32,
    /// Variance of it by turning, m^2.
    variance_m2: f32,
    /// Tangent of the beam's angle to the way, of a surface that may stand anyhow.
    tangent: f32,
    /// By more than this it is another surface, beside the noise, metres.
    most_m: f32,
}

impl Surface {
    /// Nothing was seen. Every byte is zero.
    pub const NONE: Self = Self {
        last_m: 0.0,
        stands: Stands::Anyhow,
        changed_m: 0.0,
        forwards_m: 0.0,
        variance_m2: 0.0,
        doubts: [0.0; 2],
        heard: 0.0,
    };

    /// It is a wall whose normal has this direction in the robot's frame, radians; none where that does not tell.
    pub fn meet(&mut self, normal_rad: Option<f32>) {
        self.stands = match (normal_rad, self.stands) {
            (Some(normal_rad), _) => Stands::AsWall(Normal::new(normal_rad)),
            (None, Stands::AsWall(_)) => Stands::Anyhow,
            (None, stands) => stands,
        };
    }

    /// What it said was of another stretch.
    pub fn begin(&mut self) {
        let stands = if self.is_wall() { self.stands } else { Stands::Anyhow };
        *self = Self { last_m: self.last_m, stands, ..Self::NONE };
    }

    fn is_wall(&self) -> bool {
        matches!(self.stands, Stands::AsWall(_))
    }

    /// So much of what it says is heard, as log odds.
    pub fn hear(&mut self, log_odds: f32) {
        self.heard += log_odds;
    }

    /// Takes in the range of a row, and what it says.
    #[inline(never)]
    pub fn look(&mut self, sensor: &RangeSensor, input: RangeInput, motion: &Motion) -> Says {
        let before = core::mem::replace(self, Self::NONE);
        let (RangeModel::Metric { noise_m, noise_rel }, RangeInput::Metres(now_m)) = (sensor.model, input) else {
            return Says::default();
        };
        if !(now_m >= sensor.min_m && now_m <= sensor.max_m) {
            return Says::default();
        }
        self.last_m = now_m;
        let change = match before.stands {
            Stands::AsWall(normal) => before.change_of_wall(&sensor.mount, normal.rad(), motion),
            _ => before.change(&sensor.mount, now_m, motion),
        };
        let Some(change) = change else { return Says::default() };
        let noise_m = noise_m + noise_rel * now_m;
        let relief_m = if before.is_wall() { RELIEF_M } else { 0.0 };
        let ranges_m2 = 2.0 * noise_m * noise_m + relief_m * relief_m;
        let stamps_m2 = STAMP_SHARE * motion.longest_m * motion.longest_m;
        let changed_m = now_m - change.turned_m;
        let row_m2 = if before.is_wall() { ranges_m2 + change.variance_m2 + stamps_m2 } else { noise_m * noise_m };
        if changed_m.abs() > change.most_m + SIGMAS * float::sqrtf(row_m2) {
            return Says::default();
        }
        let first_m2 = if before.forwards_m == 0.0 { stamps_m2 } else { 0.0 };
        *self = Self {
            last_m: now_m,
            stands: before.stands.after(motion.turn_rad),
            changed_m: before.changed_m + changed_m,
            forwards_m: before.forwards_m + change.forwards_m,
            variance_m2: before.variance_m2 + change.variance_m2 + first_m2,
            ..before
        };
        let scale_m2 = SCALE_SHARE * self.forwards_m * self.forwards_m;
        self.judge(ranges_m2 + stamps_m2 + scale_m2 + self.variance_m2, change.tangent, sensor.span_m())
    }

    /// What its change over this stretch says, where that has this variance, m^2, beside that of a surface that may stand anyhow to a beam with this
    /// tangent, or is, as likely, anything that the sensor can read. What moves by itself is explained as well as by the better of both ways.
    fn judge(&mut self, variance_m2: f32, tangent: f32, span_m: f32) -> Says {
        let fits = [1.0, -1.0].map(|way| 1.0 + span_m * self.driven(way, variance_m2, tangent));
        let best = fits[0].max(fits[1]);
        let at_rest = 1.0 - if self.is_wall() { MOVING_WALLS } else { MOVING };
        let (mut likelihoods, mut doubts) = ([0.0; 2], [0.0; 2]);
        for (((likelihood, doubt), before), fit) in likelihoods.iter_mut().zip(&mut doubts).zip(self.doubts).zip(fits) {
            let rests = at_rest * (1.0 - before);
            let explained = rests * fit / best;
            *likelihood = explained + 1.0 - rests;
            *doubt = (1.0 - ANOTHER) * (1.0 - explained / *likelihood / at_rest);
        }
        let odds = |[forwards, backwards]: [f32; 2]| libm::logf(backwards / forwards);
        let says = odds(likelihoods);
        let more = says - self.heard;
        if self.forwards_m.abs() > STRETCH_M {
            // What is not heard now is left for the next.
            let ratio = Ratio::new(self.changed_m / self.forwards_m);
            let stands = if self.is_wall() { self.stands } else { Stands::Askew(ratio) };
            *self = Self { last_m: self.last_m, stands, doubts, heard: -more, ..Self::NONE };
        }
        Says { at_rest: odds(fits), more }
    }

    /// Density of its change over this stretch, 1/m, if the robot drives forwards (1) or backwards (-1).
    fn driven(&self, way: f32, variance_m2: f32, tangent: f32) -> f32 {
        let (faces_m, across_m) = (way * self.forwards_m, tangent * self.forwards_m);
        let part = |&(tangent, sigma): &(f32, f32)| {
            let part_m = sigma * across_m;
            density(self.changed_m - faces_m - tangent * across_m, variance_m2 + part_m * part_m)
        };
        let another = if across_m == 0.0 {
            density(self.changed_m - faces_m, variance_m2)
        } else {
            PARTS.iter().map(part).sum::<f32>() / PARTS.len() as f32
        };
        let Stands::Askew(ratio) = self.stands else { return another };
        // The ratio is known as well as a stretch tells it.
        let stretches = self.forwards_m / STRETCH_M;
        let same =
            density(self.changed_m - ratio.value() * self.forwards_m, variance_m2 * (1.0 + stretches * stretches));
        same + ANOTHER * (another - same)
    }

    /// Of a surface that may stand anyhow, seen now at this range.
    fn change(&self, mount: &Mount, now_m: f32, motion: &Motion) -> Option<Change> {
        let (sin, cos) = sin_cos(mount.bearing_rad);
        if self.last_m == 0.0 || cos.abs() < LEAST_SHARE {
            return None;
        }
        let swept_m = now_m * motion.turn_rad;
        Some(Change {
            turned_m: self.last_m,
            forwards_m: -motion.forward_m * cos,
            variance_m2: swept_m * swept_m,
            tangent: (sin / cos).abs(),
            most_m: SAME_SURFACE * motion.longest_m + swept_m.abs(),
        })
    }

    /// Of a wall with this normal. The robot moves and then turns.
    fn change_of_wall(&self, mount: &Mount, normal_rad: f32, motion: &Motion) -> Option<Change> {
        let turn_rad = motion.turn_rad;
        let (sin, cos) = sin_cos(normal_rad);
        let before_cos = sin_cos(normal_rad - mount.bearing_rad).1;
        let (now_sin, now_cos) = sin_cos(normal_rad - turn_rad - mount.bearing_rad);
        let is_oblique = before_cos.abs() < LEAST_COS || now_cos.abs() < LEAST_COS;
        if is_oblique || cos.abs() < LEAST_SHARE_OF_WALL * now_cos.abs() {
            return None;
        }
        // The turn takes a sensor along that is not on the axle's centre.
        let beside_m = self.last_m * before_cos - turn_rad * (sin * mount.x_m - cos * mount.y_m);
        let (turned_m, share) = (beside_m / now_cos, cos / now_cos);
        let swept_m = turned_m * turn_rad * now_sin / now_cos;
        Some(Change {
            turned_m,
            forwards_m: -motion.forward_m * share,
            variance_m2: STAMP_SHARE * swept_m * swept_m,
            tangent: 0.0,
            most_m: (motion.longest_m * share).abs(),
        })
    }
}
