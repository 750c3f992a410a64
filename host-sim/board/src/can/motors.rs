//! Motors on a bus: search, state and settings. Nothing here enables a motor.
//!
//! A search reads the communication timeout of every identifier. Kinds whose timeout cannot be read are not searched for: motors of the kind `mit`
//! answer only to commands, and a request to a MyActuator drive may have the identifier of a command to a motor of another kind.

use super::adapter::{Adapter, RECEIVED_MAX, UNSENT_MAX};
use super::frame::CanFrame;
use dynamics_core::drive::{Gearing, MitDrive, MitRanges, Protocol, Range, TIMEOUT_UNIT_US};
use embedded_can::Frame as _;
use joint_io::frames::{Frames, Notice, Packet, Setting};
use sim::with_drive_type;
use std::time::{Duration, Instant};
use std::{fmt, io};

/// Identifiers that are searched: those that a robot file can have.
const IDS: core::ops::RangeInclusive<u8> = 1..=127;

/// Interval of the requests of a search. A request and its answer take 0.3 ms.
const EVERY: Duration = Duration::from_millis(1);

/// Time for an answer.
pub const ANSWER: Duration = Duration::from_millis(50);

/// A motor that has answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Found {
    /// Its kind.
    pub kind: &'static str,
    /// Its identifier.
    pub id: u8,
    /// Identifier of its answer.
    pub reply_id: u32,
    /// Its communication timeout, us; 0 for none.
    pub timeout_us: u32,
}

/// Times that a setting is asked for before its motor counts as silent, because a frame may be lost.
pub(super) const TRIES: u32 = 3;

/// Advice after a value was written and not stored. Another setting that is stored later would store it too.
pub(super) const UNTIL_POWER_OFF: &str =
    "switch the motor's power off and on before anything else, then look at it again with `motors show`";

/// Value of a motor's setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A floating-point number.
    Float(f32),
    /// An integer.
    Integer(u32),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(value) => value.fmt(f),
            Self::Integer(value) => value.fmt(f),
        }
    }
}

/// Identifier with which this program asks RobStride motors, which reply to it.
pub(super) const HOST_ID: u16 = 0xFD;

/// A drive of which only the identifier is known. The other numbers are in no frame of this module.
pub(super) fn with_id(id: u8) -> MitDrive {
    let range = Range { min: -1.0, max: 1.0 };
    MitDrive {
        bus: 0,
        data_rate: None,
        id,
        reply_id: HOST_ID,
        reply_bytes: 8,
        temperature_offset: None,
        ranges: MitRanges { position: range, velocity: range, kp: range, kd: range, torque: range },
        gearing: Gearing { ratio: 1.0, per_ratio: 1.0, zero: 0.0 },
        damping: 0.0,
        timeout: 0,
        restart_ticks: 0,
        absolute: false,
    }
}

/// Searches a bus for motors of this kind. `None` if the kind has no timeout that can be read.
///
/// # Errors
/// The adapter is gone, or sends nothing.
pub fn search(adapter: &mut dyn Adapter, kind: Protocol) -> io::Result<Option<Vec<Found>>> {
    with_drive_type!(kind, K => search_of::<K>(adapter, kind.facts().name))
}

fn search_of<F: Frames>(adapter: &mut dyn Adapter, kind: &'static str) -> io::Result<Option<Vec<Found>>> {
    let mut found = Vec::new();
    for id in IDS {
        let Some(request) = F::read_timeout(&with_id(id)) else { return Ok(None) };
        send(adapter, &frame(&request)?)?;
        std::thread::sleep(EVERY);
        collect::<F>(adapter, kind, &mut found)?;
    }
    let end = Instant::now() + ANSWER;
    while Instant::now() < end {
        std::thread::sleep(EVERY);
        collect::<F>(adapter, kind, &mut found)?;
    }
    found.sort_unstable();
    found.dedup();
    Ok(Some(found))
}

/// Number of requests of [`round_trip`].
const ROUND_TRIPS: usize = 50;

/// Longest time from a request to a drive to its answer, in fifty of them, for the first of these drives that answers. `None` if none does, or if
/// their kind answers nothing but commands. Neither enables nor moves anything.
///
/// # Errors
/// The adapter is gone, or does not send.
pub fn round_trip(adapter: &mut dyn Adapter, kind: Protocol, drives: &[MitDrive]) -> io::Result<Option<Duration>> {
    with_drive_type!(kind, K => drives.iter().find_map(|drive| longest::<K>(adapter, drive).transpose()).transpose())
}

fn longest<F: Frames>(adapter: &mut dyn Adapter, drive: &MitDrive) -> io::Result<Option<Duration>> {
    let Some(request) = F::read_timeout(drive).or_else(|| F::request_status(drive)) else { return Ok(None) };
    let (request, mut longest) = (frame(&request)?, Duration::ZERO);
    let answers = |answer: &CanFrame| {
        let (id, data) = (answer.id(), answer.data());
        let is_one =
            F::setting(drive, id, data).is_some() || matches!(F::notice(drive, id, data), Some(Notice::Status(_)));
        is_one.then_some(())
    };
    for _ in 0..ROUND_TRIPS {
        let begun = Instant::now();
        let answered = ask(adapter, &request, answers)?;
        if answered.is_none() {
            return Ok(None);
        }
        longest = longest.max(begun.elapsed());
    }
    Ok(Some(longest))
}

