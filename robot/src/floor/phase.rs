//! What the floor job is at, with what it has to know for that.

use super::dock::Stage;
use super::lanes::Lane;
use super::wave::{Aim, Target};
use crate::contact::Contacts;

/// What the job is at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// Straight on, or to a point (metres), until something is near.
    Seek { to_m: Option<[f32; 2]> },
    /// Along it, on the right (1) or on the left (-1).
    Edge { side: f32 },
    /// Looking for somewhere to go.
    Plan { aim: Aim, escape: i16, begun: bool },
    /// Taking the way there from the search.
    Trace { target: Target, aim: Aim },
    /// On the way to a target.
    Transit { target: Target, aim: Aim },
    /// Straight to where a lane begins.
    Enter { lane: Lane, at_m: [f32; 2] },
    /// Along a lane.
    Lane(Lane),
    /// Backing off.
    Back,
    /// Backwards along the way that it came, so far yet (metres).
    Retreat { left_m: f32 },
    /// Turning away (1: counter-clockwise) from what was touched again and again.
    Turn { sign: f32 },
    /// The last metre home.
    Home,
    /// Into the dock, for the second or third time after so many tries in vain.
    Dock { stage: Stage, tries: u8 },
    /// Out of the dock.
    Undock,
    /// In the dock.
    Charge,
    /// At home, waiting for what barred the way to be gone, or until it is told that it is.
    Wait { is_told: bool },
    /// Standing on request.
    Paused,
    /// Off the floor, or carried and not located yet.
    Lost {
        /// It stood in its dock until its battery was full.
        is_charged: bool,
    },
    /// Held: standing for a while.
    Held,
    /// This is touched wherever it goes: standing until some of it is not.
    Touched { by: Contacts },
    /// No sensor shows anything: standing until two do, or for a while.
    Blind,
    /// Over: back where it started, or not.
    Over { is_home: bool },
}

impl Phase {
    /// Whether it is about the floor, or on the way home over it, up to the dock: where contacts, stalls and waiting in vain have to be
    /// answered.
    pub(super) fn is_sweeping(&self) -> bool {
        matches!(
            self,
            Self::Seek { .. }
                | Self::Edge { .. }
                | Self::Plan { .. }
                | Self::Trace { .. }
                | Self::Transit { .. }
                | Self::Enter { .. }
                | Self::Lane(_)
                | Self::Home
                | Self::Dock { stage: Stage::Staging, .. }
        )
    }

    /// Whether it gets away from what it touches.
    pub(super) fn gets_away(&self) -> bool {
        self.is_sweeping() || matches!(self, Self::Back | Self::Turn { .. } | Self::Retreat { .. } | Self::Lost { .. })
    }
}
