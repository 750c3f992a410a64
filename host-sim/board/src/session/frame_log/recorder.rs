//! Writer of a session's record in either format; the file's extension selects it.

use super::viewer::{Recorded, SessionFile};
use super::{Direction, Writer};
use link::Frame;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;
use std::time::Duration;

/// A record that is being written.
#[derive(Debug)]
pub enum Recorder {
    /// Frames and nothing else.
    Frames(Writer<BufWriter<File>>),
    /// MCAP, which viewers can show.
    Viewer(Box<SessionFile<BufWriter<File>>>),
}

impl Recorder {
    /// Begins a record: MCAP if the file name ends in `.mcap`, otherwise frames alone.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(file: &Path, of: &Recorded) -> io::Result<Self> {
        let out = BufWriter::new(File::create(file)?);
        let mcap = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
        Ok(if mcap {
            Self::Viewer(Box::new(SessionFile::new(out, of)?))
        } else {
            Self::Frames(Writer::new(out, &of.head)?)
        })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, way: Direction, missed: u8, at: Duration, frame: &Frame) -> io::Result<()> {
        match self {
            Self::Frames(writer) => writer.push(way, missed, at, frame),
            Self::Viewer(file) => file.push(way, missed, at, frame),
        }
    }

    /// Writes all buffered data and the end of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn close(self) -> io::Result<()> {
        match self {
            Self::Frames(mut writer) => writer.flush(),
            Self::Viewer(file) => file.close(),
        }
    }
}
