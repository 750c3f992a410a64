//! Ways of reaching the joints, without a chip in them: the board runs them before its wires, the desk before simulated
//! drives, and the tests before models of the devices on the wire.
//!
//! | module | holds |
//! |---|---|
//! | [`frames`] | commands and replies of an actuator on CAN, whatever its maker |
//! | [`mit`] | commands and replies of MIT-mode actuators, packed |
//! | [`mini_cheetah`], [`damiao`], [`robstride`] | the frames of three kinds of actuators |
//! | [`bus_time`] | how long frames take on a CAN bus, and how fast a schedule can be; the core's |
//! | [`can_bus`] | a CAN bus, as a schedule of commands needs it |
//! | [`can`] | actuators on up to three CAN buses: the schedule of commands, and the checks on replies |
//! | [`queued`] | queues beside a controller that holds fewer frames than a tick has |
//! | [`as5047p`] | the magnetic encoder: its words, its errors, its turns |
//! | [`run_tick`] | the order of a tick: measurement, session, outputs, and only then whether it was late |
//! | [`pwm`] | torque to duty cycle, H-bridges, and the encoders beside them |
//!
//! Every function here is total: input from a wire becomes a value, a count or a fault bit of a joint, never a panic,
//! and no loop waits for hardware without a bound.
#![no_std]
#![forbid(unsafe_code)]

pub mod as5047p;
pub mod can;
pub mod can_bus;
pub mod damiao;
pub mod frames;
pub mod mini_cheetah;
pub mod mit;
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

/// Ticks without a measurement after which a joint is at fault ([`session::readings::JointFaults::MISSING`]).
///
/// The joint's measurement is one tick older each time. The controller's own limit (`age_max` of the scene) comes first
/// where it is lower.
pub const MISSING_MAX: u32 = 3;

/// The joints, as the tick sees them: once a tick [`JointIo::measure`], then [`JointIo::drive`] or [`JointIo::safe`].
pub trait JointIo<const N: usize> {
    /// Readings of the joints; `None` where measurements come over the link.
    fn measure(&mut self) -> Option<Readings<N>>;

    /// Highest temperature that the drives report, degrees Celsius; `None` where none does.
    fn temperature(&self) -> Option<f32> {
        None
    }

    /// Enables every drive, with engaged brakes and without torque. Called in every tick until all drives have shown that they are on
    /// ([`Readings::on`]). A drive that is on gives no torque; where `action` is a damped stop it damps.
    fn enable(&mut self, action: SafeAction);

    /// Engages the brakes, and gives these torques or forces, N m or N, with `springs` as [`JointIo::drive`] does: the arm's weight is carried
    /// before the brakes open, and until they have engaged. Called on open brakes too.
    fn preload(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>);

    /// Drives these torques or forces, N m or N. The brakes are open only if every drive has shown that it is on. A drive that has not is
    /// enabled, as by [`JointIo::enable`], and gives no torque until then.
    ///
    /// A drive with a loop of its own takes `springs` as well, about the measurement that the torques follow from; any other
    /// leaves them out.
    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>);

    /// Stops, in one tick and from any state. Called in every tick that does not drive; where the wire asks for it, it also
    /// asks for the next measurement. No drive counts as on after it.
    fn safe(&mut self, action: SafeAction);

    /// Clears latched errors of the drives in the next calls of [`JointIo::safe`]. An error that is still there comes back; the readings show it
    /// as long as it does. Nothing to do where drives latch none.
    fn clear(&mut self) {}

    /// The interrupt of a controller between two ticks, at the tick's own priority: a frame has come, or one is sent.
    fn interrupt(&mut self) {}
}

/// The higher of two temperatures; NaN where one is NaN, which no bound lets pass.
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
