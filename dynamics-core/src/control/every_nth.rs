//! A model that is evaluated in every `k`-th tick only.
//!
//! The model's part of the torque changes as slowly as the arm moves; the feedback's part must not be delayed. So the model's torque is
//! kept between two evaluations. In every tick, the change of the wanted acceleration since the last evaluation acts through a fixed
//! inertia `M0` per joint:
//!
//! ```text
//! hold         tau = tau_s + M0 (qdd - qdd_s)
//! extrapolate  tau = tau_s + M0 (qdd - qdd_s) + j/k ((tau_s - tau_p) - M0 (qdd_s - qdd_p))
//! ```
//!
//! with `s` the last evaluation, `p` the one before it, `j` ticks since `s`. The part that is held or extrapolated is
//! `tau - M0 qdd`: gravity, velocity terms, and the inertia missing from `M0`. It is `j` ticks old, `(k - 1) / 2` on
//! average, so a held part lags by half as many periods as there are ticks between two evaluations. A straight line
//! through the last two evaluations reduces this to an error of second order in the time between them.
//!
//! For a control law that uses only gravity from the model ([`super::ControlLaw::PdGravity`], [`super::ControlLaw::DiagonalInertia`]) `qdd` is
//! zero, and the torque of gravity is kept.

use super::{FrictionTerms, Gains};
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::SinCos;

/// The model's torque in the ticks between two evaluations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// It stays at its last value.
    #[default]
    Hold,
    /// It follows the straight line through the last two values.
    Extrapolate,
}

/// Inverse dynamics that [`InverseDynamics::tick`] evaluates in every `k`-th tick, with a fixed inertia between.
///
/// | tick after [`InverseDynamics::forget`] | torque |
/// |---|---|
/// | 0, k, 2 k, .. | that of the inner dynamics, bit for bit |
/// | between | `tau_s + M0 (qdd - qdd_s)`, plus the slope once [`Between::Extrapolate`] has two evaluations |
///
/// [`InverseDynamics::inverse_dynamics`] calls the inner dynamics directly: it has no ticks.
///
/// Live inputs and changes of the inner dynamics take effect at the next evaluation; a step in them is extrapolated as
/// if it were a slope for `k` ticks.
///
/// Cost of a tick between two evaluations: `3 N` operations, `5 N` with a slope; no sine, no cosine, no division. An evaluation adds `2 N`
/// stores to the inner one, and `5 N` operations for a slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EveryNth<D, S, const N: usize> {
    inner: D,
    /// `k`.
    every: i32,
    /// `1 / k`.
    share: S,
    between: Between,
    /// `M0`, kg m^2 or kg.
    inertia: [S; N],
    kept: Kept<S, N>,
}

/// Record of the last evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kept<S, const N: usize> {
    /// `tau_s`.
    torque: [S; N],
    /// `qdd_s`.
    acceleration: [S; N],
    /// Change per tick of the torque without the part of `M0`.
    slope: [S; N],
    /// True if there has been an evaluation.
    evaluated: bool,
    /// `j`; zero when the next tick evaluates.
    since: i32,
}

impl<S: Real, const N: usize> Kept<S, N> {
    fn nothing() -> Self {
        let zero = [S::zero(); N];
        Self { torque: zero, acceleration: zero, slope: zero, evaluated: false, since: 0 }
    }
}

impl<D, S: Real, const N: usize> EveryNth<D, S, N> {
    /// `inner`, evaluated in every `every`-th tick (0 counts as 1), with the inertia `M0` of the gains.
    #[must_use]
    pub fn new(inner: D, every: u32, between: Between, gains: &[Gains<S>; N]) -> Self {
        let every = i32::try_from(every.max(1)).unwrap_or(i32::MAX);
        Self {
            inner,
            every,
            share: S::one() / S::from_i32(every),
            between,
            inertia: gains.map(|gains| gains.inertia),
            kept: Kept::nothing(),
        }
    }

    /// The inner dynamics, for example to set a payload between ticks.
    pub fn inner_mut(&mut self) -> &mut D {
        &mut self.inner
    }

    /// Stores the model's torque, and its change since the last evaluation.
    #[inline]
    fn keep(&mut self, torque: &[S; N], acceleration: &[S; N]) {
        let Kept { torque: last, acceleration: last_acceleration, slope, evaluated, .. } = &mut self.kept;
        if matches!(self.between, Between::Extrapolate) && *evaluated {
            for i in 0..N {
                let of_inertia = self.inertia[i] * (acceleration[i] - last_acceleration[i]);
                slope[i] = ((torque[i] - last[i]) - of_inertia) * self.share;
            }
        }
        (*last, *last_acceleration, *evaluated) = (*torque, *acceleration, true);
    }

    /// The torque in a tick between two evaluations.
    #[inline]
    fn kept(&self, qdd: &[S; N]) -> [S; N] {
        let Kept { torque, acceleration, slope, since, .. } = &self.kept;
        let held = |i: usize| torque[i] + self.inertia[i] * (qdd[i] - acceleration[i]);
        match self.between {
            Between::Hold => core::array::from_fn(held),
            Between::Extrapolate => {
                let ticks = S::from_i32(*since);
                core::array::from_fn(|i| held(i) + ticks * slope[i])
            }
        }
    }
}

impl<S: Real, const N: usize, D: InverseDynamics<S, N>> InverseDynamics<S, N> for EveryNth<D, S, N> {
    #[inline]
    fn inverse_dynamics(
        &self,
        turn: &[SinCos<S>; N],
        q: &[S; N],
        qd: &[S; N],
        qdd: &[S; N],
        live: &Live<S, N>,
    ) -> [S; N] {
        self.inner.inverse_dynamics(turn, q, qd, qdd, live)
    }

    #[inline]
    fn tick(
        &mut self,
        turn: impl FnOnce() -> [SinCos<S>; N],
        q: &[S; N],
        qd: &[S; N],
        qdd: &[S; N],
        live: &Live<S, N>,
    ) -> [S; N] {
        let torque = if self.kept.since == 0 {
            let torque = self.inner.tick(turn, q, qd, qdd, live);
            self.keep(&torque, qdd);
            torque
        } else {
            self.kept(qdd)
        };
        let next = self.kept.since + 1;
        self.kept.since = if next == self.every { 0 } else { next };
        torque
    }

    #[inline]
    fn friction_terms(&self) -> Option<&[FrictionTerms<S>; N]> {
        self.inner.friction_terms()
    }

    #[inline]
    fn forget(&mut self) {
        self.kept = Kept::nothing();
        self.inner.forget();
    }
}
