//! How the extents of a fresh and a kept wall lie beside each other.

use crate::odds;
use crate::side::{Side, dot};

/// An extent overlaps another one also where it ends so much before, metres.
const ENDS_M: f32 = 0.15;

/// Where the fresh map lies.
pub(crate) struct Extents {
    /// Shift of the fresh map, metres; none where its walls may be anywhere along their lines.
    shift_m: Option<[f32; 2]>,
}

impl Extents {
    pub(crate) const ANYWHERE: Self = Self { shift_m: None };

    pub(crate) fn at(shift_m: [f32; 2]) -> Self {
        Self { shift_m: Some(shift_m) }
    }

    /// Share of a fresh wall's extent that a kept one reaches along.
    pub(crate) fn overlap(&self, a: &Side, b: &Side) -> f32 {
        let Some(shift_m) = self.shift_m else { return 1.0 };
        let [x, y] = b.across();
        let along_m = |point_m: [f32; 2]| dot([-y, x], point_m);
        let apart_m = along_m(a.middle_m()) + along_m(shift_m) - along_m(b.middle_m());
        let [half_m, reach_m] = [0.5 * a.length_m(), 0.5 * b.length_m() + ENDS_M];
        let common_m = (apart_m + half_m).min(reach_m) - (apart_m - half_m).max(-reach_m);
        (common_m / a.length_m().max(1e-3)).clamp(0.0, 1.0)
    }

    /// How much likelier their ends, of these weights, are those of one wall than of any two.
    pub(crate) fn ends(&self, a: &Side, b: &Side, weights: [f32; 2]) -> f32 {
        let both = |lo_m: f32, hi_m: f32| {
            float::powf(odds::of_end(lo_m), weights[0]) * float::powf(odds::of_end(hi_m), weights[1])
        };
        if let Some(shift_m) = self.shift_m {
            let along_m = shift_m[1 - a.axis()];
            return both(a.extent_m[0] + along_m - b.extent_m[0], a.extent_m[1] + along_m - b.extent_m[1]);
        }
        // Both in the middle between, or one on the other.
        let longer_m = a.length_m() - b.length_m();
        both(0.5 * longer_m, 0.5 * longer_m).max(both(0.0, longer_m)).max(both(longer_m, 0.0))
    }
}
