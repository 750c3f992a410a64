//! Interface to the frames of an actuator on CAN: commands and replies.

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
    /// The drive's communication timeout, in units of [`dynamics_core::drive::TIMEOUT_UNIT_US`]; 0 for none.
    Timeout(u32),
    /// Another setting, which another device requested, or a rejected request.
    Other,
}

/// Frame of a drive that is neither a reply to a command nor an answer about a setting ([`Frames::NOTICES`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The drive has carried out [`Frames::enter`].
    On,
    /// The drive has carried out [`Frames::exit`].
    Off,
    /// The drive's error code, as in [`Reply::error`]; 0 without an error. An answer, or sent by a drive with an error.
    Status(u8),
}

/// The frames that a kind of actuator understands.
///
/// All functions are total: NaN is never sent, and a reply that could be misread is not accepted.
pub trait Frames: DriveKind {
    /// True if the identifier of a command depends on its values, so that the order of sending changes from tick to tick.
    const COMMAND_IN_IDENTIFIER: bool = false;

    /// True if only a command gets a reply, and a [`Notice`] answers the frames that switch the drive on and off and that read its status. Then
    /// replies carry no error, and [`Frames::request_status`] returns a frame.
    const NOTICES: bool = false;

    /// Returns the frame with position, velocity, stiffness, damping and torque; values beyond their range are clamped. `None` if one is NaN.
    fn command(drive: &MitDrive, setpoint: &Setpoint) -> Option<Packet>;

    /// Returns the frame that switches the drive on.
    fn enter(drive: &MitDrive) -> Packet;

    /// Returns the frame that switches the drive off.
    fn exit(drive: &MitDrive) -> Packet;

    /// Returns the frame that clears an error and leaves the drive off; `None` for drives without such a frame.
    fn clear(drive: &MitDrive) -> Option<Packet>;

    /// Returns the frame that reads the drive's communication timeout; `None` if its protocol has no such frame.
    fn read_timeout(drive: &MitDrive) -> Option<Packet> {
        let _ = drive;
        None
    }

    /// Returns the frame that sets the drive's communication timeout to [`MitDrive::timeout`] until power-off; `None` if there is no such frame.
    fn write_timeout(drive: &MitDrive) -> Option<Packet> {
        let _ = drive;
        None
    }

    /// Returns the frame that reads the drive's error, which a [`Notice::Status`] answers; `None` if replies carry the error.
    fn request_status(drive: &MitDrive) -> Option<Packet> {
        let _ = drive;
        None
    }

    /// Reads a notice; `None` for any other frame. A notice is never a [`Frames::reply`].
    fn notice(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Notice> {
        let _ = (drive, id, data);
        None
    }

    /// Returns the identifier of the drive to which a frame with this identifier is sent. Belongs to no drive if all drives receive the frame.
    fn receiver(id: Id) -> u32 {
        match id {
            Id::Standard(id) => u32::from(id.as_raw()),
            Id::Extended(id) => id.as_raw() & 0xff,
        }
    }

    /// Reads an answer about a setting; `None` for any other frame. An answer is never a [`Frames::reply`].
    fn setting(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Setting> {
        let _ = (drive, id, data);
        None
    }

    /// True if a frame with this identifier may be a reply of this drive.
    fn answers(drive: &MitDrive, id: Id) -> bool;

    /// Reads a reply; `None` for a frame of another length, kind or drive.
    fn reply(drive: &MitDrive, id: Id, data: &[u8]) -> Option<Reply>;

    /// Returns the text of an error code of [`Reply::error`], for users.
    fn error_text(error: u8) -> &'static str;
}

macro_rules! error_text_of {
    ($($kind:ident)*) => {
        /// Returns [`Frames::error_text`] of a kind of drive.
        #[must_use]
        pub const fn error_text(protocol: Protocol) -> fn(u8) -> &'static str {
            match protocol {
                $(Protocol::$kind => <dynamics_core::drive::$kind as Frames>::error_text,)*
            }
        }
    };
}

dynamics_core::with_drive_kinds!(error_text_of);

/// A command with the drive's identifier. A byte is always a valid standard identifier.
pub(crate) fn to(drive: &MitDrive, data: [u8; 8]) -> Packet {
    Packet { id: StandardId::new(u16::from(drive.id)).unwrap_or(StandardId::MAX).into(), data }
}
