//! What beams last found at which place of which wall: who sees the same thing again learns nothing new.

/// Length of a place along its wall, metres: the shortest wall is as long.
pub const PLACE_M: f32 = 0.25;

/// Shelves, and places on each: together the ten metres of walls about a robot that sweeps a corner of a room.
const SHELVES: usize = 8;
const ON_EACH: usize = 5;

/// What a beam that should have met a wall found there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// The wall.
    Fits = 1,
    /// Something nearer.
    Hidden = 2,
    /// Something farther, or nothing.
    Passed = 3,
}

/// The places that were seen last: what was seen there in the lowest two bits, and a number for wall and place by hashing in the others. The
/// latest is the first on its shelf; one in three thousand is taken for another.
#[derive(Clone, Copy, Debug)]
pub struct Sightings([[u16; ON_EACH]; SHELVES]);

impl Sightings {
    /// Nothing was seen.
    pub const NONE: Self = Self([[0; ON_EACH]; SHELVES]);

    /// Takes in what was seen in place of a wall where that should have been met, metres along it: whether it is new.
    pub fn is_new(&mut self, wall: u16, along_m: f32, sight: Sight) -> bool {
        let stretch = (along_m * (1.0 / PLACE_M)) as i32 as u32;
        // Multiplicative hashing (Knuth, The Art of Computer Programming, 6.4).
        let hash = (stretch << 16 ^ u32::from(wall)).wrapping_mul(0x9E37_79B1);
        let seen = (hash >> 13) as u16 & !3 | sight as u16;
        let Some(shelf) = self.0.get_mut((hash >> 29) as usize) else { return false };
        if let Some(last) = shelf.iter_mut().find(|last| (**last ^ seen) < 4) {
            return core::mem::replace(last, seen) != seen;
        }
        shelf.copy_within(..ON_EACH - 1, 1);
        shelf[0] = seen;
        true
    }
}
