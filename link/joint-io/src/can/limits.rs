//! Limits of the driver, and the orders to a drive.

use dynamics_core::control::Spring;

/// Largest number of buses.
pub const BUSES: usize = 3;

/// Largest number of frames taken from one bus in one tick. [`crate::queued`] and its controller hold 11, a bxCAN 6; more arrive only while these
/// are read.
pub(super) const RECEIVED_MAX: u32 = 16;

/// Number of polls of a full transmitter before a command is dropped.
pub(super) const TRANSMIT_POLLS: u32 = 16;

/// Largest number of outstanding replies: those of this tick and of the previous one.
pub(super) const OWED_MAX: u8 = 2;

/// Largest number of consecutive replies in which a drive may give less than half of the commanded torque.
pub const WEAK_MAX: u8 = 5;

/// Commanded torque below which a drive's torque is not checked, as a share of the range of its frames. Also the torque of a probe.
pub(super) const PROBE_SHARE: f32 = 0.02;

/// Number of probes of a drive before it is enabled again.
pub(super) const PROBES: u8 = 4;

/// Number of ticks with a reply that must show that a drive is on.
pub(super) const SHOWN: u8 = 2;

/// Number of notices of a drive that is switched on, before it gets a probe: that it is on, and a status without an error.
pub(super) const ON_NOTICES: u8 = 2;

/// Number of notices of a drive that is switched off: that it is off, and its status.
pub(super) const OFF_NOTICES: u8 = 2;

/// Time without a notice after which the frame that switches on a drive counts as lost and is sent again, as a multiple of the time in which a drive
/// can restart (10 ms). A MyActuator drive needs up to 150 ms, and arming ends after 1 s.
pub(super) const ENTER_EVERY: u32 = 20;

/// Largest number of frames about its communication timeout before a drive must have confirmed it.
pub const TIMEOUT_TRIES: u8 = 12;

/// Number of ticks in which errors of drives are cleared after [`JointIo::clear`](crate::JointIo::clear).
pub(super) const CLEARING: u8 = 8;

/// Order to a drive in a tick.
#[derive(Clone, Copy)]
pub(super) enum Order {
    /// Apply this torque or force at the joint, N m or N, with a spring about its last measurement. A drive that is not on is enabled first.
    Torque(f32, Option<Spring<f32>>),
    /// Enable the drive. A drive that is on damps (`damped`) or gives no torque.
    Enable { damped: bool },
    /// Damp if the drive is on, otherwise switch off.
    Damp,
    /// Switch off.
    Off,
}
