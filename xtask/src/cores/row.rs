//! Rows that the program prints.

use anyhow::{Result, bail};
use serde::Serialize;

/// One computation on one core.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) core: &'static str,
    pub(super) scalar: String,
    pub(super) what: String,
    pub(super) equal: bool,
    /// Instructions of one evaluation; absent for WebAssembly, which has none.
    pub(super) instructions: Option<u64>,
    #[serde(skip)]
    pub(super) hash: String,
}

impl Row {
    /// Scalar and computation; that in C is the same as that in Rust.
    pub(super) fn key(&self) -> (String, String) {
        (self.scalar.clone(), self.what.trim_end_matches(IN_C).to_owned())
    }
}

/// The end of the name of a computation in C.
pub(super) const IN_C: &str = ", in C";

/// The lines `row|SCALAR|WHAT|HASH|INSTRUCTIONS` of a program's output.
pub(super) fn rows(core: &'static str, said: &str) -> Result<Vec<Row>> {
    let rows = said.lines().filter_map(|line| line.trim().strip_prefix("row|"));
    rows.map(|line| {
        let [scalar, what, hash, count] = line.split('|').collect::<Vec<_>>()[..] else { bail!("{core}: row {line}") };
        let instructions = Some(count.parse::<u64>()?).filter(|count| *count > 0);
        Ok(Row {
            core,
            scalar: scalar.to_owned(),
            what: what.to_owned(),
            equal: true,
            instructions,
            hash: hash.to_owned(),
        })
    })
    .collect()
}
