//! Frames of Damiao's motors (DM4310, DM4340 and kin; "DM-J4310-2EC reduction motor manual", MIT mode).
//!
//! Commands are the mini-cheetah's ([`crate::mit`]), with one more special frame, which clears an error. A reply has eight bytes:
//!
//! | field | bits |
//! |---|---|
//! | state: 0 off, 1 on, from 8 an error | 4 |
//! | the motor's identifier, its low half | 4 |
//! | position, velocity, torque | 16, 12, 12 |
//! | temperature of the transistors, of the winding, degrees Celsius | 8, 8 |

use crate::frames::{Frames, Packet};
use crate::mit::{Reply, Setpoint, to};
use dynamics_core::drive::{Damiao, MiniCheetah, MitDrive};
use embedded_can::Id;

/// Forget the error.
pub const CLEAR: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfb];

/// State of a motor that is off.
const OFF: u8 = 0;

/// Lowest state that is an error.
const ERRORS: u8 = 8;

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
            error: if state >= ERRORS { state } else { 0 },
            off: state == OFF,
            ..Reply::of_state([p_high, p_low, v, vt, t], &drive.ranges)
        })
    }

    fn words(error: u8) -> &'static str {
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
