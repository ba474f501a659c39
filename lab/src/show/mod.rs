//! What a user sees: the output folder, the report page, tables and charts.

pub mod chart;
pub mod closing;
pub mod output;
pub mod report;
pub mod svg;
