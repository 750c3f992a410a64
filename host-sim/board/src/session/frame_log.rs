//! Record of a link as a file: every frame sent and received, in order, to the last bit.
//!
//! All numbers are little-endian:
//!
//! | part | bytes | content |
//! |---|---|---|
//! | head | 8 | `NEWTAULG` |
//! | | 2 | version of this layout: 1 |
//! | | 1 | version of the link's protocol, [`link::PROTOCOL_VERSION`] |
//! | | 8 | hash of robot, scene and controller, as in both hellos |
//! | | 4, n | length and text of the scene file's path |
//! | | 4, n | length and text of the scene file |
//! | entry | 1 | 0 sent to the board, 1 received from it |
//! | | 1 | number of packets lost before a received frame, modulo 256 |
//! | | 2 | length of the frame |
//! | | 8 | time since the start of the session, us: wall-clock time in a live session, simulated time in a dry run |
//! | | n | the frame in postcard's encoding, as on the wire |
//!
//! Entries follow each other until the end of the file. There is no checksum: a replay finds the effect of a flipped
//! bit. If the writer was killed, the file ends within an entry; all complete entries before it can be read
//! ([`Log::cut`]).
//!
//! A file that ends in `.mcap` holds the same frames for viewers ([`viewer`]); both are read alike.

mod reader;
pub mod recorder;
pub mod viewer;

pub use reader::is_record;

use link::{Frame, PACKET_MAX, PROTOCOL_VERSION};
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

/// First bytes of such a file.
pub const MAGIC: [u8; 8] = *b"NEWTAULG";

/// Version of the layout.
pub const VERSION: u16 = 1;

/// Robot, scene and controller of the frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// Hash of robot, scene and controller.
    pub hash: u64,
    /// Path of the scene file; the paths in the scene are relative to it.
    pub scene: PathBuf,
    /// Text of the scene file.
    pub text: String,
}

/// Sender of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Sent by the host.
    Sent,
    /// Sent by the board, received by the host.
    Received,
}

/// A frame in the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its sender.
    pub way: Direction,
    /// Packets lost before it, modulo 256.
    pub missed: u8,
    /// Time since the start of the session.
    pub at: Duration,
    /// The frame itself.
    pub frame: Frame,
}

/// Reason why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LogError {
    /// The file begins with other bytes.
    #[error("byte 0: no record of a session; expected a file that begins with NEWTAULG, or an MCAP file")]
    NotALog,
    /// An MCAP file that holds no record, or a broken one.
    #[error("{0}")]
    Mcap(String),
    /// The file ends within its head.
    #[error("the file ends within its head, at byte {0}")]
    Headless(usize),
    /// The file was written by another version.
    #[error("byte {at}: version {found} of the {what}, expected {expected}")]
    OtherVersion {
        /// Offset of the version.
        at: usize,
        /// The versioned part: the layout or the link's protocol.
        what: &'static str,
        /// Version in the file.
        found: u16,
        /// Version that this program reads.
        expected: u16,
    },
    /// A text of the head is not UTF-8.
    #[error("byte {0}: a text of the head is not UTF-8")]
    NotText(usize),
    /// An entry does not decode to a frame.
    #[error("entry {number}, byte {at}: {problem}")]
    BadEntry {
        /// Number of the entry, counted from 1.
        number: usize,
        /// Offset of the entry.
        at: usize,
        /// Description of the error.
        problem: String,
    },
}

/// Writer of such a file.
#[derive(Debug)]
pub struct Writer<W>(W);

impl<W: Write> Writer<W> {
    /// Writes the head.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(mut out: W, head: &Head) -> io::Result<Self> {
        out.write_all(&MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        out.write_all(&[PROTOCOL_VERSION])?;
        out.write_all(&head.hash.to_le_bytes())?;
        for text in [&*head.scene.to_string_lossy(), &head.text] {
            let length = u32::try_from(text.len()).map_err(io::Error::other)?;
            out.write_all(&length.to_le_bytes())?;
            out.write_all(text.as_bytes())?;
        }
        Ok(Self(out))
    }

