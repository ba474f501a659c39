//! The kept map on the line: fetched, stored and forgotten in pieces. The host asks, the robot answers each request once; a request
//! that is not answered can be repeated.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most bytes of a piece; every piece but the last has as many.
pub const PIECE_BYTES: usize = 96;

/// A piece of a record: whole words.
pub type Piece = Vec<u8, PIECE_BYTES>;

/// What is wanted with the robot's kept map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MapRequest {
    /// The record's bytes from this place on.
    Get {
        /// Place of the first byte that is wanted.
        offset: u32,
    },
    /// The next bytes of a record that is to be the newest one; those at place 0 begin it.
    Put {
        /// Place of the first of these bytes.
        offset: u32,
        /// The bytes.
        bytes: Piece,
    },
    /// No map is to be kept, and the robot begins afresh where it stands.
    Forget,
}

/// What the robot says to a [`MapRequest`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MapAnswer {
    /// Bytes of the record.
    Part {
        /// Place of the first of these bytes.
        offset: u32,
        /// Bytes of the whole record.
        of: u32,
        /// The bytes.
        bytes: Piece,
    },
    /// So many bytes of the record that is put are there: the next ones are awaited.
    Awaiting {
        /// Place of the byte that is awaited; 0 where none was put, or what was put is dropped.
        offset: u32,
    },
    /// The record that was put is kept, under this number of its save.
    Kept {
        /// The number of the save.
        sequence: u32,
    },
    /// There is no kept map any more.
    Forgotten,
    /// It is not done.
    Refused(MapRefusal),
}

/// Why a [`MapRequest`] is not fulfilled. What was kept is kept on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MapRefusal {
    /// There is no kept map, or none at this place.
    Nothing,
    /// The robot is told to drive, or is off the floor: it writes its flash only while it stands.
    Driving,
    /// The bytes are no record of a map.
    Foreign,
    /// They are a record of another version.
    Version,
    /// They are damaged.
    Damaged,
    /// A robot with another rig made the record.
    OtherRig,
    /// It has more walls or states than there is room for, or calibrates other things.
    Unsuitable,
    /// The flash refused.
    Flash,
}

impl MapRefusal {
    /// What it means, and what would be right.
    pub fn text(self) -> &'static str {
        match self {
            Self::Nothing => {
                "the robot keeps no map; it saves one when it has mapped a room, or was driven for three metres and stands"
            }
            Self::Driving => "the robot is driving or off the floor; it must stand on the floor: stop it first",
            Self::Foreign => "this is no kept map; it must be a map.bin of this robot, or of lab run with its rig",
            Self::Version => {
                "this kept map is of another version than the robot's firmware reads; it must be made anew"
            }
            Self::Damaged => "this kept map is damaged: it is cut short, or its check sum is not that of its content",
            Self::OtherRig => "this is the map of a robot with another rig; it must be made with this robot's rig",
            Self::Unsuitable => {
                "this map has more walls or states than the robot has room for, or was made with other settings"
            }
            Self::Flash => "the robot's flash refused; try again, and if it refuses again, it is worn out",
        }
    }
}
