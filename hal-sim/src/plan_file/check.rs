//! Values of a floor plan file that cannot be.

use super::PlanError;

/// Farthest a coordinate may be from the plan's origin, metres.
const LARGEST_M: f64 = 1000.0;

const COORDINATE: &str = "metres between -1000 and 1000 are allowed";

/// Checks values and names the place of a bad one.
pub(super) struct Check<'a> {
    pub file: &'a str,
}

impl Check<'_> {
    pub fn fail<T>(&self, key: String, allowed: &'static str) -> Result<T, PlanError> {
        Err(PlanError::Value { file: self.file.into(), key, allowed })
    }

    pub fn point(&self, key: &str, point_m: [f64; 2]) -> Result<(), PlanError> {
        if point_m.iter().all(|value| value.abs() <= LARGEST_M) { Ok(()) } else { self.fail(key.into(), COORDINATE) }
    }

    pub fn positive(&self, key: &str, value: f64) -> Result<(), PlanError> {
        if value > 0.0 && value <= LARGEST_M {
            Ok(())
        } else {
            self.fail(key.into(), "a number above 0 and up to 1000 is allowed")
        }
    }

    pub fn rectangle(&self, key: &str, min_m: [f64; 2], max_m: [f64; 2]) -> Result<(), PlanError> {
        self.point(&format!("{key}.min_m"), min_m)?;
        self.point(&format!("{key}.max_m"), max_m)?;
        if min_m[0] < max_m[0] && min_m[1] < max_m[1] {
            Ok(())
        } else {
            self.fail(format!("{key}.max_m"), "both coordinates must be larger than min_m's")
        }
    }

    pub fn segment(&self, key: &str, from_m: [f64; 2], to_m: [f64; 2]) -> Result<(), PlanError> {
        self.point(&format!("{key}.from_m"), from_m)?;
        self.point(&format!("{key}.to_m"), to_m)?;
        if libm::hypot(to_m[0] - from_m[0], to_m[1] - from_m[1]) > 1e-3 {
            Ok(())
        } else {
            self.fail(format!("{key}.to_m"), "must be at least 1 mm from from_m")
        }
    }
}
