//! The normal equations of one Gauss-Newton step, of which only the border is ever held as a whole.
//!
//! The unknowns are ordered: the poses along the path, then the border, which is the odometry's calibration, the direction of
//! the grid, the last pose and the walls. A pose is tied to the next one and to the border only. So the poses are eliminated
//! one after the other; what each leaves behind is added to the border's matrix and to the coupling of the next one with it
//! (the Schur complement). The border's solution found, the poses follow from the same chain once more, now with three
//! numbers to a pose. This is the exact step, in memory that does not grow with the square of the path.

use crate::packed::Packed;
use crate::rows::{LAST_POSE, Row, WALLS};

/// Unknowns of the border for so many walls.
pub const fn border_len(walls: usize) -> usize {
    WALLS + 2 * walls
}

/// Least coupling of a pose with an entry of the border, in the inverse of the entry's unit. Its square is the information that eliminating
/// the pose takes off that entry: 1e-18 per square metre or radian is below the rounding of whatever is known of one.
const FAINT: f32 = 1e-9;

/// A 3 x 3 matrix.
type Matrix3 = [[f32; 3]; 3];

/// The equations of one pose and of the next.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Of the pose with itself.
    own: Matrix3,
    right: [f32; 3],
    /// Of the pose with the next.
    cross: Matrix3,
    next: Matrix3,
    next_right: [f32; 3],
}

impl Pair {
    const ZERO: Self =
        Self { own: [[0.0; 3]; 3], right: [0.0; 3], cross: [[0.0; 3]; 3], next: [[0.0; 3]; 3], next_right: [0.0; 3] };

    fn add(&mut self, row: &Row, residual: f32) {
        for i in 0..3 {
            let (here, next) = (row.weight * row.here[i], row.weight * row.next[i]);
            for j in 0..3 {
                self.own[i][j] += here * row.here[j];
                self.cross[i][j] += here * row.next[j];
                self.next[i][j] += next * row.next[j];
            }
            self.right[i] -= here * residual;
            self.next_right[i] -= next * residual;
        }
    }

    /// The equations of the next pose, once `left` is taken off them.
    fn move_on(&mut self, left: &Matrix3, right: [f32; 3]) {
        let own = [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.next[i][j] - left[i][j]));
        *self = Self { own, right: [0, 1, 2].map(|i| self.next_right[i] - right[i]), ..Self::ZERO };
    }
}

/// Lower Cholesky factor of a 3 x 3 matrix, with the inverse pivots on the diagonal. What is not told from zero is held.
fn factor(matrix: &Matrix3) -> Matrix3 {
    let mut factor = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let known: f32 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let left = matrix[i][j] - known;
            factor[i][j] = if i != j {
                left * factor[j][j]
            } else {
                let least = 1e-6 * matrix[i][i];
                1.0 / float::sqrtf(if left > least { left } else { matrix[i][i].max(1.0) })
            };
        }
    }
    factor
}

/// L^-1 x.
fn forward(factor: &Matrix3, x: [f32; 3]) -> [f32; 3] {
    let a = x[0] * factor[0][0];
    let b = (x[1] - factor[1][0] * a) * factor[1][1];
    [a, b, (x[2] - factor[2][0] * a - factor[2][1] * b) * factor[2][2]]
}

/// L^-T y.
fn backward(factor: &Matrix3, y: [f32; 3]) -> [f32; 3] {
    let c = y[2] * factor[2][2];
    let b = (y[1] - factor[2][1] * c) * factor[1][1];
    [(y[0] - factor[1][0] * b - factor[2][0] * c) * factor[0][0], b, c]
}

/// L^-1 M, column by column: entry `[j]` is what column j became.
fn columns(factor: &Matrix3, matrix: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|j| forward(factor, [matrix[0][j], matrix[1][j], matrix[2][j]]))
}

/// The coupling, or zero where it has faded below what a sum in single precision can hold. Couplings fade by a factor from pose to pose. Left
/// alone they become subnormal numbers, over which host processors take far longer, and a wall costs as much at a pose that has long had
/// nothing to do with it as at one that sees it.
fn unless_faint(coupling: f32) -> f32 {
    if coupling.abs() < FAINT { 0.0 } else { coupling }
}

