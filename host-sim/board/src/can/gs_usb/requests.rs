//! Control requests that start and reset a channel.
//!
//! | order | request | number | wValue | data |
//! |---|---|---|---|---|
//! | 1 | host format: low byte first | 0 | 1 | `EF BE 00 00` |
//! | 2 | configuration | 5 | 1 | answer of 12 bytes; byte 3 is the number of channels less one |
//! | 3 | mode: reset | 2 | channel | 0, 0 |
//! | 4 | limits of the bit timing | 4 | channel | answer of 40 bytes |
//! | 5 | bit timing | 1 | channel | five numbers |
//! | 6 | mode: start, without any option | 2 | channel | 1, 0 |
//!
//! The reset is needed because a program that is killed leaves the channel started. Between reset and limits, everything that the adapter still has
//! for the earlier program is read and dropped.

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

/// Number of consecutive milliseconds without a transfer after which the adapter has none left, and the longest wait for them, ms.
const QUIET_MS: u32 = 3;
const DROPPING_MAX_MS: u32 = 100;

/// Most transfers that are dropped in a millisecond.
const DROPPED_MAX: usize = 256;

/// Starts a channel at 1 Mbit/s. Returns true if the adapter needs a further byte in each transfer.
///
/// # Errors
/// The adapter has no such channel, refuses a request, or cannot have this bit rate.
pub(super) fn start<T: Transport>(usb: &mut T, channel: u8) -> io::Result<bool> {
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
    reset(usb, channel)?;
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
    named("the bit timing", usb.control_out(BIT_TIMING, channel.into(), &timing.bytes()))?;
    // Listening only, loop-back, sending once and padding are options that stay off.
    named("to start", set_mode(usb, channel, 1))?;
    Ok(limits.features & LONGER_TRANSFERS != 0)
}

/// Resets a channel: it leaves the bus and drops its frames.
///
/// # Errors
/// As for [`Transport::control_out`].
pub(super) fn reset<T: Transport>(usb: &mut T, channel: u8) -> io::Result<()> {
    named("the reset", set_mode(usb, channel, 0))
}

fn set_mode<T: Transport>(usb: &mut T, channel: u8, mode: u8) -> io::Result<()> {
    usb.control_out(MODE, channel.into(), &[mode, 0, 0, 0, 0, 0, 0, 0])
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
    Err(wrong("it sends frames although its channel was reset; is another channel in use?".into()))
}

fn wrong(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

/// Adds the request to an error.
fn named<R>(request: &str, result: io::Result<R>) -> io::Result<R> {
    result.map_err(|error| io::Error::new(error.kind(), format!("the adapter was asked for {request}: {error}")))
}
