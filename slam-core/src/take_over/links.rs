//! Which states of the filter are what of a hand-over's unknowns.

use crate::filter::ekf::EkfView;
use crate::hand_over::{self, HandOver, Terms};

/// Walls that a hand-over has room for.
pub(super) const MOST_WALLS: usize = 64;
/// States that depend on it: pose, grid, the drive's calibration, gains, two a wall.
pub(super) const MOST_LINKS: usize = hand_over::WALLS + 2 * MOST_WALLS;

/// A state of the filter and what it is of the hand-over's unknowns: places among them, and derivatives by them. In few bytes, for all
/// of them are on the robot's stack at once.
#[derive(Clone, Copy)]
pub(super) struct Link {
    derivatives: [f32; 2],
    state: u16,
    places: [u8; 2],
}

// Every unknown has a place.
const _: () = assert!(MOST_LINKS <= u8::MAX as usize);

impl Link {
    fn state(&self) -> usize {
        self.state.into()
    }

    fn terms(&self) -> Terms<2> {
        let ([i, j], [by_i, by_j]) = (self.places, self.derivatives);
        [(i.into(), by_i), (j.into(), by_j)]
    }
}

pub(super) const NONE: (usize, f32) = (0, 0.0);

pub(super) fn link(state: usize, [(i, by_i), (j, by_j)]: Terms<2>) -> Link {
    Link { derivatives: [by_i, by_j], state: state as u16, places: [i as u8, j as u8] }
}

impl EkfView {
    /// Gives the linked states the hand-over's covariance. The others keep theirs with one another and have none with these.
    pub(super) fn relate(&mut self, links: &[Link], found: &HandOver) {
        for other in (0..self.len()).filter(|other| links.iter().all(|link| link.state() != *other)) {
            for link in links {
                self.set_covariance(link.state(), other, 0.0);
            }
        }
        for (i, a) in links.iter().enumerate() {
            for b in links.iter().take(i + 1) {
                self.set_covariance(a.state(), b.state(), found.of_sums(&a.terms(), &b.terms()));
            }
        }
    }
}
