//! Everything about a controller that does not change while it runs, and where it is stored.

use super::friction::Friction;
use super::integral::Integral;
use super::law::{ControlLaw, Gains};
use super::observer::{Encoder, TrackingObserver};
use super::teach::Teach;
use crate::fields::record;
use crate::joint::Limits;

record! {
    /// Bounds beyond which a measured state is a fault.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Guard<S> {
        /// Greatest distance beyond a position limit without a fault, rad or m.
        pub position_margin: S,
        /// Greatest speed without a fault, rad/s or m/s.
        pub velocity_max: S,
    }
}

record! {
    /// Everything about the controller that does not change while it runs.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ControllerConfig<S, const N: usize> {
        /// The control law.
        pub law: ControlLaw,
        /// Gains per joint.
        pub gains: [Gains<S>; N],
        /// Friction to compensate, per joint; `None` leaves it to the feedback.
        pub friction: Option<[Friction<S>; N]>,
        /// Limits per joint.
        pub limits: [Limits<S>; N],
        /// Greatest change of torque in one tick, N m or N: the torque-rate limit times the period.
        pub torque_step: [S; N],
        /// Bounds on the measured state, per joint.
        pub guard: [Guard<S>; N],
        /// Greatest age of a measurement without a fault, ticks.
        pub age_max: u32,
        /// Encoder scale per joint.
        pub encoder: [Encoder<S>; N],
        /// Velocity from counts.
        pub observer: TrackingObserver<S>,
        /// Integral action per joint; `None` leaves a constant load that the model lacks to the position gain.
        pub integral: Option<[Integral<S>; N]>,
        /// Behaviour of the joints under [`ControlLaw::Teach`]; with `None` only the weight is carried.
        pub teach: Option<[Teach<S>; N]>,
        /// Share of the damping of [`ControlLaw::Impedance`] and [`ControlLaw::Split`] that acts through the model's inertia, as `M(q) Kd` instead of
        /// `M0 Kd`; `None` for none.
        pub posture_damping: Option<S>,
    }
}

/// Source of a controller's configuration.
///
/// On the desk this is the configuration itself. A firmware knows its configuration when it is built, and implements
/// this for a type without a size. The compiler then folds every number into the code of the tick and omits
/// everything without effect (an infinite limit, a zero offset). The configuration needs no RAM.
pub trait Configuration<S, const N: usize> {
    /// Returns the configuration. It stays the same until it is changed through [`Configuration::get_mut`].
    fn get(&self) -> &ControllerConfig<S, N>;

    /// Returns the configuration for changes between ticks; `None` if it is part of the program.
    fn get_mut(&mut self) -> Option<&mut ControllerConfig<S, N>> {
        None
    }
}

impl<S, const N: usize> Configuration<S, N> for ControllerConfig<S, N> {
    #[inline]
    fn get(&self) -> &Self {
        self
    }

    fn get_mut(&mut self) -> Option<&mut Self> {
        Some(self)
    }
}
