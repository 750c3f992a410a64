//! Frames of Damiao's motors (DM4310, DM4340 and similar; "DM-J4310-2EC reduction motor manual", MIT mode).
//!
//! Commands are those of the mini-cheetah ([`crate::mit`]), with an additional special frame that clears an error. A reply has eight bytes:
//!
//! | field | bits |
//! |---|---|
//! | state: 0 off, 1 on, from 8 an error | 4 |
//! | low half of the motor's identifier | 4 |
//! | position, velocity, torque | 16, 12, 12 |
//! | temperature of the transistors, of the winding, degrees Celsius | 8, 8 |
//!
//! Settings are registers. A request has the identifier 0x7FF. Its answer has the identifier of the replies and differs from a reply in its data:
//!
//! | byte | request | answer |
//! |---|---|---|
//! | 0, 1 | the motor's identifier, low byte first | the same |
//! | 2 | 0x33 read, 0x55 write, 0xAA store | the same |
//! | 3 | the register | the same |
//! | 4 to 7 | a write's value, low byte first | the value |
//!
//! Read as a reply, such an answer would report a position 0.02, 0.03 or 0.06 rad above the low end of a range of 12.5 rad. No joint may be
//! there, so a frame of this form is never taken as a reply. Register 9 is the communication timeout in units of 50 us, 0 for none. A motor that
//! receives nothing for this time leaves the enabled state with error 0xD. (Sources for the registers: i2rt, `set_timeout.py`, with 8000 for
//! 400 ms, the maker's setting for YAM; almond-bot/axol, `motor/config.py`: "the register counts 50 us ticks".)

use crate::frames::{Frames, Packet, Setting, to};
use crate::mit::{Reply, Setpoint};
use dynamics_core::drive::{Damiao, MiniCheetah, MitDrive};
use embedded_can::{Id, StandardId};

/// Special frame that clears the error.
pub const CLEAR: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfb];

/// States of a motor that is off and of one that is on. Every other state is an error, also if the manual does not name it.
const OFF: u8 = 0;
const ON: u8 = 1;

/// Identifier of requests about registers, codes of the operations, and the register of the communication timeout.
const REGISTERS: StandardId = StandardId::MAX;
const READ: u8 = 0x33;
const WRITE: u8 = 0x55;
const STORE: u8 = 0xaa;
const TIMEOUT: u8 = 9;

/// Request to read or write the communication timeout.
fn timeout(drive: &MitDrive, what: u8, value: u32) -> Packet {
    let [a, b, c, d] = value.to_le_bytes();
    Packet { id: REGISTERS.into(), data: [drive.id, 0, what, TIMEOUT, a, b, c, d] }
}

impl Frames for Damiao {
    fn command(drive: &MitDrive, setpoint: &Setpoint) -> Option<Packet> {
        MiniCheetah::command(drive, setpoint)
    }

    fn enter(drive: &MitDrive) -> Packet {
        MiniCheetah::enter(drive)
    }

    fn exit(drive: &MitDrive) -> Packet {
        MiniCheetah::exit(drive)
    }

    fn clear(drive: &MitDrive) -> Option<Packet> {
        Some(to(drive, CLEAR))
    }

    fn read_timeout(drive: &MitDrive) -> Option<Packet> {
        Some(timeout(drive, READ, 0))
    }

    fn write_timeout(drive: &MitDrive) -> Option<Packet> {
        Some(timeout(drive, WRITE, drive.timeout))
    }

    fn setting(drive: &MitDrive, _: Id, data: &[u8]) -> Option<Setting> {
        let &[id, 0, what, register, a, b, c, d] = data else { return None };
        if id != drive.id || !matches!(what, READ | WRITE | STORE) {
            return None;
        }
        Some(match (what, register) {
            (READ, TIMEOUT) => Setting::Timeout(u32::from_le_bytes([a, b, c, d])),
            _ => Setting::Other,
        })
    }

    fn answers(drive: &MitDrive, id: Id) -> bool {
        MiniCheetah::answers(drive, id)
    }

    fn reply(drive: &MitDrive, _: Id, data: &[u8]) -> Option<Reply> {
        let &[head, p_high, p_low, v, vt, t, transistors, winding] = data else { return None };
        if head & 0xf != drive.id & 0xf {
            return None;
        }
        let state = head >> 4;
        Some(Reply {
            temperature: Some(f32::from(transistors.max(winding))),
            error: if matches!(state, OFF | ON) { 0 } else { state },
            off: state == OFF,
            ..Reply::of_state([p_high, p_low, v, vt, t], &drive.ranges)
        })
    }

    fn error_text(error: u8) -> &'static str {
        match error {
            0x0 => "no error",
            0x8 => "supply voltage too high",
            0x9 => "supply voltage too low",
            0xa => "too much current",
            0xb => "transistors too hot",
            0xc => "winding too hot",
            0xd => "commands stayed out",
            0xe => "overloaded",
            _ => "an error that its manual does not name",
        }
    }
}
