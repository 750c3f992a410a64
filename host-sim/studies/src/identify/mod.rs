//! Identification of an arm from logs: connects the package `identification` with robot files, and reports its results.

mod friction;
pub mod held;
pub mod outcome;
pub mod prediction;
pub mod record;
pub mod report;
pub mod robot_file;
pub mod subject;
mod text;
pub mod verdict;

pub use outcome::Outcome;
pub use subject::{LogOptions, Subject};
