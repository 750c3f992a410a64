//! An MCAP file with typed channels.

use super::messages::Message;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};
use std::marker::PhantomData;

/// Writer of an MCAP file. It holds one chunk, and the index of the chunks before, in memory.
pub struct Writer<W: Write> {
    file: mcap::Writer<NoSeek<W>>,
    buffer: Vec<u8>,
}

/// A topic of a file, with messages of one type.
#[derive(Debug)]
pub struct Channel<M> {
    id: u16,
    message: PhantomData<M>,
}

impl<W: Write> Writer<W> {
    /// Writes the head of a file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(out: W) -> io::Result<Self> {
        // Whole chunks are written at once. So a file that is cut off ends after a complete chunk, and no chunk claims bytes that are missing.
        let options = WriteOptions::new().compression(None).disable_seeking(true);
        Ok(Self { file: options.create(NoSeek::new(out)).map_err(failed)?, buffer: Vec::new() })
    }

    /// Adds a topic.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn channel<M: Message>(&mut self, topic: &str) -> io::Result<Channel<M>> {
        let schema = serde_json::to_vec(&M::schema())?;
        let schema = self.file.add_schema(M::SCHEMA, "jsonschema", &schema).map_err(failed)?;
        let id = self.file.add_channel(schema, topic, "json", &BTreeMap::new()).map_err(failed)?;
        Ok(Channel { id, message: PhantomData })
    }

    /// Writes a message at a time in the file, ns.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write<M: Message>(&mut self, channel: &Channel<M>, at: u64, message: &M) -> io::Result<()> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, message)?;
        let header = MessageHeader { channel_id: channel.id, sequence: 0, log_time: at, publish_time: at };
        self.file.write_to_known_channel(&header, &self.buffer).map_err(failed)
    }

    /// Writes named texts about the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn about(&mut self, name: &str, texts: BTreeMap<String, String>) -> io::Result<()> {
        self.file.write_metadata(&Metadata { name: name.to_owned(), metadata: texts }).map_err(failed)
    }

    /// Ends the chunk. A file that is cut off later keeps everything written before.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(failed)
    }

    /// Writes the index and the end of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.file.finish().map_err(failed)?;
        self.file.into_inner().into_inner().flush()
    }
}

impl<W: Write> fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Writer").finish_non_exhaustive()
    }
}

fn failed(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
