//! The model of an arm from logs: what the package `identification` needs of a robot file, and what becomes of its answer.
//!
//! | module | holds |
//! |---|---|
//! | [`subject`] | the arm and its maker's numbers |
//! | [`outcome`] | errors of torque on logs, before and after; JSON and text |
//! | [`verdict`] | the verdict in words |
//! | [`held`] | what the arm holds |
//! | `friction` | friction as a robot file holds it |
//! | [`robot_file`] | the robot file with the identified numbers |
//! | [`report`] | the page that a person reads |
//! | [`record`] | a record of `connect` as a log |
//! | [`prediction`] | measured and predicted torque as CSV |

mod friction;
pub mod held;
pub mod outcome;
pub mod prediction;
pub mod record;
pub mod report;
pub mod robot_file;
pub mod subject;
pub mod verdict;

pub use outcome::Outcome;
pub use subject::{LogOptions, Subject};
