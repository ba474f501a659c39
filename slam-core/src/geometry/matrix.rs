//! Matrices of three rows: covariances of a pose, and what turns them.

use core::array;

use crate::geometry::angle::normal;

/// Three rows.
pub type Matrix = [[f32; 3]; 3];

/// The lower triangle of a symmetric matrix, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Triangle([f32; 6]);

impl Triangle {
    /// Of this one.
    #[inline(never)]
    pub const fn of(m: &Matrix) -> Self {
        Self([m[0][0], m[1][0], m[1][1], m[2][0], m[2][1], m[2][2]])
    }

    /// The whole.
    #[inline(never)]
    pub fn matrix(&self) -> Matrix {
        let [xx, yx, yy, tx, ty, tt] = self.0;
        [[xx, yx, tx], [yx, yy, ty], [tx, ty, tt]]
    }
}

/// Variances without covariances.
pub fn diagonal([a, b, c]: [f32; 3]) -> Matrix {
    [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]]
}

/// The determinant.
pub fn determinant(m: &Matrix) -> f32 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

/// Inverse of a symmetric positive definite matrix.
#[inline(never)]
pub fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |i: usize, j: usize| {
        let [r0, r1] = [(i + 1) % 3, (i + 2) % 3];
        let [c0, c1] = [(j + 1) % 3, (j + 2) % 3];
        m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0]
    };
    let inverse = 1.0 / determinant(m);
    array::from_fn(|i| array::from_fn(|j| inverse * cofactor(j, i)))
}

/// The sum of one and so many times another.
#[inline(never)]
pub fn sum(a: &Matrix, b: &Matrix, times: f32) -> Matrix {
    array::from_fn(|i| array::from_fn(|j| a[i][j] + times * b[i][j]))
}

/// The product of one and another's transpose.
#[inline(never)]
pub fn times_transposed(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| b.map(|other| row[0] * other[0] + row[1] * other[1] + row[2] * other[2]))
}

/// A B A^T: the covariance of what is A times something of covariance B.
#[inline(never)]
pub fn propagated(a: &Matrix, b: &Matrix) -> Matrix {
    // B is its own transpose.
    Triangle::of(&times_transposed(&times_transposed(a, b), a)).matrix()
}

/// What turns (x, y, theta) of a frame that is turned by so much, radians, into the outer frame's.
#[inline(never)]
pub fn rotation(turn_rad: f32) -> Matrix {
    let [c, s] = normal(turn_rad);
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}
