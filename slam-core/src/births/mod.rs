//! New walls from the readings that fit none (Rousse & Qiu 3.3).

pub mod askew;
pub mod birth;
pub mod buffer;
pub mod candidates;
pub mod cluster;
pub mod dbscan;
pub mod extend;
pub mod line_fit;
pub mod local_line;
pub mod verdict;

use cluster::Clustering;

/// How new walls are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BirthSettings {
    /// Outlier clustering.
    pub clustering: Clustering,
}

impl BirthSettings {
    pub(crate) const IDLE: Self = Self { clustering: Clustering::BySensor };
}

impl From<Clustering> for BirthSettings {
    fn from(clustering: Clustering) -> Self {
        Self { clustering }
    }
}
