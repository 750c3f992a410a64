//! Kinds of frames: commands of an actuator on CAN, and its replies.

use crate::mit::{Reply, Setpoint};
use dynamics_core::drive::{DriveKind, MitDrive, Protocol};
use embedded_can::{Id, StandardId};

/// A command: its identifier and its eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet {
    /// The identifier.
    pub id: Id,
    /// The data.
    pub data: [u8; 8],
}

/// Answer of a drive to a request about one of its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Its own communication timeout, in units of [`dynamics_core::drive::TIMEOUT_UNIT_US`]; 0 where it has none.
    Timeout(u32),
    /// Another setting, which somebody else asked for, or a request that the drive rejected.
    Other,
}

/// The frames that a kind of actuator understands.
///
/// Total, as everything here: a NaN makes no frame, and no reply that could be misread is taken.
pub trait Frames: DriveKind {
    /// True if identifiers of commands depend on what is commanded, so that the order of sending changes from tick to tick.
    const COMMAND_IN_IDENTIFIER: bool = false;

    /// Position, velocity, stiffness, damping and torque; values beyond their range take its end. `None` when one is NaN.
    fn command(drive: &MitDrive, setpoint: &Setpoint) -> Option<Packet>;

    /// Switch on.
    fn enter(drive: &MitDrive) -> Packet;

    /// Switch off.
    fn exit(drive: &MitDrive) -> Packet;

    /// Forget an error, which leaves the drive off; `None` for drives that have no such frame.
    fn clear(drive: &MitDrive) -> Option<Packet>;

    /// Asks for the drive's own communication timeout; `None` where its protocol has no such frame.
    fn read_timeout(drive: &MitDrive) -> Option<Packet> {
        let _ = drive;
        None
    }

    /// Sets the drive's own communication timeout to [`MitDrive::timeout`], until its power is off.
    fn write_timeout(drive: &MitDrive) -> Option<Packet> {
        let _ = drive;
        None
    }

    /// Answer to a request about a setting; `None` for any other frame. Such a frame is never a [`Frames::reply`].
    fn setting(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Setting> {
        let _ = (drive, id, data);
        None
    }

    /// True if a frame with this identifier may be a reply of this drive.
    fn answers(drive: &MitDrive, id: Id) -> bool;

    /// A reply; `None` for a frame of another length, kind or drive.
    fn reply(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Reply>;

    /// The drive's text for an error of [`Reply::error`], for a person.
    fn error_text(error: u8) -> &'static str;
}

macro_rules! error_text_of {
    ($($kind:ident)*) => {
        /// [`Frames::error_text`] of a kind of drive.
        #[must_use]
        pub const fn error_text(protocol: Protocol) -> fn(u8) -> &'static str {
            match protocol {
                $(Protocol::$kind => <dynamics_core::drive::$kind as Frames>::error_text,)*
            }
        }
    };
}

dynamics_core::with_drive_kinds!(error_text_of);

/// A command with the identifier of the drive; a byte is always a standard identifier.
pub(crate) fn to(drive: &MitDrive, data: [u8; 8]) -> Packet {
    Packet { id: StandardId::new(u16::from(drive.id)).unwrap_or(StandardId::MAX).into(), data }
}
