//! Limits of the driver, its counts, and the orders to a drive.

use dynamics_core::control::Spring;

/// Buses, at most.
pub const BUSES: usize = 3;

/// Frames taken from one bus in one tick, at most: [`crate::queued`] and its controller hold eleven, a bxCAN six, and
/// more arrive only while these are read.
pub(super) const RECEIVED_MAX: u32 = 16;

/// Polls of a full transmitter before a command is given up.
pub(super) const TRANSMIT_POLLS: u32 = 16;

/// Most outstanding replies: this tick's and the one before.
pub(super) const OWED_MAX: u8 = 2;

/// Replies in which a drive may give less than half of the torque that it was told, one after the other.
pub const WEAK_MAX: u8 = 5;

/// Torque below which nothing is concluded from a drive's torque, as a share of the range of its frames. Also the torque of a probe.
pub(super) const PROBE_SHARE: f32 = 0.02;

/// Probes of a drive before it is enabled anew.
pub(super) const PROBES: u8 = 4;

/// Replies, each of another tick, that have to show that a drive is on.
pub(super) const SHOWN: u8 = 2;

/// Frames about its communication timeout that a drive may leave without a confirmation.
pub const TIMEOUT_TRIES: u8 = 12;

/// Ticks in which errors of drives are cleared after [`JointIo::clear`].
pub(super) const CLEARING: u8 = 8;

/// Errors of a joint's frames; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JointCounts {
    /// Ticks in which a reply was due and none came.
    pub missing: u16,
    /// Replies that came a tick late.
    pub late: u16,
    /// Replies to no command.
    pub duplicate: u16,
    /// Torques that were NaN or infinite, and were sent as no torque.
    pub refused: u16,
    /// Commands that found no room in the transmitter, or were pushed out of it.
    pub unsent: u16,
}

/// Errors of a bus; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusCounts {
    /// Frames of identifiers that belong to no reply.
    pub foreign: u32,
    /// Replies of another length, from no actuator of ours, or remote requests.
    pub malformed: u32,
    /// Errors of the receiver, such as an overrun.
    pub receive_errors: u32,
    /// Errors of the transmitter.
    pub transmit_errors: u32,
    /// Ticks in which the bus was off.
    pub off: u32,
}

/// Order to a drive in a tick.
#[derive(Clone, Copy)]
pub(super) enum Order {
    /// This torque of the joint, N m or N, and a spring about its last measurement; the drive is enabled first.
    Torque(f32, Option<Spring<f32>>),
    /// Enable the drive; one that is on damps, or gives no torque.
    Enable { damped: bool },
    /// Damp, if the drive is on.
    Damp,
    /// Off.
    Off,
}
