//! Whether a covariance is one: the whole matrix, on the scale of its correlations.

use slam_core::Slam;

/// Jitter on the diagonal of the correlation matrix with which its Cholesky factor must exist.
pub const JITTER: f64 = 1e-3;

/// What is wrong with the covariance of the whole state; none where it is one to within [`JITTER`].
pub fn flaw<const S: usize, const W: usize, const B: usize, const BLOCKS: usize>(
    slam: &Slam<S, W, B, BLOCKS>,
) -> Option<String> {
    let n = slam.state_len();
    let covariance = |i, j| f64::from(slam.state_covariance(i, j));
    for i in 0..n {
        let variance = covariance(i, i);
        if !variance.is_finite() || variance < 0.0 {
            return Some(format!("variance of state {i} of {n} is {variance:e}"));
        }
        for j in 0..i {
            // A variance under f32's smallest number is stored as zero; no larger covariance fits one of those.
            let largest = f64::from(f32::MIN_POSITIVE) * variance.max(covariance(j, j));
            let is_certain = variance * covariance(j, j) == 0.0;
            if !covariance(i, j).is_finite() || is_certain && covariance(i, j).powi(2) > largest {
                return Some(format!("covariance of states {i} and {j} is {:e}", covariance(i, j)));
            }
        }
    }
    (least_correlation_pivot(slam) <= 0.0)
        .then(|| format!("the correlation matrix of {n} states has an eigenvalue below -{JITTER}"))
}

/// Smallest pivot of the Cholesky factor of the state's correlation matrix with [`JITTER`] on the diagonal.
pub fn least_correlation_pivot<const S: usize, const W: usize, const B: usize, const BLOCKS: usize>(
    slam: &Slam<S, W, B, BLOCKS>,
) -> f64 {
    least_pivot(slam.state_len(), |i, j| correlation(slam, i, j) + if i == j { JITTER } else { 0.0 })
}

/// Whether every eigenvalue of the state's correlation matrix is above a number: the matrix without so much on its diagonal
/// has a Cholesky factor.
pub fn eigenvalues_are_above<const S: usize, const W: usize, const B: usize, const BLOCKS: usize>(
    slam: &Slam<S, W, B, BLOCKS>,
    least: f64,
) -> bool {
    least_pivot(slam.state_len(), |i, j| correlation(slam, i, j) - if i == j { least } else { 0.0 }) > 0.0
}

/// Correlation of two states; none of one that is known exactly with another.
fn correlation<const S: usize, const W: usize, const B: usize, const BLOCKS: usize>(
    slam: &Slam<S, W, B, BLOCKS>,
    i: usize,
    j: usize,
) -> f64 {
    let covariance = |i, j| f64::from(slam.state_covariance(i, j));
    match covariance(i, i) * covariance(j, j) {
        _ if i == j => 1.0,
        product if product > 0.0 => covariance(i, j) / product.sqrt(),
        _ => 0.0,
    }
}

/// Smallest pivot of the Cholesky factorisation of a symmetric matrix; the first that is not positive ends it.
pub fn least_pivot(n: usize, entry: impl Fn(usize, usize) -> f64) -> f64 {
    let mut factor = vec![0.0; n * n];
    let mut least = f64::INFINITY;
    for j in 0..n {
        for i in j..n {
            let sum: f64 = (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum();
            let rest = entry(i, j) - sum;
            if i == j {
                least = least.min(rest);
                if rest.is_nan() || rest <= 0.0 {
                    return rest.min(0.0);
                }
                factor[j * n + j] = rest.sqrt();
            } else {
                factor[i * n + j] = rest / factor[j * n + j];
            }
        }
    }
    least
}
