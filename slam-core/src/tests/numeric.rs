//! Numerical derivatives, and models written down a second time in f64.

/// Central difference of `f` by entry `i` of its argument.
pub fn derivative<const N: usize>(f: impl Fn(&[f64; N]) -> f64, at: &[f64; N], i: usize) -> f64 {
    let step = 1e-6;
    let (mut above, mut below) = (*at, *at);
    above[i] += step;
    below[i] -= step;
    (f(&above) - f(&below)) / (2.0 * step)
}

/// Range along the ray from `origin` with direction `phi` to the line (rho, beta), by Cramer's rule on
/// origin + r u = rho n + s t.
pub fn ray_to_line(origin: [f64; 2], phi: f64, rho: f64, beta: f64) -> f64 {
    let u = [phi.cos(), phi.sin()];
    let n = [beta.cos(), beta.sin()];
    let t = [-n[1], n[0]];
    let b = [rho * n[0] - origin[0], rho * n[1] - origin[1]];
    (t[0] * b[1] - b[0] * t[1]) / (t[0] * u[1] - u[0] * t[1])
}

/// Where a beam starts, and its direction, for a robot at (x, y, theta) and a mount (x, y, bearing).
pub fn beam([x, y, theta]: [f64; 3], [mx, my, psi]: [f64; 3]) -> ([f64; 2], f64) {
    let (s, c) = theta.sin_cos();
    ([x + c * mx - s * my, y + s * mx + c * my], theta + psi)
}

/// The wheels' exact arc about its centre: the pose after the wheels have travelled.
pub fn arc([x, y, theta]: [f64; 3], left_m: f64, right_m: f64, track_m: f64) -> [f64; 3] {
    let turn = (right_m - left_m) / track_m;
    let distance = 0.5 * (left_m + right_m);
    if turn.abs() < 1e-9 {
        return [x + distance * theta.cos(), y + distance * theta.sin(), theta];
    }
    let radius = distance / turn;
    [x + radius * ((theta + turn).sin() - theta.sin()), y - radius * ((theta + turn).cos() - theta.cos()), theta + turn]
}

/// Central difference of `f` by entry `i` of a vector of any length.
pub fn slope(f: impl Fn(&[f64]) -> f64, at: &[f64], i: usize) -> f64 {
    let step = 1e-6;
    let mut moved = at.to_vec();
    moved[i] = at[i] + step;
    let above = f(&moved);
    moved[i] = at[i] - step;
    (above - f(&moved)) / (2.0 * step)
}