fn dot3(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// What is left of a pose once it is eliminated: its increment is `own` less `by_next` times the next one's.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    by_next: Matrix3,
    /// With nothing known of the next; the increment itself once that is.
    pub own: [f32; 3],
}

impl Link {
    /// Of no pose.
    pub const ZERO: Self = Self { by_next: [[0.0; 3]; 3], own: [0.0; 3] };

    /// Puts the next pose's increment in.
    pub fn resolve(&mut self, next: [f32; 3]) {
        for (own, by_next) in self.own.iter_mut().zip(self.by_next) {
            *own -= dot3(by_next, next);
        }
    }
}

/// The equations.
#[derive(Clone, Debug)]
pub struct System<const B: usize, const P: usize> {
    /// The border's matrix, then its factor.
    pub(crate) matrix: Packed<P>,
    /// The border's right-hand side, then its increment.
    pub(crate) right: [f32; B],
    /// The present pose's coupling with each entry of the border.
    coupling: [[f32; 3]; B],
    pair: Pair,
    /// Unknowns of the border in use.
    len: usize,
    /// Those that anything was added to.
    active: usize,
    /// Unknowns that nothing tells.
    pub held: usize,
}

impl<const B: usize, const P: usize> System<B, P> {
    /// Without equations.
    pub const NEW: Self = Self {
        matrix: Packed::ZERO,
        right: [0.0; B],
        coupling: [[0.0; 3]; B],
        pair: Pair::ZERO,
        len: 0,
        active: 0,
        held: 0,
    };

    /// Unknowns of the border.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Unknowns of the border that the path so far has to do with.
    pub fn active(&self) -> usize {
        self.active
    }

    /// What was added until now has to do with no pose.
    pub fn reset_active(&mut self) {
        self.active = WALLS;
    }

    /// Begins a step with so many walls.
    pub fn begin(&mut self, walls: usize) {
        self.len = border_len(walls).min(B);
        self.active = WALLS;
        self.held = 0;
        self.matrix.clear(self.len);
        self.right = [0.0; B];
        self.coupling = [[0.0; 3]; B];
        self.pair = Pair::ZERO;
    }

    /// Adds to one diagonal entry of the border.
    pub fn damp(&mut self, place: usize, weight: f32) {
        self.matrix.add(place, place, weight);
    }

    /// Adds a residual to the border and to the present pose and the next.
    pub fn add(&mut self, row: &Row) {
        self.pair.add(row, row.residual);
        for (n, &(place, value)) in row.border.iter().enumerate() {
            let weighted = row.weight * value;
            if value == 0.0 || place >= self.len {
                continue;
            }
            self.active = self.active.max(place + 1);
            if let Some(right) = self.right.get_mut(place) {
                *right -= weighted * row.residual;
            }
            self.matrix.add(place, place, weighted * value);
            if let Some(coupling) = self.coupling.get_mut(place) {
                coupling.iter_mut().zip(row.here).for_each(|(entry, here)| *entry += weighted * here);
            }
            for &(other, by_other) in row.border.iter().take(n).filter(|(_, by_other)| *by_other != 0.0) {
                self.matrix.add(place, other, weighted * by_other);
            }
        }
    }

    /// Adds to one entry of the border's matrix.
    #[cfg(test)]
    pub fn add_entry(&mut self, i: usize, j: usize, value: f32) {
        self.matrix.add(i, j, value);
    }

    /// Adds what is known of one unknown of the border.
    pub fn add_prior(&mut self, place: usize, weight: f32, residual: f32) {
        self.matrix.add(place, place, weight);
        if let Some(right) = self.right.get_mut(place) {
            *right -= weight * residual;
        }
    }

