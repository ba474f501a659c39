//! How far paths are apart, and how that compares with what is said of it.

use lab::recording::{Pose2, Recording};

/// RMS distance of two paths after the best rigid motion (Horn 1987, in the plane), metres.
pub fn aligned_m(a: &[Pose2], b: &[Pose2]) -> f64 {
    let places = |path: &[Pose2]| -> Vec<[f64; 2]> {
        let mean = [0, 1].map(|i| path.iter().map(|pose| [pose.x_m, pose.y_m][i]).sum::<f64>() / path.len() as f64);
        path.iter().map(|pose| [pose.x_m - mean[0], pose.y_m - mean[1]]).collect()
    };
    let (a, b) = (places(a), places(b));
    let pairs = || a.iter().zip(&b);
    let along: f64 = pairs().map(|(p, q)| p[0] * q[0] + p[1] * q[1]).sum();
    let across: f64 = pairs().map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum();
    let (s, c) = across.atan2(along).sin_cos();
    let off = |p: &[f64; 2], q: &[f64; 2]| (c * p[0] - s * p[1] - q[0]).powi(2) + (s * p[0] + c * p[1] - q[1]).powi(2);
    (pairs().map(|(p, q)| off(p, q)).sum::<f64>() / a.len() as f64).sqrt()
}

/// Mean normalised error squared of the poses at the times that are wanted (3 is ideal); not a number where there are none.
pub fn mean_nees(recording: &Recording, is_wanted: impl Fn(f64) -> bool) -> f64 {
    let wanted = recording.steps.iter().filter(|step| is_wanted(step.t_s));
    let all: Vec<f64> = wanted
        .filter_map(|step| {
            let error = step.error()?;
            let inverse = inverse(step.covariance.map(|row| row.map(f64::from)))?;
            let off = [error.x_m, error.y_m, error.theta_rad];
            Some((0..3).map(|i| (0..3).map(|j| off[i] * inverse[i][j] * off[j]).sum::<f64>()).sum())
        })
        .collect();
    all.iter().sum::<f64>() / all.len() as f64
}

fn inverse(m: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cofactor = |a: usize, b: usize| {
        let (i, j, k, l) = ((a + 1) % 3, (a + 2) % 3, (b + 1) % 3, (b + 2) % 3);
        m[i][k] * m[j][l] - m[i][l] * m[j][k]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    (determinant != 0.0).then(|| [0, 1, 2].map(|i| [0, 1, 2].map(|j| cofactor(j, i) / determinant)))
}
