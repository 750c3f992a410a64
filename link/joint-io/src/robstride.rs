//! Frames of RobStride's private protocol (RS00 to RS06 instruction manuals, "communication protocol").
//!
//! Every frame has an extended identifier of 29 bits and eight bytes, most significant first:
//!
//! | bits | 28 to 24 | 23 to 8 | 7 to 0 | data |
//! |---|---|---|---|---|
//! | command | 1 | torque | motor | position, velocity, kp, kd: 16 bits each |
//! | reply | 2 | state (23, 22), errors (21 to 16), motor (15 to 8) | host | position, velocity, torque, 0.1 degrees Celsius |
//! | on | 3 | host | motor | zero |
//! | off | 4 | host | motor | first byte 1: clear the errors |
//! | read a parameter | 17 | host | motor | index in two bytes, low byte first |
//! | its answer | 17 | 0, or 1 if it failed (23 to 16); motor (15 to 8) | host | index, 0, 0, value in four bytes, low byte first |
//! | write a parameter | 18 | host | motor | as that answer; the motor sends a reply |
//!
//! State 0 is off, 1 calibrating, 2 on.
//!
//! Parameter 0x7028 is the communication timeout in units of 50 us ("20000 = 1 s"). 0 means none and is the maker's setting. A motor that
//! receives nothing for this time switches off. A written value is lost at power-off.
//!
//! The answer to a request for the version has the identifier of a reply and begins with 00 C4 56. Read as a reply, it would report a position
//! 0.08 rad above the low end of the range. No joint may be there, so it is never taken as a reply.

use crate::frames::{Frames, Packet, Setting};
use crate::mit::{Reply, Setpoint};
use dynamics_core::drive::{MitDrive, RobStride};
use embedded_can::{ExtendedId, Id};

/// Bits of every field.
const BITS: u32 = 16;

/// Kinds of frames.
const COMMAND: u32 = 1;
const REPLY: u32 = 2;
const ON: u32 = 3;
const OFF: u32 = 4;
const READ: u32 = 17;
const WRITE: u32 = 18;

/// Index of the communication timeout, low byte first.
const TIMEOUT: [u8; 2] = [0x28, 0x70];

/// Beginning of the answer to a request for the version.
const VERSION: [u8; 3] = [0x00, 0xc4, 0x56];

/// State of a motor that is on.
const RUNNING: u32 = 2;

/// The identifier of a frame to a drive; all parts together have 29 bits.
fn to(kind: u32, middle: u16, drive: &MitDrive, data: [u8; 8]) -> Packet {
    let id = kind << 24 | u32::from(middle) << 8 | u32::from(drive.id);
    Packet { id: ExtendedId::new(id).unwrap_or(ExtendedId::MAX).into(), data }
}

/// Errors in bits 21 to 16 of an identifier.
fn errors(id: u32) -> u8 {
    (id >> 16 & 0x3f) as u8
}

impl Frames for RobStride {
    const COMMAND_IN_IDENTIFIER: bool = true;

    fn command(drive: &MitDrive, setpoint: &Setpoint) -> Option<Packet> {
        let ranges = &drive.ranges;
        let [a, b] = ranges.position.code(setpoint.position, BITS)?.to_be_bytes();
        let [c, d] = ranges.velocity.code(setpoint.velocity, BITS)?.to_be_bytes();
        let [e, f] = ranges.kp.code(setpoint.kp, BITS)?.to_be_bytes();
        let [g, h] = ranges.kd.code(setpoint.kd, BITS)?.to_be_bytes();
        let torque = ranges.torque.code(setpoint.torque, BITS)?;
        Some(to(COMMAND, torque, drive, [a, b, c, d, e, f, g, h]))
    }

    fn enter(drive: &MitDrive) -> Packet {
        to(ON, drive.reply_id, drive, [0; 8])
    }

    fn exit(drive: &MitDrive) -> Packet {
        to(OFF, drive.reply_id, drive, [0; 8])
    }

    fn clear(drive: &MitDrive) -> Option<Packet> {
        Some(to(OFF, drive.reply_id, drive, [1, 0, 0, 0, 0, 0, 0, 0]))
    }

    fn answers(drive: &MitDrive, id: Id) -> bool {
        let Id::Extended(id) = id else { return false };
        let id = id.as_raw();
        matches!(id >> 24, REPLY | READ)
            && id >> 8 & 0xff == u32::from(drive.id)
            && id & 0xff == u32::from(drive.reply_id)
    }

    fn read_timeout(drive: &MitDrive) -> Option<Packet> {
        let [low, high] = TIMEOUT;
        Some(to(READ, drive.reply_id, drive, [low, high, 0, 0, 0, 0, 0, 0]))
    }

    fn write_timeout(drive: &MitDrive) -> Option<Packet> {
        let ([low, high], [a, b, c, d]) = (TIMEOUT, drive.timeout.to_le_bytes());
        Some(to(WRITE, drive.reply_id, drive, [low, high, 0, 0, a, b, c, d]))
    }

    fn setting(_: &MitDrive, id: Id, data: &[u8]) -> Option<Setting> {
        let Id::Extended(id) = id else { return None };
        if id.as_raw() >> 24 != READ {
            return None;
        }
        let &[low, high, 0, 0, a, b, c, d] = data else { return Some(Setting::Other) };
        let failed = id.as_raw() >> 16 & 0xff != 0;
        Some(if [low, high] == TIMEOUT && !failed {
            Setting::Timeout(u32::from_le_bytes([a, b, c, d]))
        } else {
            Setting::Other
        })
    }

    fn reply(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Reply> {
        let Id::Extended(id) = id else { return None };
        let &[a, b, c, d, e, f, g, h] = data else { return None };
        if id.as_raw() >> 24 != REPLY || [a, b, c] == VERSION {
            return None;
        }
        let position = u16::from_be_bytes([a, b]);
        let ranges = &drive.ranges;
        Some(Reply {
            position: ranges.position.value(position, BITS),
            velocity: ranges.velocity.value(u16::from_be_bytes([c, d]), BITS),
            torque: ranges.torque.value(u16::from_be_bytes([e, f]), BITS),
            saturated: position == 0 || position == u16::MAX,
            temperature: Some(0.1 * f32::from(u16::from_be_bytes([g, h]))),
            error: errors(id.as_raw()),
            off: id.as_raw() >> 22 & 0b11 != RUNNING,
        })
    }

    /// Text of the error in the lowest bit, if there are several.
    fn error_text(error: u8) -> &'static str {
        match error {
            0 => "no error",
            e if e & 1 << 0 != 0 => "supply voltage too low",
            e if e & 1 << 1 != 0 => "too much current",
            e if e & 1 << 2 != 0 => "too hot",
            e if e & 1 << 3 != 0 => "its encoder fails",
            e if e & 1 << 4 != 0 => "overloaded, or its Hall sensor fails",
            e if e & 1 << 5 != 0 => "not calibrated",
            _ => "an error that its manual does not name",
        }
    }
}