/// Adds the motors whose answers have arrived.
fn collect<F: Frames>(adapter: &mut dyn Adapter, kind: &'static str, found: &mut Vec<Found>) -> io::Result<()> {
    while let Some(answer) = receive(adapter)? {
        // A Damiao names itself in the data, a RobStride in the identifier.
        let is_of = |drive: &MitDrive| !answer.is_extended() || F::answers(drive, answer.id());
        let of = |id| match F::setting(&with_id(id), answer.id(), answer.data()) {
            Some(Setting::Timeout(units)) if is_of(&with_id(id)) => {
                Some(Found { kind, id, reply_id: answer.raw_id(), timeout_us: units.saturating_mul(TIMEOUT_UNIT_US) })
            }
            _ => None,
        };
        found.extend(IDS.filter_map(of));
    }
    Ok(())
}

/// The next data frame. Errors of the bus are skipped, a lost adapter is not.
fn receive(adapter: &mut dyn Adapter) -> io::Result<Option<CanFrame>> {
    loop {
        match adapter.receive() {
            Ok(Some(frame)) if frame.is_data_frame() => return Ok(Some(frame)),
            Ok(Some(_)) => {}
            Ok(None) if adapter.is_off() => {
                return Err(io::Error::new(io::ErrorKind::BrokenPipe, "the adapter is off the bus or unplugged"));
            }
            Ok(None) => return Ok(None),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {}
            Err(error) if adapter.is_off() => return Err(error),
            Err(_) => {}
        }
    }
}

/// Sends a frame. The one before it may still be on its way through an adapter, which reports that a moment later.
///
/// # Errors
/// The adapter is gone, or frames wait because nothing on the bus acknowledges them.
fn send(adapter: &mut dyn Adapter, frame: &CanFrame) -> io::Result<()> {
    let is_waiting =
        |sent: &io::Result<()>| sent.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock);
    adapter.begin_tick();
    let mut sent = adapter.send(frame);
    // After more ticks, an adapter counts as off.
    for _ in 1..UNSENT_MAX {
        if !is_waiting(&sent) {
            break;
        }
        std::thread::sleep(EVERY);
        adapter.begin_tick();
        sent = adapter.send(frame);
    }
    sent.map_err(|error| match error.kind() {
        io::ErrorKind::WouldBlock => io::Error::new(
            io::ErrorKind::WouldBlock,
            "frames wait, because nothing on the bus acknowledges them: is the drives' power on, and is the bus terminated at both ends?",
        ),
        _ => error,
    })
}

fn frame(packet: &Packet) -> io::Result<CanFrame> {
    CanFrame::new(packet.id, &packet.data).ok_or_else(|| io::ErrorKind::InvalidInput.into())
}

/// Sends a frame, and returns the first answer for which `read` returns a value; `None` if none comes within [`ANSWER`].
///
/// # Errors
/// The adapter is gone, or does not send.
pub(super) fn ask<T>(
    adapter: &mut dyn Adapter,
    request: &CanFrame,
    read: impl FnMut(&CanFrame) -> Option<T>,
) -> io::Result<Option<T>> {
    ask_within(ANSWER, adapter, request, read)
}

/// As [`ask`], with another time for the answer.
pub(super) fn ask_within<T>(
    time: Duration,
    adapter: &mut dyn Adapter,
    request: &CanFrame,
    read: impl FnMut(&CanFrame) -> Option<T>,
) -> io::Result<Option<T>> {
    drain(adapter)?;
    send(adapter, request)?;
    first(time, adapter, read)
}

/// Time for which a bus is listened to before a motor counts as unused.
const LISTENING: Duration = Duration::from_millis(200);

/// Listens to the bus, and returns the first value that `read` returns for a frame.
///
/// # Errors
/// The adapter is gone.
pub(super) fn listen<T>(adapter: &mut dyn Adapter, read: impl FnMut(&CanFrame) -> Option<T>) -> io::Result<Option<T>> {
    drain(adapter)?;
    first(LISTENING, adapter, read)
}

/// The first value that `read` returns for a frame within this time.
fn first<T>(
    time: Duration,
    adapter: &mut dyn Adapter,
    mut read: impl FnMut(&CanFrame) -> Option<T>,
) -> io::Result<Option<T>> {
    let end = Instant::now() + time;
    while Instant::now() < end {
        match receive(adapter)?.map(|frame| read(&frame)) {
            Some(Some(value)) => return Ok(Some(value)),
            Some(None) => {}
            None => std::thread::sleep(Duration::from_micros(100)),
        }
    }
    Ok(None)
}

/// Drops answers to earlier requests. An adapter keeps few, and a busy bus must not hold this up.
fn drain(adapter: &mut dyn Adapter) -> io::Result<()> {
    for _ in 0..RECEIVED_MAX {
        if receive(adapter)?.is_none() {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
