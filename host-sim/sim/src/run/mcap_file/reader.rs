//! Messages of an MCAP file, in their order, up to where the file was cut.

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, HashMap};

/// A message as the file has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raw {
    /// Its topic.
    pub topic: String,
    /// Name of its schema; empty where it has none.
    pub schema: String,
    /// Time of the file, ns.
    pub at: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// One thing that a file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// A message.
    Message(Raw),
    /// Texts about the file, and the name of their group.
    About(String, BTreeMap<String, String>),
}

/// Reads a file from its begin to its end, or to where it was cut: the chunks behind an incomplete one are lost, and so is that.
pub struct Reader<'a> {
    bytes: &'a [u8],
    reader: LinearReader,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, (String, u16)>,
    done: bool,
    /// True if the footer has been read.
    ended: bool,
    /// Bytes read in all, and up to the last whole record.
    taken: usize,
    whole: usize,
    length: usize,
}

impl<'a> Reader<'a> {
    /// Reads these bytes, which begin with [`super::MAGIC`].
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        // Before a message of a chunk is given, the whole chunk has been checked; at the end, all of it.
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

    /// True if the file has the end that its writer gives it, once all has been read.
    #[must_use]
    pub fn has_end(&self) -> bool {
        self.ended
    }

    /// Bytes behind the last whole chunk or record of a file that was cut, once all has been read.
    #[must_use]
    pub fn left_out(&self) -> usize {
        if self.ended { 0 } else { self.length - self.whole }
    }

    /// Takes a record; gives what it holds for us, or a description of what is wrong.
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

/// Records that are looked at; of the others not even the length of their parts is believed.
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
                // A record that is longer than the file is one that was cut off.
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
