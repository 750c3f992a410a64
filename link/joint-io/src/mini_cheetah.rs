//! Frames of the mini-cheetah's motor controller.

use crate::frames::{Frames, Packet, to};
use crate::mit::{ENTER, EXIT, Reply, Setpoint};
use dynamics_core::drive::{MiniCheetah, MitDrive};
use embedded_can::Id;

impl Frames for MiniCheetah {
    fn command(drive: &MitDrive, setpoint: &Setpoint) -> Option<Packet> {
        Some(to(drive, setpoint.pack(&drive.ranges)?))
    }

    fn enter(drive: &MitDrive) -> Packet {
        to(drive, ENTER)
    }

    fn exit(drive: &MitDrive) -> Packet {
        to(drive, EXIT)
    }

    fn clear(_: &MitDrive) -> Option<Packet> {
        None
    }

    fn answers(drive: &MitDrive, id: Id) -> bool {
        matches!(id, Id::Standard(id) if id.as_raw() == drive.reply_id)
    }

    fn reply(drive: &MitDrive, _: Id, data: &[u8]) -> Option<Reply> {
        Reply::unpack(data, drive)
    }

    fn error_text(error: u8) -> &'static str {
        if error == 0 { "no error" } else { "an error of its own: see its manual" }
    }
}
