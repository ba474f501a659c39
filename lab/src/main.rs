//! The workbench's command line.

fn main() {}
