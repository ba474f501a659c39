//! A straight line through outliers: is it one, and which one with what uncertainty.

use crate::births::buffer::Outlier;
use crate::geometry::angle::sin_cos;
use crate::sensing::range::SURFACE_M;
use heapless::Vec;

/// Weighted first and second moments of points, about a reference point (so that f32 suffices).
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    reference_m: [f32; 2],
    relief_m2: f32,
    count: u32,
    weight: f32,
    first: [f32; 2],
    xx: f32,
    xy: f32,
    yy: f32,
}

/// Scatter of weighted points along and across their main direction.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    /// Centroid, metres.
    pub centroid_m: [f32; 2],
    /// Direction of the least scatter (the line's normal), radians.
    pub normal_rad: f32,
    /// Sum of squared distances across the line over their variances: chi-square with `count - 2` degrees of freedom.
    pub across: f32,
    /// Number of points.
    pub count: u32,
}

impl Moments {
    /// No points yet, of a surface with this relief, metres.
    pub fn about(reference_m: [f32; 2], relief_m: f32) -> Self {
        Self {
            reference_m,
            relief_m2: relief_m * relief_m,
            count: 0,
            weight: 0.0,
            first: [0.0; 2],
            xx: 0.0,
            xy: 0.0,
            yy: 0.0,
        }
    }

    /// Adds a point.
    pub fn add(&mut self, point: &Outlier) {
        let weight = 1.0 / (point.sigma_m * point.sigma_m + self.relief_m2).max(1e-8);
        let x = point.hit_m[0] - self.reference_m[0];
        let y = point.hit_m[1] - self.reference_m[1];
        self.count += 1;
        self.weight += weight;
        self.first[0] += weight * x;
        self.first[1] += weight * y;
        self.xx += weight * x * x;
        self.xy += weight * x * y;
        self.yy += weight * y * y;
    }

    /// Centroid, directions and scatter.
    pub fn scatter(&self) -> Scatter {
        let inverse = 1.0 / self.weight.max(1e-8);
        let [x, y] = [self.first[0] * inverse, self.first[1] * inverse];
        let xx = self.xx - self.first[0] * x;
        let xy = self.xy - self.first[0] * y;
        let yy = self.yy - self.first[1] * y;
        let half_difference = 0.5 * (xx - yy);
        let mean = 0.5 * (xx + yy);
        let radius = float::sqrtf(half_difference * half_difference + xy * xy);
        let along_rad = 0.5 * libm::atan2f(xy, half_difference);
        Scatter {
            centroid_m: [self.reference_m[0] + x, self.reference_m[1] + y],
            normal_rad: along_rad + core::f32::consts::FRAC_PI_2,
            across: (mean - radius).max(0.0),
            count: self.count,
        }
    }
}

/// Noise or line (Rousse & Qiu 3.3): the scatter across is what the measurement noise makes of a straight line, to 2 sigma of
/// its chi-square distribution.
fn is_noise_of_line(chi_square: f32, count: u32) -> bool {
    let freedom = count.saturating_sub(2) as f32;
    chi_square <= freedom + 2.0 * float::sqrtf(2.0 * freedom)
}

impl Scatter {
    /// Whether the points can be a straight line, before its direction is known: with the noise of each along its beam, and the surface's relief.
    pub fn is_straight(&self) -> bool {
        is_noise_of_line(self.across, self.count)
    }
}

/// What a parameter of the robot does to a fitted line, through the points that it shifts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Influence {
    offset: f32,
    slope: f32,
}

