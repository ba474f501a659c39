//! What a reading says: which wall a beam met, what it should have read there, and the update (report eqs. 1, 3 and 5).

pub mod beam;
pub mod data_association;
pub mod first_estimates;
pub mod line_of_sight;
pub mod observe;
pub mod sensor;
