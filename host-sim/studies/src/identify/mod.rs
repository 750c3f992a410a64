//! The model of an arm from logs: what the package `identification` needs of a robot file, and what becomes of its answer.

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
