//! The folder of a study or of one of its shards: `runs.csv`, `manifest.json`, and copies of the study's files.
//!
//! Rows are appended in the order of their index, in blocks. After each block the manifest is replaced atomically. It records how many rows and bytes
//! are safely written, and their hash. After a kill, the next process truncates the table to that length and continues.

mod folder;
mod manifest;
mod merge;
mod shard;

pub use folder::{Done, Progress, write};
pub use manifest::Manifest;
pub(super) use merge::below;
pub use merge::{merge, shards};
pub use shard::Shard;

/// Table of runs.
pub const RUNS: &str = "runs.csv";
/// State of the table after the last whole block.
pub const MANIFEST: &str = "manifest.json";
/// Copy of the study file.
pub const STUDY: &str = "study.toml";
