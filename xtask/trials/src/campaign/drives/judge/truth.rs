//! The judge's view of a tick, and its memory since the safe action was due.

use dynamics_core::Reference;
use link::Request;
use link::StateCode;

/// Distance of a joint from its place or path while torque is to hold it, rad: what it may fall until its drive is found off, and the errors
/// of following.
pub(super) const HELD_MAX: f64 = 0.03;

/// Motion of a joint from the beginning of arming on, while brakes hold it or have just opened, rad.
pub(super) const ARMED_MAX: f64 = 0.02;

/// A drive, as its owner knows it.
#[derive(Clone, Copy, Debug)]
pub(in crate::campaign::drives) struct Known {
    /// Damping of its damped stop at the joint, N m s/rad.
    pub(in crate::campaign::drives) damping: f64,
    /// Highest torque of its frames at the joint, N m.
    pub(in crate::campaign::drives) torque: f64,
    /// Viscous, N m s/rad, and Coulomb friction of the joint, N m.
    pub(in crate::campaign::drives) friction: (f64, f64),
}

impl Known {
    /// Friction torque at this speed, N m.
    pub(super) fn friction_torque(&self, qd: f64) -> f64 {
        let (viscous, coulomb) = self.friction;
        viscous * qd + coulomb * qd.signum()
    }
}

/// True state of the arm and its drives after a tick.
pub(in crate::campaign::drives) struct Truth<'a, const N: usize> {
    /// State, cause and homing that the board has announced.
    pub(in crate::campaign::drives) state: (StateCode, u8),
    pub(in crate::campaign::drives) homed: bool,
    /// The arm.
    pub(in crate::campaign::drives) q: [f64; N],
    pub(in crate::campaign::drives) qd: [f64; N],
    /// Torques on the joints at the end of the tick before, and of this one, N m.
    pub(in crate::campaign::drives) carried: [f64; N],
    pub(in crate::campaign::drives) torque: [f64; N],
    /// Torques that the drives have heard last, whether they give them or not, N m.
    pub(in crate::campaign::drives) told: [f64; N],
    /// Drives that follow commands, that have power, that have heard a frame in this tick.
    pub(in crate::campaign::drives) on: [bool; N],
    pub(in crate::campaign::drives) powered: [bool; N],
    pub(in crate::campaign::drives) heard: [bool; N],
    /// Drives that are off because of a disable frame.
    pub(in crate::campaign::drives) told_off: [bool; N],
    /// Joint positions at which drives show zero, rad.
    pub(in crate::campaign::drives) zero: [f64; N],
    /// The line to the brakes opens them, and they are open: they engage later.
    pub(in crate::campaign::drives) released: bool,
    pub(in crate::campaign::drives) open: bool,
    /// The host's motion, so many ticks from now.
    pub(in crate::campaign::drives) motion: &'a dyn Fn(u32) -> Reference<f64, N>,
    /// Requests of the host that arrived before the tick, and whether anything did.
    pub(in crate::campaign::drives) requests: &'a [Request],
    pub(in crate::campaign::drives) spoke: bool,
}

/// The time since the safe action was due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Released<const N: usize> {
    pub(super) ticks: u32,
    pub(super) from: [f64; N],
    /// Greatest speed and way of each joint until the brakes engage, and the ticks in which they may yet do so.
    pub(super) speed: [f64; N],
    pub(super) way: [f64; N],
    pub(super) engaging: u32,
    /// Some drive has not heard that its torque is to end: what the drives then give counts until the brakes engage.
    pub(super) unheard: bool,
    /// Drives that have heard a frame since.
    pub(super) heard: [bool; N],
    /// Ticks in which every drive was on and heard the board, one after the other, and the greatest torque of gravity on each joint in them.
    pub(super) damped: u32,
    pub(super) gravity: [f64; N],
    /// Where the arm was before them.
    pub(super) all_on_from: [f64; N],
}
