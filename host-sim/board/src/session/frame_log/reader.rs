//! A log from the bytes of a file, in either format.

use super::viewer;
use super::{Head, Log, LogError, MAGIC, VERSION};
use link::PROTOCOL_VERSION;
use sim::run::mcap_file;

/// True if a file begins as a record of a session does, in either format.
#[must_use]
pub fn is_record(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC) || bytes.starts_with(mcap_file::MAGIC)
}

impl Log {
    /// Reads the head.
    ///
    /// # Errors
    /// See [`LogError`].
    pub fn new(bytes: Vec<u8>) -> Result<Self, LogError> {
        if bytes.starts_with(mcap_file::MAGIC) {
            return viewer::read(&bytes);
        }
        if !bytes.starts_with(&MAGIC) {
            return Err(LogError::NotALog);
        }
        let mut at = MAGIC.len();
        let version = |at, what, found, expected| {
            if found == expected { Ok(()) } else { Err(LogError::OtherVersion { at, what, found, expected }) }
        };
        version(at, "layout", u16::from_le_bytes(take(&bytes, &mut at)?), VERSION)?;
        let [protocol] = take(&bytes, &mut at)?;
        version(at - 1, "link's protocol", protocol.into(), PROTOCOL_VERSION.into())?;
        let hash = u64::from_le_bytes(take(&bytes, &mut at)?);
        let (scene, text) = (text(&bytes, &mut at)?, text(&bytes, &mut at)?);
        Ok(Self { head: Head { hash, scene: scene.into(), text }, bytes, begin: at, lost: None })
    }
}

fn take<const M: usize>(bytes: &[u8], at: &mut usize) -> Result<[u8; M], LogError> {
    let taken = bytes.get(*at..).and_then(|rest| rest.first_chunk()).ok_or(LogError::Headless(bytes.len()))?;
    *at += M;
    Ok(*taken)
}

fn text(bytes: &[u8], at: &mut usize) -> Result<String, LogError> {
    let length = u32::from_le_bytes(take(bytes, at)?) as usize;
    let end = at.checked_add(length).ok_or(LogError::Headless(bytes.len()))?;
    let text = bytes.get(*at..end).ok_or(LogError::Headless(bytes.len()))?;
    let text = String::from_utf8(text.to_vec()).map_err(|_| LogError::NotText(*at))?;
    *at = end;
    Ok(text)
}
