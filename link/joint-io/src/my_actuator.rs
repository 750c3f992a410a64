//! Frames of MyActuator's RMD drives in motion mode ("Servo Motor Control Protocol" V4.2, "CAN BUS Motor Motion Protocol" V4.4).
//!
//! **The ranges of the frames depend on the drive's firmware.** Up to protocol V4.2 the torque range is +-24 N m for every model. From firmware
//! 2026042402 on it is the model's highest torque: with the wrong one an X6-60 gives 2.5 times the commanded torque, and no frame shows that.
//!
//! Identifiers are standard ones. Every frame has eight bytes:
//!
//! | identifier | frame | data |
//! |---|---|---|
//! | 0x400 + id | command | that of the mini-cheetah ([`crate::mit`]) |
//! | 0x500 + id | its reply | id, position, velocity and torque as in the mini-cheetah's six bytes, 0, 0 |
//! | 0x140 + id | on: release the holding brake | 0x77, seven zeros |
//! | 0x140 + id | off: shut down | 0x80, seven zeros |
//! | 0x140 + id | read the status | 0x9A, seven zeros |
//! | 0x240 + id | the answer to on and off | the same data |
//! | 0x240 + id | the status: an answer, or sent by a drive with an error | 0x9A, temperatures (8, 8), brake released (8), voltage (16), errors (16) |
//! | 0x240 + id | its communication timeout (0xB3) has expired | 0xF1 first |
//!
//! Numbers of the status have their low byte first. Only a reply to a command has the drive's state. It has no error, no temperature, and does not
//! show whether the drive is on. Frames of other identifiers and other data with 0x240 + id are no replies.
//!
//! **Whether the torque of a reply is measured is not certain.** V4.4 calls it the current torque; V4.2 calls the same field `t_ff`, as in the command.
//! If a drive echoes the command, neither the probe nor the check of missing torque shows anything.
//!
//! **There is no frame that enables the drive**: a command acts on a drive that was never switched on, also after the frame that switches it off
//! (almond-bot/axol, `myactuator.py`; yukunlin1124/myactuator_rmd_v4.3). The release of a holding brake takes 50 to 150 ms (axol); its answer
//! arrives after that. The lock (0x78) is never sent. The drive counts as on after that answer, a status without an error, and a reply with the torque of a probe.
//!
//! A drive sends its status by itself, every 100 ms while it has an error, only if its function 3 of 0x20 is set. The documents do not say whether
//! a drive keeps that setting without power. It is not set here: it may be a write to the drive's ROM, and such a write in each arming would wear
//! it out.

use crate::frames::{Frames, Notice, Packet};
use crate::mit::{Reply, Setpoint};
use dynamics_core::drive::{MitDrive, MyActuator};
use embedded_can::{Id, StandardId};

/// Identifiers minus the drive's own: of commands and their replies, of all other requests, and of the answers to these.
const COMMANDS: u16 = 0x400;
const REPLIES: u16 = 0x500;
const REQUESTS: u16 = 0x140;
const ANSWERS: u16 = 0x240;

/// First bytes of requests and answers.
const RELEASE: u8 = 0x77;
const SHUT_DOWN: u8 = 0x80;
const STATUS: u8 = 0x9a;
/// First byte of the frame that reports an expired communication timeout.
const EXPIRED: u8 = 0xf1;

/// Error code for an expired communication timeout: above those of the status, which are the number of a bit plus one.
const SILENCE: u8 = 17;

/// A frame to the drive. The identifier is valid for any drive identifier of eight bits.
fn to(base: u16, drive: &MitDrive, data: [u8; 8]) -> Packet {
    Packet { id: StandardId::new(base + u16::from(drive.id)).unwrap_or(StandardId::MAX).into(), data }
}

fn request(drive: &MitDrive, what: u8) -> Packet {
    to(REQUESTS, drive, [what, 0, 0, 0, 0, 0, 0, 0])
}

fn is_from(base: u16, drive: &MitDrive, id: Id) -> bool {
    matches!(id, Id::Standard(id) if id.as_raw() == base + u16::from(drive.id))
}

impl Frames for MyActuator {
    const COMMAND_IN_IDENTIFIER: bool = true;
    const NOTICES: bool = true;

    fn command(drive: &MitDrive, setpoint: &Setpoint) -> Option<Packet> {
        Some(to(COMMANDS, drive, setpoint.pack(&drive.ranges)?))
    }

    fn enter(drive: &MitDrive) -> Packet {
        request(drive, RELEASE)
    }

    fn exit(drive: &MitDrive) -> Packet {
        request(drive, SHUT_DOWN)
    }

    fn clear(_: &MitDrive) -> Option<Packet> {
        None
    }

    fn request_status(drive: &MitDrive) -> Option<Packet> {
        Some(request(drive, STATUS))
    }

    fn notice(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Notice> {
        let &[what, _, _, _, _, _, low, high] = data else { return None };
        if !is_from(ANSWERS, drive, id) {
            return None;
        }
        match what {
            RELEASE => Some(Notice::On),
            SHUT_DOWN => Some(Notice::Off),
            // The number of the lowest bit plus one: 1 to 16, or 0 without an error.
            STATUS => Some(Notice::Status(match u16::from_le_bytes([low, high]) {
                0 => 0,
                errors => errors.trailing_zeros() as u8 + 1,
            })),
            EXPIRED => Some(Notice::Status(SILENCE)),
            _ => None,
        }
    }

    fn receiver(id: Id) -> u32 {
        let Id::Standard(id) = id else { return u32::MAX };
        let id = id.as_raw();
        let base = if id >= COMMANDS { COMMANDS } else { REQUESTS };
        id.checked_sub(base).map_or(u32::MAX, u32::from)
    }

    fn answers(drive: &MitDrive, id: Id) -> bool {
        is_from(REPLIES, drive, id) || is_from(ANSWERS, drive, id)
    }

    fn reply(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Reply> {
        let &[own, p_high, p_low, v, vt, t, 0, 0] = data else { return None };
        if own != drive.id || !is_from(REPLIES, drive, id) {
            return None;
        }
        Some(Reply::of_state([p_high, p_low, v, vt, t], &drive.ranges))
    }

    /// Text of the error in the lowest bit, if there are several.
    fn error_text(error: u8) -> &'static str {
        match error {
            0 => "no error",
            2 => "stalled: it works again only after a restart",
            3 => "supply voltage too low",
            4 => "supply voltage too high",
            5 => "too much current: it works again only after a restart",
            7 => "too much power",
            8 => "calibration parameters wrong: it works again only after a restart",
            9 => "too fast",
            12 => "components too hot",
            13 => "motor too hot",
            14 => "encoder not calibrated",
            15 => "its encoder fails: it works again only after a restart",
            SILENCE => "commands stayed out",
            _ => "an error that its manual does not name",
        }
    }
}
