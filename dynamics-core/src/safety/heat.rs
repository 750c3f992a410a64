//! Heat of a motor's winding, from the torque that it gives: a model of first order.
//!
//! The loss in a winding grows with the square of its current, and so of its torque. `rated` is the torque that the motor can give
//! continuously, and `T` its time constant. The heat `x` follows
//!
//! ```text
//! T dx/dt = (tau / rated)^2 - x
//! ```
//!
//! `x = 1` is the temperature that the motor settles at under its rated torque: the continuous limit. Under a constant torque `x` moves from
//! `x0` to `(tau / rated)^2` along `exp(-t / T)`; an update of [`HeatRules::step`] is that formula, so that a step may be as long as
//! the torque is constant.
//!
//! The model has no ambient temperature, no iron losses and no second time constant for the housing. A cold motor starts at 0.
//!
//! ```
//! # use dynamics_core::safety::heat::HeatRules;
//! // 11 N m continuous, time constant 60 s; an update every 64 ms.
//! let rules = HeatRules::new(11.0_f64, 60.0, 0.064);
//! let x = (0..1000).fold(0.0, |x, _| rules.step(x, 15.4));
//! // 15.4 N m heat to 1.96, and 64 s have passed: 1.96 (1 - exp(-64 / 60)).
//! assert!((x - 1.285).abs() < 1e-3);
//! ```

use crate::fields::record;
use crate::scalar::Real;

/// Heat at which a warning is given.
pub const WARNING: f64 = 0.8;
/// Heat that is a fault: the continuous limit and a margin of 5 % for a model and a torque that are not exact.
pub const FAULT: f64 = 1.05;

record! {
    /// Numbers of one motor, on the joint's side of the gear.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct HeatRules<S> {
        /// Reciprocal of the continuous torque, 1/(N m) or 1/N.
        pub per_rated: S,
        /// Fraction of the remaining change towards the final heat that one update makes, `1 - exp(-dt / T)`.
        pub share: S,
    }
}

/// Level of a motor's heat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum HeatLevel {
    /// Below the warning.
    Cool,
    /// At or above [`WARNING`].
    Warm,
    /// Above [`FAULT`], or not a number.
    Overheated,
}

impl HeatRules<f64> {
    /// A motor without known data: it never heats.
    pub const UNKNOWN: Self = Self { per_rated: 0.0, share: 0.0 };

    /// From the motor's continuous torque, N m or N, its time constant, s, and the time between two updates, s.
    #[must_use]
    pub fn new(rated: f64, time_constant: f64, update: f64) -> Self {
        Self { per_rated: 1.0 / rated, share: -libm::expm1(-update / time_constant) }
    }
}

impl<S: Real> HeatRules<S> {
    /// The heat after an update with this torque, N m or N.
    ///
    /// The torque is taken as constant since the last update. If it changes, the error of sampling it averages out only if sampling and
    /// motion are not synchronous.
    #[inline]
    #[must_use]
    pub fn step(&self, heat: S, torque: S) -> S {
        let load = torque * self.per_rated;
        heat + self.share * (load * load - heat)
    }
}

/// Heat of all motors. One is updated in each tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Heats<S, const N: usize> {
    /// Heat of each motor, 1 at its continuous limit.
    pub(super) heat: [S; N],
    /// A bit for each motor that is warm.
    pub(super) warm: u32,
    /// The motor of the next update.
    next: usize,
}

impl<S: Real, const N: usize> Heats<S, N> {
    /// Motors that have rested for a long time.
    pub(super) fn cold() -> Self {
        Self { heat: [S::zero(); N], warm: 0, next: 0 }
    }

    /// One motor's update, with the torque that acts.
    #[inline]
    pub(super) fn update(&mut self, rules: &[HeatRules<S>; N], torque: &[S; N]) {
        let i = self.next;
        self.next = if i + 1 < N { i + 1 } else { 0 };
        let (Some(heat), Some(rules), Some(torque)) = (self.heat.get_mut(i), rules.get(i), torque.get(i)) else {
            return;
        };
        *heat = rules.step(*heat, *torque);
        let bit = 1 << i;
        self.warm = if HeatLevel::of(*heat) == HeatLevel::Cool { self.warm & !bit } else { self.warm | bit };
    }

    /// The first motor whose heat is at or above this heat, or is not a number.
    pub(super) fn above(&self, heat: f64) -> Option<u8> {
        let below = |x: &S| *x <= S::literal(heat);
        self.heat.iter().position(|x| !below(x)).map(|joint| joint as u8)
    }

    /// The share of the torque limit that may act beyond the weight, at most `most`, by the hottest motor.
    #[cold]
    pub(super) fn left(&self, most: S) -> S {
        self.heat.iter().fold(most, |most, heat| {
            let own = left(*heat);
            if own < most { own } else { most }
        })
    }
}

/// Share of the torque limit that may act beyond the weight at this heat: all of it up to [`WARNING`]. Above, it falls linearly to a tenth at the
/// continuous limit, and stays there.
///
/// The weight is always carried, because an arm without brakes sinks if its torque is cut. So a motor that is heated by the weight alone
/// continues up to [`FAULT`].
pub(super) fn left<S: Real>(heat: S) -> S {
    let warning = S::literal(WARNING);
    let left = (S::one() - heat) / (S::one() - warning);
    left.clamp_to(S::literal(LEAST), S::one())
}

/// The share at the continuous limit.
const LEAST: f64 = 0.1;

impl HeatLevel {
    /// The level of a heat.
    #[must_use]
    pub fn of<S: Real>(heat: S) -> Self {
        if heat < S::literal(WARNING) {
            Self::Cool
        } else if heat <= S::literal(FAULT) {
            Self::Warm
        } else {
            // Includes NaN: an unknown heat counts as too hot.
            Self::Overheated
        }
    }
}
