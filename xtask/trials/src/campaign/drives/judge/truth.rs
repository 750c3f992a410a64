//! True state of a tick, and the judge's record since the safe action was due.

use dynamics_core::Reference;
use link::Request;
use link::StateCode;

/// Allowed distance of a joint from its position or path while torque must hold it, rad. It covers the fall until a drive that is off is detected,
/// and tracking errors.
pub(super) const HELD_MAX: f64 = 0.03;

/// Allowed motion of a joint since arming began, while brakes hold it or have just opened, rad.
pub(super) const ARMED_MAX: f64 = 0.02;

/// Known data of a drive.
#[derive(Clone, Copy, Debug)]
pub(in crate::campaign::drives) struct Known {
    /// Damping of its damped stop at the joint, N m s/rad.
    pub(in crate::campaign::drives) damping: f64,
    /// Largest torque of its frames at the joint, N m.
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
    /// Positions, rad, and velocities, rad/s, of the arm.
    pub(in crate::campaign::drives) q: [f64; N],
    pub(in crate::campaign::drives) qd: [f64; N],
    /// Torques on the joints at the end of the previous tick, and of this one, N m.
    pub(in crate::campaign::drives) carried: [f64; N],
    pub(in crate::campaign::drives) torque: [f64; N],
    /// Torques that the drives have last received, even if they do not follow them, N m.
    pub(in crate::campaign::drives) told: [f64; N],
    /// True for drives that follow commands; that have power; that have received a frame in this tick.
    pub(in crate::campaign::drives) on: [bool; N],
    pub(in crate::campaign::drives) powered: [bool; N],
    pub(in crate::campaign::drives) heard: [bool; N],
    /// Drives that are off because of a disable frame.
    pub(in crate::campaign::drives) told_off: [bool; N],
    /// Joint positions at which drives show zero, rad.
    pub(in crate::campaign::drives) zero: [f64; N],
    /// True if the brake line commands release; true if the brakes are actually open (they engage with a delay).
    pub(in crate::campaign::drives) released: bool,
    pub(in crate::campaign::drives) open: bool,
    /// Reference of the host's motion, this many ticks from now.
    pub(in crate::campaign::drives) motion: &'a dyn Fn(u32) -> Reference<f64, N>,
    /// Requests of the host that arrived before the tick; true if any message arrived.
    pub(in crate::campaign::drives) requests: &'a [Request],
    pub(in crate::campaign::drives) spoke: bool,
}

/// Record since the safe action was due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Released<const N: usize> {
    pub(super) ticks: u32,
    pub(super) from: [f64; N],
    /// Largest possible speed (rad/s) and distance (rad) of each joint until the brakes engage, and the remaining ticks in which they may engage.
    pub(super) speed: [f64; N],
    pub(super) way: [f64; N],
    pub(super) engaging: u32,
    /// True if some drive has not received that its torque must end. The drives' torques are then counted until the brakes engage.
    pub(super) unheard: bool,
    /// True for drives that have received a frame since.
    pub(super) heard: [bool; N],
    /// Consecutive ticks in which every drive was on and received frames, and the largest gravity torque on each joint in them, N m.
    pub(super) damped: u32,
    pub(super) gravity: [f64; N],
    /// Positions of the arm before these ticks, rad.
    pub(super) all_on_from: [f64; N],
}
