//! The map against the true plan.
