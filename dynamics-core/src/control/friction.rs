//! Friction feedforward.

use crate::fields::record;
use crate::scalar::Real;

record! {
    /// Viscous and Coulomb friction of one joint, as the controller compensates it.
    ///
    /// `tau_f = b qd + c s(qd / v)`, with `s(x) = x (3 - x^2) / 2` on `[-1, 1]` and the sign of `x` outside: a sign function whose
    /// slope is continuous, so the torque does not chatter about rest. No division and no root: `1 / v` is stored.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Friction<S> {
        /// Viscous coefficient `b`, N m s/rad or N s/m.
        pub viscous: S,
        /// Coulomb torque or force `c`, N m or N.
        pub coulomb: S,
        /// `1 / v`, where `v` is the speed at which the whole Coulomb torque acts, s/rad or s/m.
        pub per_smoothing_speed: S,
    }
}

impl<S: Real> Friction<S> {
    /// Torque that makes up for friction at the velocity `qd`, N m or N; NaN for NaN.
    #[inline]
    pub fn torque(&self, qd: S) -> S {
        let x = (qd * self.per_smoothing_speed).saturated(S::one());
        let (once, cubed) = (S::literal(1.5) * self.coulomb, S::literal(0.5) * self.coulomb);
        self.viscous * qd + x * (once - cubed * (x * x))
    }
}
