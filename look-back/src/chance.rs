//! What lies near a wall by chance.

/// Faces that look the same way are about so far apart, metres, where furniture stands before walls: in homes drawn at random a wall has one
/// every 1.3 m between 0.3 and 0.6 m from it, every 2.3 m up to 1 m, and every 3 to 7 m beyond. Where what is known of two leaves them anywhere
/// within it, one lies by chance where the other may be, and says nothing.
const APART_M: f32 = 1.5;

/// Squared distance over its variance, m^2, up to which what lies there is likelier the same surface than another one: the density of its
/// distance is above that of other faces. Below zero where it is known too badly for any to be.
pub fn likelier_same(variance: f32) -> f32 {
    libm::logf(APART_M * APART_M / (core::f32::consts::TAU * variance))
}