/// A line fitted to outliers, in the odometry frame.
#[derive(Clone, Copy, Debug)]
pub struct FittedLine {
    /// Weighted centroid, metres.
    pub centroid_m: [f32; 2],
    /// Direction of the normal away from the robot, radians.
    pub normal_rad: f32,
    /// Unit normal.
    pub normal: [f32; 2],
    /// Variance of the centroid along the normal, m^2.
    pub variance_m2: f32,
    /// Variance of the direction, rad^2.
    pub direction_variance: f32,
    /// Number of points.
    pub count: u32,
    /// Mean cosine of the beams' incidence.
    pub cos_incidence: f32,
    /// Chi-square of the residuals, with `count - 2` degrees of freedom.
    pub chi_square: f32,
    /// How much the points bend away from a straight line, in standard deviations.
    pub bend: f32,
    /// Extent along (-sin, cos) of the normal about the centroid, metres.
    pub lo_m: f32,
    /// End of the extent, metres.
    pub hi_m: f32,
    /// Mean position variance of the points, m^2.
    pub position_variance: f32,
    /// Mean heading variance of the points, rad^2.
    pub heading_variance: f32,
    /// Relief of the surface that the points' weights allow for, metres.
    pub relief_m: f32,
}

/// Variance of a point along the line's normal, m^2: range noise acts along the beam, the sweep across it, and the surface's
/// relief along the normal whatever the beam.
fn across_variance(point: &Outlier, normal: [f32; 2], relief_m: f32) -> f32 {
    let cos = point.direction[0] * normal[0] + point.direction[1] * normal[1];
    let sin = point.direction[1] * normal[0] - point.direction[0] * normal[1];
    let (range, sweep) = (point.sigma_m * cos, point.sweep_m * sin);
    range * range + sweep * sweep + SURFACE_M * SURFACE_M + relief_m * relief_m
}

/// A point in the line's own axes, about the points' centroid: along it, across it, metres, and its weight, 1/m^2.
struct Local {
    t: f32,
    n: f32,
    weight: f32,
}

/// Least squares across the line, with each point's noise along its own beam; one Gauss-Newton step from `scatter`. At most
/// `B` points.
pub fn fit<'a, const B: usize>(
    points: impl Iterator<Item = &'a Outlier> + Clone,
    scatter: &Scatter,
    relief_m: f32,
) -> FittedLine {
    let (s, c) = sin_cos(scatter.normal_rad);
    // Beams run into the wall: the normal points away from the robot.
    let facing: f32 = points.clone().map(|p| p.direction[0] * c + p.direction[1] * s).sum();
    let sign = if facing < 0.0 { -1.0 } else { 1.0 };
    let normal = [sign * c, sign * s];
    let tangent = [-normal[1], normal[0]];
    let reference = scatter.centroid_m;
    let mut locals: Vec<Local, B> = Vec::new();
    let (mut weight_sum, mut st, mut sn) = (0.0f32, 0.0f32, 0.0f32);
    let (mut position, mut heading) = (0.0f32, 0.0f32);
    for p in points {
        let d = [p.hit_m[0] - reference[0], p.hit_m[1] - reference[1]];
        let (t, n) = (d[0] * tangent[0] + d[1] * tangent[1], d[0] * normal[0] + d[1] * normal[1]);
        let weight = 1.0 / across_variance(p, normal, relief_m);
        weight_sum += weight;
        st += weight * t;
        sn += weight * n;
        position += p.position_variance;
        heading += p.heading_variance;
        let _ = locals.push(Local { t, n, weight });
    }
    let inverse = 1.0 / weight_sum.max(1e-8);
    let (t0, n0) = (st * inverse, sn * inverse);
    for local in &mut locals {
        local.t -= t0;
        local.n -= n0;
    }
    let shape = Shape::of(&locals, inverse);
    let normal_rad = scatter.normal_rad + if sign < 0.0 { core::f32::consts::PI } else { 0.0 } - shape.slope;
    let (s, c) = sin_cos(normal_rad);
    let count = locals.len() as u32;
    let each = 1.0 / count.max(1) as f32;
    FittedLine {
        centroid_m: [reference[0] + t0 * tangent[0] + n0 * normal[0], reference[1] + t0 * tangent[1] + n0 * normal[1]],
        normal_rad,
        normal: [c, s],
        variance_m2: inverse,
        direction_variance: 1.0 / shape.spread,
        count,
        cos_incidence: facing.abs() * each,
        chi_square: shape.chi_square,
        bend: shape.bend,
        lo_m: shape.lo_m,
        hi_m: shape.hi_m,
        position_variance: position * each,
        heading_variance: heading * each,
        relief_m,
    }
}

