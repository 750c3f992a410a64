//! Link keys as files, and random numbers.
//!
//! A key file has two lines: `newtau link key 1`, and 64 hexadecimal digits. Only its owner can read it. It never replaces another file, because a
//! lost key means that the board must be provisioned again.

use link::seal::KEY_BYTES;
use link::{Key, key_page};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// First line of a key file.
const TITLE: &str = "newtau link key 1";

/// Reason why a key is not available.
#[derive(Debug, thiserror::Error)]
pub enum KeyError {
    /// The file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The file exists.
    #[error("{}: found a file, expected none: a key is never overwritten", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The file has other content. The message does not repeat it, because it may be nearly a key.
    #[error("{}:{line}: found {found}, expected {expected}; `newtau firmware key new FILE` makes a key", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// Found content.
        found: String,
        /// Expected content.
        expected: &'static str,
    },
    /// Others than the owner can read the file.
    #[error("{}: found a file that others can read (mode {mode:o}), expected one for its owner alone: `chmod 600`", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Its mode.
        mode: u32,
    },
    /// The system has no random numbers.
    #[error("the system gives no random numbers: {0}")]
    Random(getrandom::Error),
}

/// Random bytes of the operating system.
///
/// # Errors
/// [`KeyError::Random`].
pub fn random<const N: usize>() -> Result<[u8; N], KeyError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(KeyError::Random)?;
    Ok(bytes)
}

/// A new key.
///
/// # Errors
/// [`KeyError::Random`].
pub fn new() -> Result<Key, KeyError> {
    random::<KEY_BYTES>().map(Key::new)
}

/// Writes a key to a new file.
///
/// # Errors
/// The file exists or cannot be written.
pub fn save(key: &Key, path: &Path) -> Result<(), KeyError> {
    let digits: String = key.bytes().iter().map(|byte| format!("{byte:02x}")).collect();
    write_for_owner(path, format!("{TITLE}\n{digits}\n").as_bytes())
}

/// Writes a new file that only its owner can read.
///
/// # Errors
/// The file exists or cannot be written.
pub fn write_for_owner(path: &Path, bytes: &[u8]) -> Result<(), KeyError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|source| KeyError::File { path: path.to_owned(), source })?;
    }
    firmware_image::process::write_for_owner(path, bytes).map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => KeyError::Exists { path: path.to_owned() },
        _ => KeyError::File { path: path.to_owned(), source },
    })
}

/// Reads a key file.
///
/// # Errors
/// The file cannot be read, can be read by others, or is no key file.
pub fn load(path: &Path) -> Result<Key, KeyError> {
    let file = |source| KeyError::File { path: path.to_owned(), source };
    let content = |line, found: &str, expected| {
        Err(KeyError::Content { path: path.to_owned(), line, found: found.to_owned(), expected })
    };
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = fs::metadata(path).map_err(file)?.permissions().mode() & 0o777;
        if mode & 0o077 != 0 {
            return Err(KeyError::Open { path: path.to_owned(), mode });
        }
    }
    // Bytes that are not text are not a key either.
    let text = String::from_utf8_lossy(&fs::read(path).map_err(file)?).into_owned();
    let mut lines = text.lines();
    if lines.next() != Some(TITLE) {
        return content(1, "another first line", "`newtau link key 1`");
    }
    let digits = lines.next().unwrap_or_default();
    let number = |index: usize| {
        let pair = digits.get(2 * index..2 * index + 2)?;
        // `from_str_radix` accepts a sign too.
        pair.bytes().all(|digit| digit.is_ascii_hexdigit()).then(|| u8::from_str_radix(pair, 16).ok())?
    };
    let mut bytes = [0; KEY_BYTES];
    for (index, byte) in bytes.iter_mut().enumerate() {
        match number(index) {
            Some(value) => *byte = value,
            None => return content(2, &format!("{} characters", digits.chars().count()), "64 hexadecimal digits"),
        }
    }
    if digits.len() != 2 * KEY_BYTES {
        return content(2, &format!("{} characters", digits.chars().count()), "64 hexadecimal digits");
    }
    match lines.next() {
        None => Ok(Key::new(bytes)),
        Some(_) => content(3, "a third line", "the end of the file"),
    }
}

/// Returns the bytes of a board's key page: this key and a new random number.
///
/// # Errors
/// [`KeyError::Random`].
pub fn page(key: &Key) -> Result<[u8; key_page::LENGTH], KeyError> {
    Ok(key_page::write(key, &random()?))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{load, new, save};
    use std::fs;
    use std::path::PathBuf;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("newtau-key-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn a_key_comes_back_from_its_file_and_no_two_are_the_same() {
        let folder = folder("back");
        let (one, two) = (new().unwrap(), new().unwrap());
        assert_ne!(one, two);
        let path = folder.join("key");
        save(&one, &path).unwrap();
        assert_eq!(load(&path).unwrap(), one);
        let text = save(&two, &path).unwrap_err().to_string();
        assert!(text.contains("never overwritten"), "{text}");
        assert_eq!(load(&path).unwrap(), one);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_file_that_is_no_key_is_named_with_its_line_and_not_repeated() {
        let folder = folder("bad");
        let good = "0123456789abcdef".repeat(4);
        let table = [
            (String::new(), 1),
            ("newtau link key 2\n".to_owned() + &good, 1),
            ("newtau link key 1\n".to_owned(), 2),
            (format!("newtau link key 1\n{}\n", &good[..62]), 2),
            (format!("newtau link key 1\n{good}00\n"), 2),
            (format!("newtau link key 1\n{}+f\n", &good[..62]), 2),
            (format!("newtau link key 1\n{good}\nmore\n"), 3),
        ];
        for (index, (text, line)) in table.iter().enumerate() {
            let path = folder.join(index.to_string());
            super::write_for_owner(&path, text.as_bytes()).unwrap();
            let error = load(&path).unwrap_err().to_string();
            assert!(error.contains(&format!("{index}:{line}: found")), "{error}");
            assert!(!error.contains(&good[..8]), "{error}");
        }
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn a_key_that_others_can_read_is_refused() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = folder("open");
        let path = folder.join("key");
        save(&new().unwrap(), &path).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains("mode 640") && error.contains("chmod 600"), "{error}");
        fs::remove_dir_all(folder).unwrap();
    }
}
