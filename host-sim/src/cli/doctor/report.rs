//! All checks.

use board::session::doctor::{Check, Use};
use serde::Serialize;

/// All checks and their count.
#[derive(Debug, Serialize)]
pub(super) struct Report<'a> {
    #[serde(rename = "for")]
    pub(super) uses: &'a [Use],
    pub(super) problems: usize,
    pub(super) warnings: usize,
    pub(super) checks: Vec<Check>,
}
