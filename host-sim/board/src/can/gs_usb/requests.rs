//! Control requests that start and reset a channel.
//!
//! | order | request | number | wValue | data |
//! |---|---|---|---|---|
//! | 1 | host format: low byte first | 0 | 1 | `EF BE 00 00` |
//! | 2 | configuration | 5 | 1 | answer of 12 bytes; byte 3 is the number of channels less one |
//! | 3 | mode: reset, of every channel | 2 | channel | 0, 0 |
//! | 4 | limits of the bit timing | 4 | channel | answer of 40 bytes |
//! | 5 | bit timing | 1 | channel | five numbers |
//! | 6 | mode: start, listening only and with loop-back | 2 | channel | 1, 3 |
//! | 7 | mode: reset | 2 | channel | 0, 0 |
//! | 8 | bit timing, and mode: start without any option | 1, 2 | channel | 1, 0 |
//!
//! **A reset does not drop the frames that wait in the adapter**, except in candleLight from July 2026 on (`can_disable` of `src/can.c`). The next start
//! would send them to the drives. So the channel is started once without the bus: with loop-back while only listening, frames reach no line. What comes
//! back from there, and what the adapter still has for an earlier program, is read and dropped. An adapter that does not offer both is not used. A
//! program that is killed leaves its channel started, therefore every channel is reset: no other program can use one, because the interface is ours.

use super::bit_timing::{LIMITS_BYTES, Limits};
use super::transport::Transport;
use std::io;
use std::thread::sleep;
use std::time::Duration;

const HOST_FORMAT: u8 = 0;
const BIT_TIMING: u8 = 1;
const MODE: u8 = 2;
const LIMITS: u8 = 4;
const CONFIGURATION: u8 = 5;

/// `wValue` of requests to the whole adapter.
const WHOLE: u16 = 1;

/// Bytes of the configuration.
const CONFIGURATION_BYTES: u16 = 12;

/// Feature bit of adapters whose transfers need a further byte.
const LONGER_TRANSFERS: u32 = 1 << 9;

/// Feature bits of adapters that can listen only and loop frames back; the same bits are flags of the mode.
const SILENT_LOOP: u32 = 0b11;

/// Number of consecutive milliseconds without a transfer after which the adapter has none left, and the longest wait for them, ms.
const QUIET_MS: u32 = 10;
const DROPPING_MAX_MS: u32 = 200;

/// Most transfers that are dropped in a millisecond.
const DROPPED_MAX: usize = 256;

/// A channel that was started.
#[derive(Clone, Debug)]
pub(super) struct Started {
    channel: u8,
    timing: Vec<u8>,
    /// True if the adapter needs a further byte in each transfer.
    pub(super) longer_transfers: bool,
}

/// Starts a channel at 1 Mbit/s, without any frame of an earlier program.
///
/// # Errors
/// The adapter has no such channel, refuses a request, cannot have this bit rate, or cannot drop old frames.
pub(super) fn start<T: Transport>(usb: &mut T, channel: u8) -> io::Result<Started> {
    named("the byte order", usb.control_out(HOST_FORMAT, WHOLE, &0x0000_beef_u32.to_le_bytes()))?;
    let configuration = named("its configuration", usb.control_in(CONFIGURATION, WHOLE, CONFIGURATION_BYTES))?;
    let Some(&last) = configuration.get(3).filter(|_| configuration.len() >= usize::from(CONFIGURATION_BYTES)) else {
        return Err(wrong(format!("its configuration has {} bytes, expected 12", configuration.len())));
    };
    if channel > last {
        let channels = if last == 0 { "only channel 0".to_owned() } else { format!("channels 0 to {last}") };
        return Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("no channel {channel}: the adapter has {channels}"),
        ));
    }
    for each in 0..=last {
        reset(usb, each)?;
    }
    drop_old(usb)?;
    let answer = named("the limits of its bit timing", usb.control_in(LIMITS, channel.into(), LIMITS_BYTES))?;
    let Some(limits) = Limits::of(&answer) else {
        return Err(wrong(format!(
            "the limits of its bit timing have {} bytes, expected {LIMITS_BYTES}",
            answer.len()
        )));
    };
    let timing = limits.timing().ok_or_else(|| {
        wrong(format!(
            "its clock of {} Hz allows no 1 Mbit/s with a sample point from 75 % to 90 % (limits: {limits:?})",
            limits.clock_hz
        ))
    })?;
    if limits.features & SILENT_LOOP != SILENT_LOOP {
        return Err(wrong(
            "it offers no loop-back while it only listens, so that frames of an earlier program could not be dropped"
                .into(),
        ));
    }
    let started =
        Started { channel, timing: timing.bytes().to_vec(), longer_transfers: limits.features & LONGER_TRANSFERS != 0 };
    let on = empty(usb, &started).and_then(|()| begin(usb, &started, 0));
    if on.is_err() {
        // It may have started all the same.
        let _ = reset(usb, channel);
    }
    on.map(|()| started)
}

/// Takes a channel off the bus, and drops every frame that waits in the adapter.
///
/// # Errors
/// As for [`Transport::control_out`].
pub(super) fn stop<T: Transport>(usb: &mut T, started: &Started) -> io::Result<()> {
    reset(usb, started.channel)?;
    empty(usb, started)
}

/// Resets a channel: it leaves the bus. Its frames may stay in the adapter.
///
/// # Errors
/// As for [`Transport::control_out`].
pub(super) fn reset<T: Transport>(usb: &mut T, channel: u8) -> io::Result<()> {
    named("the reset", set_mode(usb, channel, 0, 0))
}

/// Lets the frames that wait in the adapter of a channel that is off come back through its loop-back. The channel is off afterwards.
fn empty<T: Transport>(usb: &mut T, started: &Started) -> io::Result<()> {
    begin(usb, started, SILENT_LOOP)?;
    let emptied = drop_old(usb);
    reset(usb, started.channel)?;
    emptied
}

/// Starts a channel with these flags.
fn begin<T: Transport>(usb: &mut T, started: &Started, flags: u32) -> io::Result<()> {
    named("the bit timing", usb.control_out(BIT_TIMING, started.channel.into(), &started.timing))?;
    named("to start", set_mode(usb, started.channel, 1, flags))
}

fn set_mode<T: Transport>(usb: &mut T, channel: u8, mode: u32, flags: u32) -> io::Result<()> {
    let data = [mode.to_le_bytes(), flags.to_le_bytes()].concat();
    usb.control_out(MODE, channel.into(), &data)
}

/// Reads and drops what the adapter has for an earlier program.
fn drop_old<T: Transport>(usb: &mut T) -> io::Result<()> {
    let (mut bytes, mut quiet) = (Vec::new(), 0);
    for _ in 0..DROPPING_MAX_MS {
        let mut dropped = 0;
        while dropped < DROPPED_MAX && usb.receive(&mut bytes)? {
            dropped += 1;
        }
        quiet = if dropped == 0 { quiet + 1 } else { 0 };
        if quiet > QUIET_MS {
            return Ok(());
        }
        sleep(Duration::from_millis(1));
    }
    Err(wrong("it sends frames although its channels were reset".into()))
}

fn wrong(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

/// Adds the request to an error.
fn named<R>(request: &str, result: io::Result<R>) -> io::Result<R> {
    result.map_err(|error| io::Error::new(error.kind(), format!("the adapter was asked for {request}: {error}")))
}
