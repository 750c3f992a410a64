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

impl<const N: usize> ControllerConfig<f64, N> {
    /// Computed torque with these gains and limits at this period, s. No friction, no integral action; the greatest age of a measurement is 2 ticks.
    /// A state is a fault from 0.1 rad or m beyond a position limit, or at 1.5 times the velocity limit: never, for a joint without limits. The observer
    /// of velocities follows at 200 rad/s. The scale of the encoders is NaN, so that counts are a fault until you set it.
    #[must_use]
    pub fn new(gains: [Gains<f64>; N], limits: [Limits<f64>; N], period: f64) -> Self {
        Self {
            law: ControlLaw::ComputedTorque,
            gains,
            friction: None,
            torque_step: limits.map(|limits| limits.torque_rate * period),
            guard: limits.map(|limits| Guard { position_margin: 0.1, velocity_max: 1.5 * limits.velocity }),
            limits,
            age_max: 2,
            encoder: [Encoder { zero: 0, per_count: f64::NAN }; N],
            observer: TrackingObserver::new(200.0, period),
            integral: None,
            teach: None,
            posture_damping: None,
        }
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
