//! The text of a file.

use crate::describe::diagnostics::{FileError, Source};
use std::path::Path;

pub(crate) fn read_text(path: &Path) -> Result<Source, FileError> {
    let bytes = std::fs::read(path).map_err(|error| {
        FileError::whole_file(path, "", format!("cannot be read: {error}"), "a file that can be read")
    })?;
    let file = path.display().to_string();
    String::from_utf8(bytes).map(|text| Source { file, text }).map_err(|error| {
        let problem = format!("not text: byte {} is not UTF-8", error.utf8_error().valid_up_to());
        FileError::whole_file(path, "", problem, "a text file in UTF-8")
    })
}
