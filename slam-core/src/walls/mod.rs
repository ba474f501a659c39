//! The walls of the map, the grid that they stand on and the frame that they hold (report 3.2).

pub mod decision;
pub mod founding;
pub mod manhattan;
pub mod map;
pub mod map_frame;
pub mod merge;
pub mod upkeep;
pub mod wall;
