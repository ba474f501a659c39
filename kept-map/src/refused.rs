//! Why bytes are refused.

use core::fmt;

use crate::VERSION;
use crate::record::WITHOUT_AREAS as OLDEST;

/// Why bytes are not a record that this robot can use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// They do not begin as a record does.
    Foreign,
    /// Its format has another version, this one.
    Version(u32),
    /// It ends early, or its CRC is not that of its content.
    Corrupt,
    /// A robot with another rig made it.
    OtherRig,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign => write!(f, "is no kept map; a run or replay writes one as map.bin"),
            Self::Version(version) => {
                write!(f, "is a kept map of version {version}; this program reads versions {OLDEST} to {VERSION}")
            }
            Self::Corrupt => {
                write!(f, "is a damaged kept map: it is cut short, or its check sum is not that of its content")
            }
            Self::OtherRig => {
                write!(f, "is the map of a robot with another rig; it must be one that was made with the same rig file")
            }
        }
    }
}
