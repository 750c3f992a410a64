//! Reader of the messages of an MCAP file, in order, up to the point where the file was cut off.

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, HashMap};

/// A message as the file contains it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raw {
    /// Its topic.
    pub topic: String,
    /// Name of its schema; empty if it has none.
    pub schema: String,
    /// Time in the file, ns.
    pub at: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// An item of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// A message.
    Message(Raw),
    /// Metadata of the file: the name of a group of texts, and the texts.
    About(String, BTreeMap<String, String>),
}

/// Reader of a file from its start to its end, or to the point where it was cut off. An incomplete chunk and everything after it are lost.
pub struct Reader<'a> {
    bytes: &'a [u8],
    reader: LinearReader,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, (String, u16)>,
    done: bool,
    /// True if the footer has been read.
    ended: bool,
    /// Bytes read in all, and bytes up to the end of the last complete record.
    taken: usize,
    whole: usize,
    length: usize,
}

impl<'a> Reader<'a> {
    /// Reads these bytes, which begin with [`super::MAGIC`].
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        // The whole chunk is checked before its first message is returned, and the whole file at its end.
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(bytes.len());
        Self {
            bytes,
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            done: false,
            ended: false,
            taken: 0,
            whole: 0,
            length: bytes.len(),
        }
    }

    /// True if the file has its end record. Valid only after all items have been read.
    #[must_use]
    pub fn has_end(&self) -> bool {
        self.ended
    }

    /// Number of bytes after the last complete chunk or record of a file that was cut off. Valid only after all items have been read.
    #[must_use]
    pub fn left_out(&self) -> usize {
        if self.ended { 0 } else { self.length - self.whole }
    }

    /// Handles a record. Returns its item if it is relevant, or a description of the error.
    fn take(&mut self, record: Record<'_>) -> Result<Option<Item>, String> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, (channel.topic, channel.schema_id));
            }
            Record::Message { header, data } => {
                let unknown = || format!("a message of the unknown channel {}", header.channel_id);
                let (topic, schema) = self.channels.get(&header.channel_id).ok_or_else(unknown)?;
                let schema = self.schemas.get(schema).cloned().unwrap_or_default();
                let raw = Raw { topic: topic.clone(), schema, at: header.log_time, data: data.into_owned() };
                return Ok(Some(Item::Message(raw)));
            }
            Record::Metadata(about) => return Ok(Some(Item::About(about.name, about.metadata))),
            _ => {}
        }
        Ok(None)
    }
}

/// Records that are read. The contents of all others are ignored, even the lengths in them.
const READ: [u8; 4] = [op::SCHEMA, op::CHANNEL, op::MESSAGE, op::METADATA];

impl Iterator for Reader<'_> {
    type Item = Result<Item, String>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.done {
            let record = match self.reader.next_event() {
                None => break,
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                    let given = wanted.min(self.bytes.len());
                    let (now, later) = self.bytes.split_at(given);
                    self.reader.insert(given).copy_from_slice(now);
                    self.reader.notify_read(given);
                    self.bytes = later;
                    self.taken += given;
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    self.whole = self.taken;
                    self.ended |= opcode == op::FOOTER;
                    if !READ.contains(&opcode) {
                        continue;
                    }
                    mcap::read::parse_record(opcode, data).map(Record::into_owned)
                }
                // A record that is longer than the rest of the file was cut off.
                Some(Err(
                    McapError::UnexpectedEof | McapError::RecordTooLarge { .. } | McapError::ChunkTooLarge(_),
                )) => break,
                Some(Err(error)) => Err(error),
            };
            let taken = record.map_err(|error| error.to_string()).and_then(|record| self.take(record));
            match taken {
                Ok(None) => {}
                Ok(Some(item)) => return Some(Ok(item)),
                Err(problem) => {
                    self.done = true;
                    return Some(Err(problem));
                }
            }
        }
        self.done = true;
        None
    }
}
