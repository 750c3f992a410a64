//! The text of a file.

use crate::describe::diagnostics::{FileError, Source};
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// Largest file that is read, bytes: a hundred times the largest known robot file.
const LARGEST: u64 = 4 << 20;

pub(crate) fn read_text(path: &Path) -> Result<Source, FileError> {
    if path.is_dir() {
        return Err(FileError::whole_file(path, "", "cannot be read: it is a folder", "a file that can be read"));
    }
    let mut bytes = Vec::new();
    // Reads at most this many bytes: the file may grow, or be endless.
    let read = File::open(path).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes));
    read.map_err(|error| {
        FileError::whole_file(path, "", format!("cannot be read: {error}"), "a file that can be read")
    })?;
    if bytes.len() as u64 > LARGEST {
        let problem = format!("larger than {} MiB", LARGEST >> 20);
        return Err(FileError::whole_file(path, "", problem, format!("a file of at most {} MiB", LARGEST >> 20)));
    }
    let file = path.display().to_string();
    let text = decoded(bytes).map_err(|(problem, expected)| FileError::whole_file(path, "", problem, expected))?;
    match recognised(&text) {
        Some((problem, expected)) => Err(FileError::whole_file(path, "", problem, expected)),
        None => Ok(Source { file, text }),
    }
}

/// The characters of a file: UTF-8, UTF-16 with or without a byte order mark, and for an XML file also Latin-1, in which only names and
/// comments need it.
fn decoded(bytes: Vec<u8>) -> Result<String, (String, &'static str)> {
    const EXPECTED: &str = "a text file in UTF-8";
    let units = |bytes: &[u8], of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes
            .chunks(2)
            .map(|pair| of([pair.first().copied().unwrap_or(0), pair.get(1).copied().unwrap_or(0)]))
            .collect();
        String::from_utf16(&units).map_err(|_| ("not text: UTF-16 with a broken character".to_owned(), EXPECTED))
    };
    match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => return units(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return units(rest, u16::from_be_bytes),
        [first, 0, ..] if *first != 0 => return units(&bytes, u16::from_le_bytes),
        [0, second, ..] if *second != 0 => return units(&bytes, u16::from_be_bytes),
        [b'P', b'K', 3, 4, ..] => {
            return Err(("a ZIP archive".to_owned(), "the file inside it: unpack the archive first"));
        }
        [0x1f, 0x8b, ..] => return Err(("a gzip archive".to_owned(), "the file inside it: unpack it first")),
        _ => {}
    }
    String::from_utf8(bytes).or_else(|error| {
        let at = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        let is_xml = bytes.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'<');
        let printable = bytes.iter().all(|byte| *byte >= 0x20 || byte.is_ascii_whitespace());
        match (is_xml && printable, printable) {
            (true, _) => Ok(bytes.into_iter().map(char::from).collect()),
            (false, true) => {
                Err((format!("byte {at} is not UTF-8: saved as Latin-1 or in a code page of Windows?"), EXPECTED))
            }
            (false, false) => Err((format!("not text: byte {at} is not UTF-8"), EXPECTED)),
        }
    })
}

/// Kind of a text that none of our readers can use, and advice.
fn recognised(text: &str) -> Option<(&'static str, &'static str)> {
    let start: String =
        text.trim_start_matches('\u{feff}').trim_start().chars().take(200).collect::<String>().to_lowercase();
    if start.starts_with("version https://git-lfs.github.com/spec") {
        let expected = "the file that it points to: run `git lfs pull` in its repository";
        return Some(("a Git LFS pointer, which holds the file's address and not the file", expected));
    }
    if start.starts_with("<!doctype html") || start.starts_with("<html") {
        let expected = "the file itself: download it with the page's \"raw\" link";
        return Some(("an HTML page, as a browser saves it in place of a file", expected));
    }
    if start.starts_with("404: not found") {
        return Some((
            "the answer \"404: Not Found\" of a web server",
            "the file itself: check the address and download it again",
        ));
    }
    None
}
