//! The text of a file.

use crate::describe::diagnostics::{FileError, Source};
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// Largest file that is read, bytes: a hundred times the largest robot file known.
const LARGEST: u64 = 4 << 20;

pub(crate) fn read_text(path: &Path) -> Result<Source, FileError> {
    if path.is_dir() {
        return Err(FileError::whole_file(path, "", "cannot be read: it is a folder", "a file that can be read"));
    }
    let mut bytes = Vec::new();
    // Never more than that: the file may grow, or have no end.
    let read = File::open(path).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes));
    read.map_err(|error| {
        FileError::whole_file(path, "", format!("cannot be read: {error}"), "a file that can be read")
    })?;
    if bytes.len() as u64 > LARGEST {
        let problem = format!("larger than {} MiB", LARGEST >> 20);
        return Err(FileError::whole_file(path, "", problem, format!("a file of at most {} MiB", LARGEST >> 20)));
    }
    let file = path.display().to_string();
    String::from_utf8(bytes).map(|text| Source { file, text }).map_err(|error| {
        let problem = format!("not text: byte {} is not UTF-8", error.utf8_error().valid_up_to());
        FileError::whole_file(path, "", problem, "a text file in UTF-8")
    })
}
