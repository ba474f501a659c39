//! How the extents of a fresh and a kept wall lie beside each other.

use crate::odds;
use crate::side::Side;

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
        let along_m = shift_m[1 - a.axis()];
        let [lo_m, hi_m] = a.extent_m.map(|end_m| end_m + along_m);
        let common_m = hi_m.min(b.extent_m[1] + ENDS_M) - lo_m.max(b.extent_m[0] - ENDS_M);
        (common_m / a.length_m().max(1e-3)).clamp(0.0, 1.0)
    }

    /// How much likelier their ends, of these weights, are those of one wall than of any two.
    pub(crate) fn ends(&self, a: &Side, b: &Side, weights: [f32; 2]) -> f32 {
        let both = |lo_m: f32, hi_m: f32| {
            libm::powf(odds::of_end(lo_m), weights[0]) * libm::powf(odds::of_end(hi_m), weights[1])
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