/// What the points about their centroid say of the line.
struct Shape {
    /// Of the line against its first direction.
    slope: f32,
    /// Sum of the weighted squares along the line, never zero.
    spread: f32,
    chi_square: f32,
    bend: f32,
    lo_m: f32,
    hi_m: f32,
}

impl Shape {
    fn of(points: &[Local], inverse: f32) -> Self {
        let (mut stt, mut stn, mut sttt) = (0.0f32, 0.0f32, 0.0f32);
        let (mut lo_m, mut hi_m) = (f32::MAX, f32::MIN);
        for &Local { t, n, weight } in points {
            sttt += weight * t * t * t;
            stt += weight * t * t;
            stn += weight * t * n;
            lo_m = if t < lo_m { t } else { lo_m };
            hi_m = if t > hi_m { t } else { hi_m };
        }
        let spread = stt.max(1e-8);
        let slope = stn / spread;
        // The part of t^2 that no straight line explains, against the residuals: a corner within the points bends them.
        let (mut projection, mut norm, mut chi_square) = (0.0f32, 0.0f32, 0.0f32);
        for &Local { t, n, weight } in points {
            let residual = n - slope * t;
            chi_square += weight * residual * residual;
            let square = t * t - stt * inverse - t * sttt / spread;
            projection += weight * square * residual;
            norm += weight * square * square;
        }
        let bend = projection.abs() / float::sqrtf(norm.max(1e-8));
        Self { slope, spread, chi_square, bend, lo_m, hi_m }
    }
}

impl FittedLine {
    /// Whether the points are a straight line, with the noise of each across it, and not bent around a corner (3 sigma).
    pub fn is_straight(&self) -> bool {
        is_noise_of_line(self.chi_square, self.count) && self.bend < 3.0
    }

    /// d(centroid along the normal, direction) by a parameter that shifts some of the points, each by so much, metres.
    pub fn by_parameter(&self, influence: &Influence) -> (f32, f32) {
        (influence.offset * self.variance_m2, -influence.slope * self.direction_variance)
    }

    /// Weight of a point in the fit, and that times its coordinate along the line.
    pub fn weight(&self, point: &Outlier) -> (f32, f32) {
        let weight = 1.0 / across_variance(point, self.normal, self.relief_m);
        (weight, weight * self.along(point.hit_m))
    }

    /// Adds what a shift of a point with this weight does.
    pub fn add_shift(&self, influence: &mut Influence, (weight, lever): (f32, f32), shift: [f32; 2]) {
        let across = shift[0] * self.normal[0] + shift[1] * self.normal[1];
        influence.offset += weight * across;
        influence.slope += lever * across;
    }

    /// Signed distance of a point from the line along the normal, metres, and the line's own standard deviation there.
    pub fn residual(&self, point: [f32; 2]) -> (f32, f32) {
        let d = [point[0] - self.centroid_m[0], point[1] - self.centroid_m[1]];
        let t = d[1] * self.normal[0] - d[0] * self.normal[1];
        let variance = self.variance_m2 + t * t * self.direction_variance;
        (d[0] * self.normal[0] + d[1] * self.normal[1], float::sqrtf(variance))
    }

    /// Coordinate of a point along the line about the centroid, metres.
    pub fn along(&self, point: [f32; 2]) -> f32 {
        (point[1] - self.centroid_m[1]) * self.normal[0] - (point[0] - self.centroid_m[0]) * self.normal[1]
    }

    /// Length of the extent, metres.
    pub fn length_m(&self) -> f32 {
        self.hi_m - self.lo_m
    }
}
