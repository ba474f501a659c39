//! New walls from the readings that fit none (report 3.3).

pub mod birth;
pub mod buffer;
pub mod candidates;
pub mod cluster;
pub mod dbscan;
pub mod extend;
pub mod line_fit;
pub mod local_line;
pub mod verdict;
