//! Tests of the command line, in one program: it is linked once, and no core waits for the last test of a file.

mod carmen;
mod clean;
mod common;
mod compare;
mod damaged_files;
mod docs;
mod experiment;
mod hil;
mod kept_map;
mod log_csv;
mod monitor;
mod options;
mod rig_file;
mod robot_map;
mod run;
