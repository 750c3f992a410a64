//! Integral action: a torque per joint against errors of the model that the position gain cannot remove.

use super::limits::LimitFlags;
use crate::fields::record;
use crate::scalar::Real;

record! {
    /// Integral action of one joint, which removes the friction's share when the joint arrives.
    ///
    /// ```text
    /// |e| > band              d <- d + k e, within [-d_max, d_max]        k = M0 Kp h / T,  e = q_ref - q
    /// |e| <= band, arriving   d <- d less c, not through zero             once, until the error has left the band again
    /// tau <- tau + d
    /// ```
    ///
    /// A constant error of the model, or stiction, leaves the position gain with the rest error `tau_d / (M0 Kp)`; this torque grows
    /// until it is gone. With the inertia `M0` the error obeys `e''' + Kd e'' + Kp e' + (Kp / T) e = 0`, which is stable for
    /// `T > 1 / Kd` (Routh).
    ///
    /// While the joint moves, `d` contains the load that the model lacks and in addition up to the Coulomb torque `c`. A joint that has arrived
    /// needs only the load; the rest would push it out on the other side. This is why integral action hunts about every reference
    /// if there is stiction. After subtracting `c`, the remaining torque is within `c` of the load, and friction holds the joint there.
    /// (Resetting an integrator where the error crosses zero: Beerens et al., *Reset integral control for improved settling of
    /// PID-based motion systems with friction*, Automatica 107, 2019.)
    ///
    /// Two rules against wind-up: `d` never passes its bound, and in a tick in which a torque limit acts on the joint its magnitude
    /// does not grow.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Integral<S> {
        /// `k`: growth in a tick per error, N m/rad or N/m.
        pub gain: S,
        /// `d_max`, N m or N.
        pub torque_max: S,
        /// Half of the band in which the joint has arrived, rad or m.
        pub dead_band: S,
        /// `c`, Coulomb torque of the joint, N m or N.
        pub friction: S,
    }
}

/// Integral action so far, of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrated<S> {
    /// `d`, N m or N.
    pub torque: S,
    /// True if the error has been outside the dead band since the joint last arrived.
    pub away: bool,
}

impl<S: Real> Integrated<S> {
    /// No torque.
    #[must_use]
    pub fn zero() -> Self {
        Self { torque: S::zero(), away: false }
    }
}

impl<S: Real> Integral<S> {
    /// The state of the next tick from the state of the last and the error `q_ref - q`, rad or m. NaN only for NaN.
    #[inline]
    pub fn next(&self, last: Integrated<S>, error: S) -> Integrated<S> {
        let Integrated { torque, away } = last;
        if error.abs() > self.dead_band {
            Integrated { torque: (torque + self.gain * error).clamp_symmetric(self.torque_max), away: true }
        } else if away {
            Integrated { torque: torque - torque.clamp_symmetric(self.friction), away: false }
        } else {
            last
        }
    }

    /// The state to continue with after a tick in which these limits acted.
    #[inline]
    pub(super) fn after(last: Integrated<S>, next: Integrated<S>, acted: LimitFlags) -> Integrated<S> {
        let held = acted.intersects(LimitFlags::TORQUE | LimitFlags::TORQUE_RATE);
        if held && next.torque.abs() > last.torque.abs() { last } else { next }
    }
}
