//! Files that cargo builds from.

use crate::describe::diagnostics::Message;
use std::path::Path;

/// Writes a file unless it already holds this text: an untouched file triggers no rebuild.
pub(super) fn write_changed(path: &Path, text: &str) -> Result<(), Message> {
    if std::fs::read(path).is_ok_and(|held| held == text.as_bytes()) {
        return Ok(());
    }
    std::fs::write(path, text).map_err(|error| Message(format!("{}: cannot be written: {error}", path.display())))
}
