//! What was seen of one surface from one keyframe, as sums: they tell the squared distances to any line exactly.

use core::num::NonZeroU8;

use crate::frame::{Frame, dot};
use crate::gains::Gains;
use crate::keyframe::SPACING_M;
use crate::wall::Line;

/// Marks the sensor of hits on several stretches.
const SEVERAL: u8 = 0x80;

/// A sensor that no robot has: its gain is known.
pub const NO_SENSOR: u8 = !SEVERAL;

/// Hits on one surface, in their keyframe's frame: their weight, mean and scatter, kept as Welford (1962) does so that f32
/// holds a scatter of millimetres at a distance of metres.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Sum of the weights, 1/m^2.
    pub weight: f32,
    /// Of so many hits that say something new.
    pub independent: f32,
    /// Where their beams began, on average, metres.
    pub from_m: [f32; 2],
    /// Their mean, metres.
    pub mean_m: [f32; 2],
    /// Weighted squares of their distance from the mean: xx, xy, yy.
    pub scatter: [f32; 3],
    /// Hits; saturates.
    pub hits: u16,
    /// The sensor of the first of them, marked where they are on several stretches: a byte more for each would not fit on the robot.
    maker: u8,
    label: Option<NonZeroU8>,
}

/// How a group lies to a line.
#[derive(Clone, Copy, Debug)]
pub struct Offset {
    /// How far the mean is behind the line, metres.
    pub behind_m: f32,
    /// Where along the line the mean is, metres.
    pub along_m: f32,
    /// The mean in the map, metres.
    pub mean_m: [f32; 2],
    /// Scatter along the line.
    pub along: f32,
    /// Product of the scatter along and across.
    pub cross: f32,
    /// Mean square of the hits' distance from the line, in variances of a hit.
    pub square: f32,
}

impl Group {
    /// Of one hit: where its beam began and ended, metres, its weight, 1/m^2, and of how many it is one.
    pub fn of(from_m: [f32; 2], at_m: [f32; 2], weight: f32, alike: f32, sensor: u8) -> Self {
        let independent = 1.0 / alike;
        Self {
            weight,
            independent,
            from_m,
            mean_m: at_m,
            scatter: [0.0; 3],
            hits: 1,
            maker: sensor & !SEVERAL,
            label: None,
        }
    }

    /// The sensor of the first of its hits, with whose gain it goes.
    pub fn sensor(&self) -> u8 {
        self.maker & !SEVERAL
    }

    /// Whether the hits of both are of one sensor, on one stretch or on several.
    pub fn is_by_sensor_of(&self, other: &Group) -> bool {
        self.maker == other.maker
    }

    /// Whether both are of one sensor and on one wall, or on none: as one number, for each hit of a step is held against many groups.
    pub fn is_like(&self, other: &Group) -> bool {
        let key = |group: &Group| u16::from_le_bytes([group.maker, group.label.map_or(0, NonZeroU8::get)]);
        key(self) == key(other)
    }

    /// Whether both are on one wall, or on none.
    pub fn is_on_wall_of(&self, other: &Group) -> bool {
        self.label == other.label
    }

    /// The same hits, with the gain of another one.
    pub fn by_sensor(&self, sensor: u8) -> Self {
        Self { maker: self.maker & SEVERAL | sensor & !SEVERAL, ..*self }
    }

    /// The wall that it is on.
    pub fn wall(&self) -> Option<usize> {
        self.label.map(|label| usize::from(label.get()) - 1)
    }

    /// Puts it on a wall, or on none.
    pub fn set_wall(&mut self, wall: Option<usize>) {
        self.label = wall.and_then(|wall| NonZeroU8::new(u8::try_from(wall + 1).ok()?));
    }

