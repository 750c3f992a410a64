//! The folder of a study or of one of its shards: `runs.csv`, `manifest.json`, and copies of the study's files.
//!
//! Rows are appended in the order of their index, in blocks. Behind each block the manifest is renamed into its place: it says how many
//! rows and bytes are sure, and their hash. Whoever continues after a kill cuts what is behind them.

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
/// Its state after the last whole block.
pub const MANIFEST: &str = "manifest.json";
/// The study.
pub const STUDY: &str = "study.toml";
