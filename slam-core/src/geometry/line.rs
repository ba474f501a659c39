//! A straight line in the plane by its normal (Hesse form).

/// The points p with p . normal = rho.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Signed distance from the origin along the normal, metres.
    pub rho_m: f32,
    /// Direction of the normal, radians.
    pub beta_rad: f32,
    /// Unit normal.
    pub normal: [f32; 2],
}

impl Line {
    /// Coordinate of a point along (-sin beta, cos beta), metres.
    pub fn along(&self, point: [f32; 2]) -> f32 {
        point[1] * self.normal[0] - point[0] * self.normal[1]
    }

    /// The point at a coordinate along (-sin beta, cos beta), metres.
    pub fn at(&self, along_m: f32) -> [f32; 2] {
        let [x, y] = self.normal;
        [self.rho_m * x - along_m * y, self.rho_m * y + along_m * x]
    }

    /// Signed distance of the line from a point along the normal, metres.
    pub fn distance(&self, point: [f32; 2]) -> f32 {
        self.rho_m - (point[0] * self.normal[0] + point[1] * self.normal[1])
    }
}