    /// Writes an entry.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, way: Direction, missed: u8, at: Duration, frame: &Frame) -> io::Result<()> {
        let bytes = encoded(frame, <[u8]>::to_vec)?;
        let length = u16::try_from(bytes.len()).map_err(io::Error::other)?;
        let micros = u64::try_from(at.as_micros()).unwrap_or(u64::MAX);
        self.0.write_all(&[u8::from(way == Direction::Received), missed])?;
        self.0.write_all(&length.to_le_bytes())?;
        self.0.write_all(&micros.to_le_bytes())?;
        self.0.write_all(&bytes)
    }

    /// Writes all buffered bytes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// A frame as on the wire.
fn encoded<T>(frame: &Frame, of: impl Fn(&[u8]) -> T) -> io::Result<T> {
    let mut buffer = [0; PACKET_MAX];
    let bytes = postcard::to_slice(frame, &mut buffer).map_err(io::Error::other)?;
    Ok(of(bytes))
}

/// A log that was read.
#[derive(Clone, Debug)]
pub struct Log {
    /// Robot, scene and controller of the frames.
    pub head: Head,
    bytes: Vec<u8>,
    /// Offset of the first entry.
    begin: usize,
    /// For an MCAP file: number of bytes that could not be read, and true if the file has its end record.
    lost: Option<(usize, bool)>,
}

/// Bytes of an entry before its frame.
const ENTRY: usize = 12;

impl Log {
    /// The frames, in order, up to the last complete entry.
    pub fn entries(&self) -> impl Iterator<Item = Result<Entry, LogError>> {
        let mut at = self.begin;
        (1..).map_while(move |number| {
            let (begin, end) = whole(&self.bytes, at)?;
            let entry = entry(&self.bytes[at..begin], &self.bytes[begin..end]);
            let entry = entry.map_err(|problem| LogError::BadEntry { number, at, problem });
            at = end;
            Some(entry)
        })
    }

    /// True if the file has its end record. A format without an end record always counts as complete.
    #[must_use]
    pub fn has_end(&self) -> bool {
        self.lost.is_none_or(|(_, has_end)| has_end)
    }

    /// Number of bytes at the end of the file that are an incomplete entry, or an incomplete chunk of entries.
    #[must_use]
    pub fn cut(&self) -> usize {
        if let Some((left_out, _)) = self.lost {
            return left_out;
        }
        let mut at = self.begin;
        while let Some((_, end)) = whole(&self.bytes, at) {
            at = end;
        }
        self.bytes.len() - at
    }
}

/// Begin and end of the frame of the entry at this offset, if it is complete.
fn whole(bytes: &[u8], at: usize) -> Option<(usize, usize)> {
    let length = bytes.get(at + 2..at + 4)?;
    let begin = at + ENTRY;
    let end = begin + usize::from(u16::from_le_bytes(length.try_into().ok()?));
    (end <= bytes.len()).then_some((begin, end))
}

fn entry(head: &[u8], frame: &[u8]) -> Result<Entry, String> {
    let &[way, missed, _, _, ref micros @ ..] = head else { return Err("no head".into()) };
    let way = match way {
        0 => Direction::Sent,
        1 => Direction::Received,
        other => return Err(format!("direction {other}, expected 0 (sent) or 1 (received)")),
    };
    let micros = micros.try_into().map(u64::from_le_bytes).map_err(|error| error.to_string())?;
    let tag = frame.first().copied().unwrap_or(u8::MAX);
    if tag >= Frame::KINDS {
        return Err(format!("frame of kind {tag}, expected one below {}", Frame::KINDS));
    }
    match postcard::take_from_bytes(frame) {
        Ok((frame, [])) => Ok(Entry { way, missed, at: Duration::from_micros(micros), frame }),
        Ok((_, left)) => Err(format!("{} bytes are left over behind a frame of kind {tag}", left.len())),
        Err(error) => Err(format!("a frame of kind {tag} that makes none: {error}")),
    }
}

#[cfg(test)]
mod tests;
