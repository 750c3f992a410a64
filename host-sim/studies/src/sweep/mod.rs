//! Studies of very many runs with varied keys. Each run depends only on the study and its index.
//!
//! ```text
//! study.toml --Prepared--> outcomes(indices) --store--> runs.csv, manifest.json --merge--> the same of all shards
//!                                                            '--results--> results.json, results.md
//! ```
//!
//! Nothing here depends on the number of threads, on the order of the work or on the platform's mathematics. So every machine and every division into
//! shards writes the same bytes.

mod draw;
mod experiment;
mod normal;
pub mod prepared;
pub mod repeat;
pub mod replay;
pub mod results;
mod sobol;
pub mod store;
pub mod submit;

pub use prepared::Prepared;