    /// Takes in another one in the same frame.
    pub fn add(&mut self, other: &Group) {
        let weight = self.weight + other.weight;
        if weight <= 0.0 {
            return;
        }
        let share = other.weight / weight;
        let [dx, dy] = [other.mean_m[0] - self.mean_m[0], other.mean_m[1] - self.mean_m[1]];
        let between = self.weight * share;
        self.mean_m = [self.mean_m[0] + share * dx, self.mean_m[1] + share * dy];
        for (own, theirs) in self.from_m.iter_mut().zip(other.from_m) {
            *own += share * (theirs - *own);
        }
        for ((own, theirs), square) in self.scatter.iter_mut().zip(other.scatter).zip([dx * dx, dx * dy, dy * dy]) {
            *own += theirs + between * square;
        }
        self.weight = weight;
        self.independent += other.independent;
        self.hits = self.hits.saturating_add(other.hits);
    }

    /// Whether its hits are one stretch of a surface. Of stretches with something before the surface between them, the sums would have
    /// one across it, and their mean beam would go through it.
    pub fn is_stretch(&self) -> bool {
        self.maker & SEVERAL == 0
    }

    /// Whether the hits of both are one stretch, for all that is between them.
    pub fn is_one_stretch_with(&self, other: &Group) -> bool {
        if !(self.is_stretch() && other.is_stretch()) {
            return false;
        }
        let [dx, dy] = [0, 1].map(|i| self.mean_m[i] - other.mean_m[i]);
        let apart_m2 = dx * dx + dy * dy;
        let reach_m2 = |group: &Group| 3.0 * (group.scatter[0] + group.scatter[2]) / group.weight;
        let [one_m2, other_m2] = [reach_m2(self), reach_m2(other)];
        let squares = one_m2 + other_m2 + SPACING_M * SPACING_M;
        // The square of a sum of three is between the sum of their squares and three times that: mostly no root is needed.
        apart_m2 <= squares
            || (apart_m2 <= 3.0 * squares && {
                let reach_m = float::sqrtf(one_m2) + float::sqrtf(other_m2) + SPACING_M;
                apart_m2 <= reach_m * reach_m
            })
    }

    /// Takes in another one on the same wall and in the same frame, as its own sensor would have reported it. It comes by
    /// value: a hit whose address is passed on is in memory where it is added, too.
    pub fn take_in(&mut self, other: Group, gains: &Gains) {
        if !self.is_one_stretch_with(&other) {
            self.maker |= SEVERAL;
        }
        self.add(&gains.told_by(self.sensor(), &other));
    }

    /// The same group in the frame that `frame` is given in.
    pub fn moved(&self, frame: &Frame) -> Self {
        Self {
            from_m: frame.point(self.from_m),
            mean_m: frame.point(self.mean_m),
            scatter: frame.scatter(self.scatter),
            ..*self
        }
    }

    /// Variance of a hit, m^2.
    pub fn variance(&self) -> f32 {
        self.independent / self.weight
    }

    /// How it lies to a line of the map, seen from a keyframe.
    pub fn offset(&self, frame: &Frame, line: &Line) -> Offset {
        let mean_m = frame.point(self.mean_m);
        let [xx, xy, yy] = frame.scatter(self.scatter);
        let ([nx, ny], [tx, ty]) = (line.normal, line.tangent());
        let across = nx * (xx * nx + xy * ny) + ny * (xy * nx + yy * ny);
        let behind_m = dot(line.normal, mean_m) - line.rho_m;
        Offset {
            behind_m,
            along_m: dot(line.tangent(), mean_m),
            mean_m,
            along: (tx * (xx * tx + xy * ty) + ty * (xy * tx + yy * ty)).max(0.0),
            cross: nx * (xx * tx + xy * ty) + ny * (xy * tx + yy * ty),
            square: (self.weight * behind_m * behind_m + across.max(0.0)) / self.independent,
        }
    }

    /// How far from its mean a group reaches along a line, metres: where its hits are spread evenly, or half of them at each end.
    pub fn reach_m(&self, offset: &Offset) -> f32 {
        let squares = if self.is_stretch() { 3.0 } else { 1.0 };
        float::sqrtf(squares * offset.along / self.weight)
    }
}
