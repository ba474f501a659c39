//! A sparse row of a Jacobian.

use crate::filter::covariance::{HEAD, MAX_OTHERS};
use heapless::Vec;

/// A row that is zero but for a few entries. Those of the first [`HEAD`] states, which every reading depends on, have
/// places of their own.
#[derive(Clone, Debug, Default)]
pub struct Jacobian {
    head: [f32; HEAD],
    others: Vec<(usize, f32), MAX_OTHERS>,
}

impl Jacobian {
    /// All zero.
    pub const fn new() -> Self {
        Self { head: [0.0; HEAD], others: Vec::new() }
    }

    /// Adds a derivative by the state with this index.
    ///
    /// # Errors
    /// The entry, where there is no room.
    pub fn push(&mut self, (i, derivative): (usize, f32)) -> Result<(), (usize, f32)> {
        match self.head.get_mut(i) {
            Some(sum) => *sum += derivative,
            None => self.others.push((i, derivative))?,
        }
        Ok(())
    }

    /// The derivatives by the first states.
    pub fn head(&self) -> &[f32; HEAD] {
        &self.head
    }

    /// (State index, derivative) for the others that are not zero.
    pub fn others(&self) -> &[(usize, f32)] {
        &self.others
    }
}

impl FromIterator<(usize, f32)> for Jacobian {
    /// Entries that there is no room for are left out.
    fn from_iter<I: IntoIterator<Item = (usize, f32)>>(entries: I) -> Self {
        let mut row = Self::new();
        for entry in entries {
            let _ = row.push(entry);
        }
        row
    }
}
