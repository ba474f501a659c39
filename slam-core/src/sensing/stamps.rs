//! Stamps: how far the moment of one row's readings is from that of its motion.
//!
//! A robot's odometry and its range sensors run by clocks of their own, and a log's row takes the latest of each. Where the
//! odometry is latched up to a tenth of a second from the readings, one row's motion is too short by what was driven in that
//! time and the next too long by as much. That is no noise of the motion, since it does not add up, and no noise of single
//! readings, since all of a row share it: it is a time, one for each row, and a state for as long as the row is read. How
//! large these times are is learned by what each row tells of its own (expectation maximisation, step by step).

use crate::filter::ekf::{EkfView, Jacobian};

/// 1-sigma before any row tells, seconds: rows of logs come ten times a second, and half of that is as far as the latest of
/// anything can be off.
const SIGMA_S: f32 = 0.05;

/// Rows that the prior is worth: what it says is a guess, and ten rows that tell outweigh it.
const PRIOR_ROWS: f32 = 10.0;

/// Rows that are remembered; a robot's stamps do not change.
const MOST_ROWS: f32 = 200.0;

/// Least variance, s^2: of a millisecond, in which nothing in a home moves by as much. And most: of a fifth of a second, since
/// what differs by more is another row's.
const LEAST_S2: f32 = 1e-6;
const MOST_S2: f32 = 0.04;

/// The offset of the present row, and how large offsets are.
#[derive(Clone, Copy, Debug)]
pub struct Stamps {
    /// Index of the state that is the present row's offset, seconds; none where it is not estimated.
    pub state: Option<u16>,
    /// Variance of the offsets, s^2.
    variance_s2: f32,
    /// Rows that told of their offset, each counted by how much of its variance was then known.
    rows: f32,
}

impl Stamps {
    /// Exact.
    pub const EXACT: Self = Self { state: None, variance_s2: 0.0, rows: 0.0 };

    /// Of a rig before its first row; `allot` adds the state, if it is wanted, with its mean and 1-sigma.
    pub fn new(is_wanted: bool, allot: impl FnOnce(bool, f32, f32) -> Option<usize>) -> Self {
        Self { state: allot(is_wanted, 0.0, SIGMA_S).map(|i| i as u16), variance_s2: SIGMA_S * SIGMA_S, rows: 0.0 }
    }

    /// The offset of this row as it is known so far, seconds.
    pub fn offset_s(&self, ekf: &EkfView) -> f32 {
        self.state.map_or(0.0, |state| ekf.mean(state.into()))
    }

    /// 1-sigma of the offsets, seconds; none where they are not estimated.
    pub fn sigma_s(&self) -> Option<f32> {
        self.state.map(|_| float::sqrtf(self.variance_s2))
    }

    /// A new row, of whose offset nothing is known.
    pub fn begin_row(&self, ekf: &mut EkfView) {
        if let Some(state) = self.state.map(usize::from) {
            ekf.initialise(state, 0.0, &Jacobian::new(), self.variance_s2);
        }
    }

    /// All readings of the row were taken in: the mean square of its offset is that of the mean and the variance that is left.
    pub fn end_row(&mut self, ekf: &EkfView) {
        let Some(state) = self.state.map(usize::from) else { return };
        let (offset_s, left_s2) = (ekf.mean(state), ekf.covariance(state, state));
        self.rows = (self.rows + (1.0 - left_s2 / self.variance_s2).clamp(0.0, 1.0)).min(MOST_ROWS);
        let change_s2 = (offset_s * offset_s + left_s2 - self.variance_s2) / (PRIOR_ROWS + self.rows);
        let variance_s2 = self.variance_s2 + change_s2;
        if variance_s2.is_finite() {
            self.variance_s2 = variance_s2.clamp(LEAST_S2, MOST_S2);
        }
    }
}
