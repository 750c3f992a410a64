//! Damiao's USB-to-CAN adapter.
//!
//! Command, 30 bytes, numbers with the low byte first:
//!
//! | bytes | content |
//! |---|---|
//! | 0 to 3 | `55 AA 1E 03`: head, length, "send" |
//! | 4 to 7, 8 to 11 | how often: 1; interval, in units of 0.1 ms: 10 |
//! | 12, 13 to 16 | 0 for a standard identifier, 1 for an extended one; identifier |
//! | 17, 18 | 0 for a data frame, 1 for a remote one; number of data bytes |
//! | 19, 20 | 0 |
//! | 21 to 28, 29 | data; 0 |
//!
//! Received frame, 16 bytes:
//!
//! | bytes | content |
//! |---|---|
//! | 0, 1 | `AA`; `11` for a received frame; other values are reports about the adapter |
//! | 2 | bits 0 to 5: number of data bytes; bit 6: extended; bit 7: remote |
//! | 3 to 6, 7 to 14, 15 | identifier; data; `55` |
//!
//! Source: the maker's examples for Python (`DM_CAN.py`) and C++ (`SerialPort.h`, `damiao.h`). The adapter starts at 1 Mbit/s. Not tried on hardware.

use super::frame::{BYTES_MAX, CanFrame, id};
use super::serial_adapter::{Parsed, Protocol};
use embedded_can::Frame as _;

/// Bytes of a command.
pub const COMMAND_BYTES: usize = 30;

/// Bytes of a received frame.
pub const RECEIVED_BYTES: usize = 16;

/// State of the reading of received frames.
#[derive(Debug, Default)]
pub struct DamiaoUsb {
    bytes: [u8; RECEIVED_BYTES],
    count: usize,
}

impl Protocol for DamiaoUsb {
    const BEGIN: &'static [u8] = &[];

    fn encode(frame: &CanFrame, bytes: &mut Vec<u8>) {
        bytes.extend([0x55, 0xAA, COMMAND_BYTES as u8, 3, 1, 0, 0, 0, 10, 0, 0, 0, u8::from(frame.is_extended())]);
        bytes.extend(frame.raw_id().to_le_bytes());
        bytes.extend([u8::from(frame.is_remote_frame()), frame.dlc() as u8, 0, 0]);
        bytes.extend(frame.data());
        bytes.extend(core::iter::repeat_n(0, BYTES_MAX - frame.data().len() + 1));
    }

    fn push(&mut self, byte: u8) -> Parsed {
        let Some(place) = self.bytes.get_mut(self.count) else { return Parsed::Error };
        *place = byte;
        self.count += 1;
        if self.bytes[0] != 0xAA {
            self.count = 0;
            return Parsed::Error;
        }
        if self.count < RECEIVED_BYTES {
            return Parsed::Nothing;
        }
        if self.bytes[15] != 0x55 {
            self.resume();
            return Parsed::Error;
        }
        self.count = 0;
        if self.bytes[1] != 0x11 {
            return Parsed::Nothing;
        }
        self.frame().map_or(Parsed::Error, Parsed::Frame)
    }
}

impl DamiaoUsb {
    /// The frame in the full buffer.
    fn frame(&self) -> Option<CanFrame> {
        let [_, _, flags, a, b, c, d, data @ .., _] = &self.bytes;
        let id = id(u32::from_le_bytes([*a, *b, *c, *d]), flags & 0x40 != 0)?;
        let length = usize::from(flags & 0x3F);
        if flags & 0x80 != 0 { CanFrame::new_remote(id, length) } else { CanFrame::new(id, data.get(..length)?) }
    }

    /// Keeps the bytes from the next one on that can begin a frame: the first was none.
    fn resume(&mut self) {
        let next = self.bytes.iter().skip(1).position(|&byte| byte == 0xAA).map_or(RECEIVED_BYTES, |place| place + 1);
        self.bytes.copy_within(next.., 0);
        self.count = RECEIVED_BYTES - next;
    }
}

#[cfg(test)]
mod tests;
