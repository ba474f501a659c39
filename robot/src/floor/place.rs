//! Places that are kept for a while, in four bytes each.

/// Places that were given up, to be tried once more.
pub(super) const GIVEN_UP: usize = 16;

/// What a metre is in the unit of the coordinates.
const CM: f32 = 100.0;

/// A place in the job's frame, in centimetres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place([i16; 2]);

impl Place {
    /// The place at a point, metres.
    pub(super) fn of_m(at_m: [f32; 2]) -> Self {
        Self(at_m.map(|value_m| (value_m * CM) as i16))
    }

    /// Where it is, metres.
    pub(super) fn at_m(&self) -> [f32; 2] {
        self.0.map(|value| f32::from(value) / CM)
    }
}
