//! Studies: very many runs whose keys vary, each a function of the study and its index alone.
//!
//! ```text
//! study.toml --Prepared--> outcomes(indices) --store--> runs.csv, manifest.json --merge--> the same of all shards
//!                                                            '--results--> results.json, results.md
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`prepared`] | a study that is ready to run; `outcomes`, the one place where runs are made |
//! | `draw`, `sobol`, `normal` | the values of a run: random, from a Sobol sequence, from a grid |
//! | `experiment` | runs of a scene, and their figures |
//! | [`store`] | blocks of rows in a folder: continued after a kill, merged from shards |
//! | [`results`] | what came of all runs: distributions, sensitivities, failures, the worst runs |
//! | [`replay`] | one run in full, as files that `newtau run` takes too |
//! | [`repeat`] | the command that repeats a run |
//! | [`submit`] | scripts for HyperQueue and Slurm |
//!
//! Nothing here depends on the number of threads, on the order of the work or on the platform's mathematics, so that every machine
//! and every division into shards writes the same bytes.

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
