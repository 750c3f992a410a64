//! Record of a session as MCAP: all frames bit for bit, and in addition messages that viewers can show.

use super::{Direction, ENTRY, Head, Log, LogError, VERSION, encoded, entry};
use crate::session::operate::messages;
use dynamics_core::control::Encoder;
use link::{Actuation, Frame, PROTOCOL_VERSION, Sensed, StateCode, Status};
use robot_compiler::Robot;
use sim::run::mcap_file::arm::ArmChannels;
use sim::run::mcap_file::messages::{JointTick, LinkFrame, Message as _, Tick, Time, finite};
use sim::run::mcap_file::reader::{Item, Reader};
use sim::run::mcap_file::writer::{Channel, Writer};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::time::Duration;

/// Name of the metadata that marks an MCAP file as a record of a session.
const ABOUT: &str = "newtau.session";

/// Interval of the chunks: a file that is cut off loses at most this much.
const CHUNK: Duration = Duration::from_secs(1);

/// Data about a session's arm for a record.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Robot, scene and controller of the frames.
    pub head: Head,
    /// The robot.
    pub robot: Robot,
    /// Encoders of its joints, base first.
    pub encoders: Vec<Encoder<f64>>,
}

/// A record that is being written.
#[derive(Debug)]
pub struct SessionFile<W: Write> {
    file: Writer<W>,
    frames: Channel<LinkFrame>,
    ticks: Channel<Tick>,
    arm: ArmChannels,
    encoders: Vec<Encoder<f64>>,
    /// Tick and readings that the host sent last. In a dry run, the next status answers them.
    told: Option<(u32, Sensed)>,
    /// Time at which the next chunk ends.
    chunk_end: Duration,
}

impl<W: Write> SessionFile<W> {
    /// Begins a record.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(out: W, of: &Recorded) -> io::Result<Self> {
        let mut file = Writer::new(out)?;
        file.about(ABOUT, about(&of.head))?;
        let arm = ArmChannels::new(&mut file, &of.robot)?;
        let (frames, ticks) = (file.channel("/newtau/frame")?, file.channel("/newtau/tick")?);
        let encoders = of.encoders.clone();
        Ok(Self { file, frames, ticks, arm, encoders, told: None, chunk_end: CHUNK })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, way: Direction, missed: u8, at: Duration, frame: &Frame) -> io::Result<()> {
        let micros = u64::try_from(at.as_micros()).unwrap_or(u64::MAX);
        let nanos = micros.saturating_mul(1000);
        let text = |way| if way == Direction::Sent { "sent" } else { "received" };
        let hex = encoded(frame, |bytes| bytes.iter().map(|byte| format!("{byte:02x}")).collect())?;
        let message = LinkFrame { way: text(way).to_owned(), missed, micros, frame: hex };
        self.file.write(&self.frames, nanos, &message)?;
        match (way, frame) {
            (Direction::Sent, Frame::Measurement(measurement)) => {
                self.told = Some((measurement.tick, measurement.sensed.clone()));
            }
            (Direction::Received, Frame::Status(status)) => self.tick(nanos, status)?,
            _ => {}
        }
        if at >= self.chunk_end {
            self.chunk_end = at + CHUNK;
            self.file.flush()?;
        }
        Ok(())
    }

    /// Writes a status as a message about the arm.
    fn tick(&mut self, at: u64, status: &Status) -> io::Result<()> {
        let told = self.told.as_ref().filter(|(tick, _)| *tick == status.tick).map(|(_, sensed)| sensed);
        let (q, qd) = match status.sensed.as_ref().map(|said| &said.sensed).or(told) {
            Some(Sensed::State { q, qd }) => (wide(q), wide(qd)),
            Some(Sensed::Counts(counts)) => {
                let places = counts.iter().zip(&self.encoders).map(|(count, encoder)| encoder.position(*count));
                (places.collect(), Vec::new())
            }
            None => (Vec::new(), Vec::new()),
        };
        let (torque, limits) = match &status.actuation {
            Some(Actuation::Drive { torque, limits }) => (wide(torque), limits.to_vec()),
            _ => (Vec::new(), Vec::new()),
        };
        self.arm.write(&mut self.file, at, &q, &qd, &torque)?;
        let reference = status.reference();
        let external = status.external().map(wide).unwrap_or_default();
        let of = |values: &[f64], joint: usize| values.get(joint).copied().and_then(finite);
        let asked = |values: Option<&[f32]>, joint: usize| values.and_then(|all| finite(f64::from(*all.get(joint)?)));
        let joint = |(i, name): (usize, &String)| JointTick {
            name: name.clone(),
            reference: asked(reference.map(|reference| &*reference.q), i),
            reference_velocity: asked(reference.map(|reference| &*reference.qd), i),
            position: of(&q, i),
            velocity: of(&qd, i),
            torque: of(&torque, i),
            limits: limits.get(i).copied().unwrap_or_default(),
            external: of(&external, i),
            terms: None,
        };
        let fault = if status.state == StateCode::Fault { status.cause } else { 0 };
        let message = Tick {
            timestamp: Time::from_nanos(at),
            tick: status.tick.into(),
            joints: self.arm.names().iter().enumerate().map(joint).collect(),
            fault,
            fault_text: (fault != 0).then(|| messages::fault(fault, status.joint)),
            state: Some(status.state.code()),
            tip_wrench: None,
        };
        self.file.write(&self.ticks, at, &message)
    }

    /// Writes the index and the end of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn close(self) -> io::Result<()> {
        self.file.finish()
    }
}

fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(f64::from).collect()
}

fn about(head: &Head) -> BTreeMap<String, String> {
    let texts = [
        ("layout", VERSION.to_string()),
        ("protocol", PROTOCOL_VERSION.to_string()),
        ("hash", format!("{:016x}", head.hash)),
        ("scene", head.scene.to_string_lossy().into_owned()),
        ("text", head.text.clone()),
    ];
    texts.map(|(key, text)| (key.to_owned(), text)).into()
}

fn head(texts: &BTreeMap<String, String>) -> Result<Head, LogError> {
    let text = |key: &str| texts.get(key).ok_or_else(|| LogError::Mcap(format!("{ABOUT} has no text {key:?}")));
    for (key, what, expected) in
        [("layout", "layout", VERSION), ("protocol", "link's protocol", PROTOCOL_VERSION.into())]
    {
        let found = text(key)?;
        if *found != expected.to_string() {
            return Err(LogError::Mcap(format!("version {found} of the {what}, expected {expected}")));
        }
    }
    let hash = text("hash")?;
    let bad = |_| LogError::Mcap(format!("{ABOUT}: hash {hash:?}, expected hexadecimal digits"));
    Ok(Head {
        hash: u64::from_str_radix(hash, 16).map_err(bad)?,
        scene: text("scene")?.into(),
        text: text("text")?.clone(),
    })
}

/// Reads such a record into a log with entries of the other layout.
pub(super) fn read(bytes: &[u8]) -> Result<Log, LogError> {
    let mut reader = Reader::new(bytes);
    let (mut found, mut entries, mut number) = (None, Vec::new(), 0);
    for item in &mut reader {
        match item.map_err(|problem| LogError::Mcap(format!("message {}: {problem}", number + 1)))? {
            Item::About(name, texts) if name == ABOUT => found = Some(head(&texts)?),
            Item::Message(raw) if raw.schema == LinkFrame::SCHEMA => {
                number += 1;
                let bad = |problem| LogError::Mcap(format!("message {number} of {}: {problem}", raw.topic));
                let frame = serde_json::from_slice(&raw.data).map_err(|error| bad(error.to_string()))?;
                append(&mut entries, &frame).map_err(bad)?;
            }
            _ => {}
        }
    }
    let missing = || match reader.left_out() {
        0 => LogError::Mcap(format!("an MCAP file without {ABOUT}; expected one that `connect --record` wrote")),
        _ => LogError::Headless(bytes.len()),
    };
    let head = found.ok_or_else(missing)?;
    Ok(Log { head, bytes: entries, begin: 0, lost: Some((reader.left_out(), reader.has_end())) })
}

/// Appends a frame as an entry of the other layout.
fn append(entries: &mut Vec<u8>, message: &LinkFrame) -> Result<(), String> {
    let way = match message.way.as_str() {
        "sent" => 0,
        "received" => 1,
        other => return Err(format!("way {other:?}, expected \"sent\" or \"received\"")),
    };
    let frame = bytes_of(&message.frame).ok_or("a frame that is not in hexadecimal digits")?;
    let length = u16::try_from(frame.len()).map_err(|_| format!("a frame of {} bytes", frame.len()))?;
    let begin = entries.len();
    entries.extend([way, message.missed]);
    entries.extend(length.to_le_bytes());
    entries.extend(message.micros.to_le_bytes());
    entries.extend(&frame);
    entry(&entries[begin..begin + ENTRY], &frame).map(|_| ())
}

fn bytes_of(hex: &str) -> Option<Vec<u8>> {
    let digit = |c: u8| char::from(c).to_digit(16);
    let pair = |pair: &[u8]| match pair {
        [high, low] => Some((digit(*high)? * 16 + digit(*low)?) as u8),
        _ => None,
    };
    hex.as_bytes().chunks(2).map(pair).collect()
}
