//! JSON results of other programs.

use anyhow::{Context as _, Result};
use std::path::Path;

pub(super) fn from_json(path: &Path) -> Result<serde_json::Value> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}
