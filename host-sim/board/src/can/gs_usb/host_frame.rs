//! Frames, echoes and errors as the bytes of a transfer (`gs_host_frame`), numbers with the low byte first.
//!
//! | bytes | content |
//! |---|---|
//! | 0 to 3 | number of the echo; all bits set for what the adapter received |
//! | 4 to 7 | identifier; bit 31 extended, bit 30 remote, bit 29 error |
//! | 8, 9 | number of data bytes; channel |
//! | 10, 11 | flags: bit 0 frames were lost in the adapter, bit 1 CAN FD; 0 |
//! | 12 to 19 | data |
//! | 20 to 23 | time stamp, if the channel was started with it; ignored |

use super::super::frame::{CanFrame, id};
use embedded_can::Frame as _;

/// Bytes of a frame.
pub(super) const FRAME_BYTES: usize = 20;

/// Number of the echo in what the adapter received.
const RECEIVED: u32 = u32::MAX;

const EXTENDED: u32 = 1 << 31;
const REMOTE: u32 = 1 << 30;
const ERROR: u32 = 1 << 29;

/// Class of an error frame (`linux/can/error.h`): the controller has left the bus.
const BUS_OFF: u32 = 0x40;

const OVERFLOW: u8 = 1;
const FD: u8 = 1 << 1;

/// Content of a transfer from the adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// The frame with this number has left the adapter's queue.
    Echo(u32),
    /// A frame was received.
    Frame(CanFrame),
    /// The controller has left the bus.
    BusOff,
    /// Something that this program needs not: another error or state of the controller, another channel, no bytes.
    Nothing,
    /// Bytes that are no classic frame.
    Unreadable,
}

/// Appends the bytes of a frame.
pub(super) fn encode(frame: &CanFrame, echo: u32, channel: u8, bytes: &mut Vec<u8>) {
    let flag = |is_set, flag| if is_set { flag } else { 0 };
    let kind = flag(frame.is_extended(), EXTENDED) | flag(frame.is_remote_frame(), REMOTE);
    bytes.extend(echo.to_le_bytes());
    bytes.extend((frame.raw_id() | kind).to_le_bytes());
    bytes.extend([frame.dlc() as u8, channel, 0, 0]);
    let mut data = [0; 8];
    data.iter_mut().zip(frame.data()).for_each(|(place, &byte)| *place = byte);
    bytes.extend(data);
}

/// Reads a transfer: its content, and true if the adapter has lost frames before it.
pub(super) fn decode(bytes: &[u8], channel: u8) -> (Content, bool) {
    let Some(head) = bytes.first_chunk::<FRAME_BYTES>() else {
        // A transfer without bytes only ends another one.
        return (if bytes.is_empty() { Content::Nothing } else { Content::Unreadable }, false);
    };
    let [e0, e1, e2, e3, i0, i1, i2, i3, length, its_channel, flags, _, data @ ..] = *head;
    if its_channel != channel {
        return (Content::Nothing, false);
    }
    let (echo, raw) = (u32::from_le_bytes([e0, e1, e2, e3]), u32::from_le_bytes([i0, i1, i2, i3]));
    let content = match echo {
        RECEIVED if raw & ERROR != 0 && raw & BUS_OFF != 0 => Content::BusOff,
        RECEIVED if raw & ERROR != 0 => Content::Nothing,
        RECEIVED if flags & FD != 0 => Content::Unreadable,
        RECEIVED => received(raw, length, &data).map_or(Content::Unreadable, Content::Frame),
        _ => Content::Echo(echo),
    };
    (content, flags & OVERFLOW != 0)
}

fn received(raw: u32, length: u8, data: &[u8; 8]) -> Option<CanFrame> {
    let id = id(raw & !(EXTENDED | REMOTE), raw & EXTENDED != 0)?;
    let length = usize::from(length);
    if raw & REMOTE != 0 { CanFrame::new_remote(id, length) } else { CanFrame::new(id, data.get(..length)?) }
}
