//! Drivers of the joints that depend on no chip. The board uses them with its CAN controllers and pins, the desk with simulated drives, and the
//! tests with models of the devices on the wire.
//!
//! | module | holds |
//! |---|---|
//! | [`frames`] | interface to the commands and replies of an actuator on CAN, for any maker |
//! | [`mit`] | packing of commands and replies of MIT-mode actuators |
//! | [`mini_cheetah`], [`damiao`], [`robstride`], [`my_actuator`] | the frames of four kinds of actuators |
//! | [`bus_time`] | time that frames need on a CAN bus, and the highest rate of a schedule; re-exported from `dynamics-core` |
//! | [`can_bus`] | interface to a CAN bus for the schedule of commands |
//! | [`can`] | actuators on up to three CAN buses: the schedule of commands, and the checks of replies |
//! | [`queued`] | queues for a CAN controller that holds fewer frames than a tick has |
//! | [`as5047p`] | the AS5047P magnetic encoder: words, errors, count of turns |
//! | [`run_tick`] | the order of a tick: measurement, session, outputs, and then the check for an overrun |
//! | [`pwm`] | torque to duty cycle: H-bridges with encoders |
//!
//! Every function here is total: input from a wire becomes a value, a count or a fault bit of a joint, and never causes a panic. No loop waits
//! for hardware without a bound.
#![no_std]
#![forbid(unsafe_code)]

pub mod as5047p;
pub mod can;
pub mod can_bus;
pub mod damiao;
pub mod frames;
pub mod mini_cheetah;
pub mod mit;
pub mod my_actuator;
pub mod pwm;
pub mod queued;
pub mod robstride;
mod tick;

pub use tick::run_tick;

use core::convert::Infallible;
use dynamics_core::control::Spring;
pub use dynamics_core::drive::bus_time;
use dynamics_core::safety::SafeAction;
use embedded_hal::digital::{ErrorType, OutputPin};
use session::readings::Readings;

/// Largest age of a joint's measurement, ticks. A joint with an older one is at fault ([`session::readings::JointFaults::MISSING`]).
///
/// The measurement ages by one tick in each tick without a new one. If the controller's own limit (`age_max` of the scene) is lower, that acts
/// first.
pub const MISSING_MAX: u32 = 3;

/// Interface between the tick and the joints. Each tick calls [`JointIo::measure`] once, and then one of [`JointIo::drive`], [`JointIo::safe`],
/// [`JointIo::enable`] and [`JointIo::preload`].
pub trait JointIo<const N: usize> {
    /// Returns the readings of the joints; `None` if measurements arrive over the link.
    fn measure(&mut self) -> Option<Readings<N>>;

    /// Returns the highest temperature that the drives report, degrees Celsius; `None` if none reports one.
    fn temperature(&self) -> Option<f32> {
        None
    }

    /// Enables every drive, with engaged brakes and without torque. Called in every tick until all drives have confirmed that they are on
    /// ([`Readings::on`]). A drive that is on gives no torque; if `action` is a damped stop, it damps.
    fn enable(&mut self, action: SafeAction);

    /// Engages the brakes and applies these torques or forces, N m or N, with `springs` as in [`JointIo::drive`]. The drives thus carry the arm
    /// before the brakes open, and until they have engaged. Also called while the brakes are open.
    fn preload(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>);

    /// Applies these torques or forces, N m or N. The brakes open only if every drive has confirmed that it is on. A drive that has not is
    /// enabled as by [`JointIo::enable`], and gives no torque until then.
    ///
    /// A drive with its own position loop also applies `springs`, centred on the measurement that the torques were computed from. Other drives
    /// ignore them.
    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>);

    /// Performs the safe action, in one tick and from any state. Called in every tick that does not drive. On a bus on which drives only answer,
    /// it also requests the next measurement. No drive counts as on afterwards.
    fn safe(&mut self, action: SafeAction);

    /// Sends each drive its last frame, the one that switches it off; nothing is measured after it. For the end of a program.
    fn end(&mut self) {
        self.safe(SafeAction::Off);
    }

    /// Makes the next calls of [`JointIo::safe`] clear latched errors of the drives. If the cause persists, the drive reports the error again. Does
    /// nothing if the drives latch no errors.
    fn clear(&mut self) {}

    /// Handles the interrupt of a CAN controller between two ticks, at the tick's priority: a frame has arrived or has been sent.
    fn interrupt(&mut self) {}
}

/// Returns the higher of two temperatures, or NaN if one is NaN. NaN is outside any bound.
#[must_use]
pub fn higher(a: Option<f32>, b: Option<f32>) -> Option<f32> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if a >= b || a.is_nan() { a } else { b }),
        (a, None) => a,
        (None, b) => b,
    }
}

/// A pin that does not exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoPin;

impl ErrorType for NoPin {
    type Error = Infallible;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
