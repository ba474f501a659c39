//! A wall of the diary.

use slam_core::Standing;
use slam_core::angle::sin_cos;

use crate::frame::dot;

/// A wall: the points p with p . (cos beta, sin beta) = rho, from lo to hi along (-sin beta, cos beta).
#[derive(Clone, Copy, Debug)]
pub struct Wall {
    /// Signed distance of its line from the origin along the normal, metres.
    pub rho_m: f32,
    /// Direction of the normal, radians. It points away from the side that the wall is seen from.
    pub beta_rad: f32,
    /// Start of the extent on which hits are, metres.
    pub lo_m: f32,
    /// End of it, metres.
    pub hi_m: f32,
    /// Hits that are on it.
    pub hits: u32,
    /// Whether its direction is one of the grid's.
    pub on_grid: bool,
    /// How the filter has it stand to the grid, where that decides so wall by wall.
    pub(crate) told: Standing,
    /// Place along it about which its line is turned, metres.
    pub(crate) anchor_m: f32,
    /// Whether its line is known.
    pub(crate) is_placed: bool,
}

/// A line of the map.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Signed distance from the origin along the normal, metres.
    pub rho_m: f32,
    /// Unit normal.
    pub normal: [f32; 2],
}

impl Line {
    /// Unit direction along it.
    pub fn tangent(&self) -> [f32; 2] {
        [-self.normal[1], self.normal[0]]
    }

    /// The point at a place along it, metres.
    pub fn at(&self, along_m: f32) -> [f32; 2] {
        let ([nx, ny], [tx, ty]) = (self.normal, self.tangent());
        [self.rho_m * nx + along_m * tx, self.rho_m * ny + along_m * ty]
    }
}

impl Wall {
    /// One whose line is not known yet.
    pub(crate) const NEW: Self = Self {
        rho_m: 0.0,
        beta_rad: 0.0,
        lo_m: 0.0,
        hi_m: 0.0,
        hits: 0,
        on_grid: false,
        told: Standing::Unknown,
        anchor_m: 0.0,
        is_placed: false,
    };

    pub(crate) fn line(&self) -> Line {
        let (sin, cos) = sin_cos(self.beta_rad);
        Line { rho_m: self.rho_m, normal: [cos, sin] }
    }

    /// Turns it about the middle of what was seen of it from now on.
    pub(crate) fn anchor(&mut self) {
        if self.lo_m < self.hi_m {
            self.anchor_m = 0.5 * (self.lo_m + self.hi_m);
        }
    }

    /// Moves its line by so much at the anchor, and turns it there.
    pub(crate) fn shift(&mut self, by_m: f32, by_rad: f32) {
        self.put(self.line().at(self.anchor_m), by_rad);
        self.rho_m += by_m;
    }

    /// Puts its anchor there, metres, and turns it by so much.
    pub(crate) fn put(&mut self, anchor_m: [f32; 2], by_rad: f32) {
        self.beta_rad = slam_core::angle::wrap(self.beta_rad + by_rad);
        let turned = self.line();
        (self.rho_m, self.anchor_m) = (dot(turned.normal, anchor_m), dot(turned.tangent(), anchor_m));
    }
}