    /// Eliminates the present pose; the next one is the present one from then on. `rows` are those that tie the two, of which
    /// [`Self::add`] had everything already.
    pub fn eliminate(&mut self, rows: &[Row]) {
        let factor = factor(&self.pair.own);
        let cross = columns(&factor, &self.pair.cross);
        let right = forward(&factor, self.pair.right);
        for (column, own) in self.coupling.iter_mut().zip(&mut self.right).take(self.active) {
            *column = forward(&factor, *column);
            *own -= dot3(*column, right);
        }
        self.matrix.subtract_square(&self.coupling, self.active);
        let left = [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot3(cross[i], cross[j])));
        self.pair.move_on(&left, [0, 1, 2].map(|i| dot3(cross[i], right)));
        for column in self.coupling.iter_mut().take(self.active) {
            *column = cross.map(|cross| unless_faint(-dot3(cross, *column)));
        }
        self.couple(rows);
    }

    /// Goes on to the next pose without eliminating the present one, which is where it is.
    pub fn pass(&mut self, rows: &[Row]) {
        self.pair.move_on(&[[0.0; 3]; 3], [0.0; 3]);
        self.coupling = [[0.0; 3]; B];
        self.couple(rows);
    }

    /// Ties the pose that is present now to the border by the rows that tied it to the one before.
    fn couple(&mut self, rows: &[Row]) {
        for row in rows {
            for (place, value) in row.border {
                if let Some(coupling) = self.coupling.get_mut(place) {
                    coupling.iter_mut().zip(row.next).for_each(|(entry, next)| *entry += row.weight * value * next);
                }
            }
        }
    }

    /// The present pose is the last one: it is part of the border.
    pub fn keep_last(&mut self) {
        for i in 0..3 {
            for j in 0..=i {
                self.matrix.add(LAST_POSE + i, LAST_POSE + j, self.pair.own[i][j]);
            }
            if let Some(entry) = self.right.get_mut(LAST_POSE + i) {
                *entry += self.pair.right[i];
            }
        }
        for (place, column) in self.coupling.iter().enumerate().take(self.active) {
            for (i, value) in column.iter().enumerate() {
                self.matrix.add(LAST_POSE + i, place, *value);
            }
        }
    }

    /// Factors one row of the border's matrix; false past the last.
    pub fn factor_row(&mut self, row: usize) -> bool {
        if row >= self.len {
            return false;
        }
        self.held += usize::from(!self.matrix.factor_row(row));
        true
    }

    /// Solves the border.
    pub fn solve(&mut self) {
        self.matrix.forward(&mut self.right, self.len);
        self.matrix.backward(&mut self.right, self.len);
        self.pair = Pair::ZERO;
    }

    /// The border's increment at a place.
    pub fn increment(&self, place: usize) -> f32 {
        self.right.get(place).copied().unwrap_or(0.0)
    }

    /// Adds a residual to the present pose and the next, the border's increment being known.
    pub fn add_known(&mut self, row: &Row) {
        let known: f32 = row.border.iter().map(|(place, value)| value * self.increment(*place)).sum();
        self.pair.add(row, row.residual + known);
    }

    /// Eliminates the present pose of a chain whose border is known.
    pub fn link(&mut self) -> Link {
        let factor = factor(&self.pair.own);
        let cross = columns(&factor, &self.pair.cross);
        let right = forward(&factor, self.pair.right);
        let columns = cross.map(|column| backward(&factor, column));
        let by_next = [0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i]));
        let left = [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot3(cross[i], cross[j])));
        self.pair.move_on(&left, [0, 1, 2].map(|i| dot3(cross[i], right)));
        Link { by_next, own: backward(&factor, right) }
    }

    /// Goes on from a pose that is where it is.
    pub fn pass_known(&mut self) {
        self.pair.move_on(&[[0.0; 3]; 3], [0.0; 3]);
    }

    /// Variance of a sum of border unknowns, by the factor.
    pub fn variance(&self, terms: &[(usize, f32)]) -> f32 {
        let mut x = [0.0; B];
        for (place, value) in terms {
            if let Some(entry) = x.get_mut(*place) {
                *entry += value;
            }
        }
        self.matrix.forward(&mut x, self.len);
        x.iter().take(self.len).map(|value| value * value).sum()
    }
}
