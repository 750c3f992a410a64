//! The simulated arm with its drives and sensors, the closed loop around it, and the record of a run.
//!
//! | module | holds |
//! |---|---|
//! | [`plant`] | the simulated arm, its actuators and sensors: f64, with its own algorithm |
//! | [`run`] | the loop once per control period, from a scene to a record, a summary and a report |
//! | [`output`] | files that commands write: nothing is overwritten that this program did not write |
//! | [`failure`] | reasons why a command fails, and exit codes |
//! | [`pages`] | pages that commands write: reports, and tables of the documentation |
//! | [`parallel`] | work on all cores |
//! | [`table`] | tables in the terminal |
//! | [`terminal`] | the program at a terminal: results, progress bar, messages, Ctrl-C, exit code |
#![forbid(unsafe_code)]

mod drive_type;
pub mod failure;
mod marker;
pub mod output;
pub mod pages;
pub mod parallel;
pub mod plant;
pub mod run;
pub mod table;
pub mod terminal;
