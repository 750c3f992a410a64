//! The text protocol of Lawicel's CAN232, which CANable, CANtact and most small adapters speak: "slcan".
//!
//! | line, ended by `\r` | meaning |
//! |---|---|
//! | `C`, `S8`, `O` | leave the bus; 1 Mbit/s; join the bus |
//! | `tIIILDD...` | data frame: three hexadecimal digits of the identifier, length, bytes |
//! | `TIIIIIIIILDD...` | the same with an extended identifier, eight digits |
//! | `rIIIL`, `RIIIIIIIIL` | remote frames |
//! | empty, `z`, `Z`, `F..`, `V...` | answers, which are ignored |
//! | the byte 7 | a command was refused: counted as an error |
//!
//! Source: Lawicel AB, "CAN232 manual", version 3. A received frame may be followed by four digits of a time stamp, which are ignored.

use super::frame::CanFrame;
use super::serial_adapter::{Parsed, Protocol};
use dynamics_core::drive::bus_time::Identifier;
use embedded_can::Frame as _;
use std::io::Write as _;

/// Bytes of the longest line: `t`, three digits of the identifier or eight of an extended one, length, 16 digits, `\r`.
#[must_use]
pub const fn line_max(identifier: Identifier) -> u32 {
    match identifier {
        Identifier::Standard => 1 + 3 + 1 + 16 + 1,
        Identifier::Extended => 1 + 8 + 1 + 16 + 1,
    }
}

/// Longest line at all: `T`, eight digits, length, 16 digits, four of a time stamp.
const LINE_LONGEST: usize = 30;

/// State of the reading of slcan lines.
#[derive(Debug, Default)]
pub struct Slcan {
    line: Vec<u8>,
    /// True until the end of a line that was too long.
    skips: bool,
}

impl Protocol for Slcan {
    /// Ends a line that another program left half sent, leaves the bus, and joins it at 1 Mbit/s.
    const BEGIN: &'static [u8] = b"\r\r\rC\rS8\rO\r";

    fn encode(frame: &CanFrame, bytes: &mut Vec<u8>) {
        let (kind, digits) = match (frame.is_extended(), frame.is_remote_frame()) {
            (false, false) => ('t', 3),
            (true, false) => ('T', 8),
            (false, true) => ('r', 3),
            (true, true) => ('R', 8),
        };
        // Writing to memory cannot fail.
        let _ = write!(bytes, "{kind}{:0digits$X}{}", frame.raw_id(), frame.dlc());
        for byte in frame.data() {
            let _ = write!(bytes, "{byte:02X}");
        }
        bytes.push(b'\r');
    }

    fn push(&mut self, byte: u8) -> Parsed {
        match byte {
            7 => {
                self.line.clear();
                Parsed::Error
            }
            b'\r' => {
                let skipped = core::mem::take(&mut self.skips);
                let line = core::mem::take(&mut self.line);
                if skipped { Parsed::Error } else { parsed(&line) }
            }
            _ if self.skips => Parsed::Nothing,
            _ if self.line.len() >= LINE_LONGEST => {
                self.line.clear();
                self.skips = true;
                Parsed::Nothing
            }
            _ => {
                self.line.push(byte);
                Parsed::Nothing
            }
        }
    }
}

fn parsed(line: &[u8]) -> Parsed {
    let Some((&kind, rest)) = line.split_first() else { return Parsed::Nothing };
    let (digits, remote) = match kind {
        b't' => (3, false),
        b'T' => (8, false),
        b'r' => (3, true),
        b'R' => (8, true),
        // Answers to commands and to sent frames.
        b'z' | b'Z' | b'F' | b'V' | b'N' | b'v' => return Parsed::Nothing,
        _ => return Parsed::Error,
    };
    data_frame(rest, digits, remote).map_or(Parsed::Error, Parsed::Frame)
}

/// A frame from its digits.
fn data_frame(rest: &[u8], digits: usize, remote: bool) -> Option<CanFrame> {
    let text = str::from_utf8(rest).ok().filter(|text| text.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
    let raw = u32::from_str_radix(text.get(..digits)?, 16).ok()?;
    let length = usize::from_str_radix(text.get(digits..digits + 1)?, 16).ok().filter(|&length| length <= 8)?;
    let id = super::frame::id(raw, digits == 8)?;
    let tail = text.get(digits + 1..)?;
    if remote {
        return CanFrame::new_remote(id, length);
    }
    // Nothing, or a time stamp, follows the bytes.
    if ![2 * length, 2 * length + 4].contains(&tail.len()) {
        return None;
    }
    let mut bytes = [0; 8];
    for (at, byte) in bytes.iter_mut().enumerate().take(length) {
        *byte = u8::from_str_radix(tail.get(2 * at..2 * at + 2)?, 16).ok()?;
    }
    CanFrame::new(id, bytes.get(..length)?)
}

#[cfg(test)]
mod tests;
