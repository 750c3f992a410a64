//! Heat of a motor's winding, from the torque that it gives: a model of first order.
//!
//! The loss in a winding grows with the square of its current, and so of its torque. With the torque that the motor can give for ever,
//! `rated`, and the time constant `T`, the heat `x` follows
//!
//! ```text
//! T dx/dt = (tau / rated)^2 - x
//! ```
//!
//! `x = 1` is the temperature that the motor settles at under its rated torque: the continuous limit. Under a constant torque `x` moves from
//! `x0` to `(tau / rated)^2` along `exp(-t / T)`; an update of [`HeatRules::step`] is that formula, so that a step may be as long as
//! the torque is constant.
//!
//! The model knows no ambient temperature, no loss in iron and no second time constant of the housing. A cold motor begins at 0.
//!
//! ```
//! # use dynamics_core::safety::heat::HeatRules;
//! // 11 N m for ever, 36 N m for a while, time constant 60 s; an update every 64 ms.
//! let rules = HeatRules::new(11.0_f64, 36.0, 60.0, 0.064);
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
        /// One over the torque that it can give for ever, 1/(N m) or 1/N.
        pub per_rated: S,
        /// Square of the greatest torque over the rated one.
        pub peak_square: S,
        /// Share of the way to the final heat that one update goes, `1 - exp(-dt / T)`.
        pub share: S,
    }
}

/// How hot a motor is.
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
    /// From the torques that the motor can give for ever and at most, N m or N, its time constant, s, and the time between two updates, s.
    ///
    /// A greatest torque below the rated one counts as the rated one.
    #[must_use]
    pub fn new(rated: f64, peak: f64, time_constant: f64, update: f64) -> Self {
        let peak = if peak > rated { peak / rated } else { 1.0 };
        Self { per_rated: 1.0 / rated, peak_square: peak * peak, share: -libm::expm1(-update / time_constant) }
    }
}

impl<S: Real> HeatRules<S> {
    /// The heat after an update in which this torque acted, N m or N.
    ///
    /// The torque is that of the whole time since the last update: where it changes, the error of a sampled one averages out only if
    /// sampling and motion do not keep step.
    #[inline]
    #[must_use]
    pub fn step(&self, heat: S, torque: S) -> S {
        let load = torque * self.per_rated;
        heat + self.share * (load * load - heat)
    }

    /// Square of the greatest torque that may act at this heat, over the rated torque: the whole `peak_square` up to the warning, from there
    /// down a line to 1 at the continuous limit, where the heat no longer grows.
    ///
    /// A motor that obeys it stays at or below a heat of 1 if an update is short: `share (1 + 5 (peak_square - 1)) <= 1`.
    /// **An arm without brakes that needs more than this to hold itself sinks**: reduce motions by it, not what carries the weight.
    #[inline]
    #[must_use]
    pub fn derated_square(&self, heat: S) -> S {
        let warning = S::literal(WARNING);
        let left = ((S::one() - heat) / (S::one() - warning)).clamp_to(S::zero(), S::one());
        S::one() + (self.peak_square - S::one()) * left
    }
}

impl HeatLevel {
    /// The level of a heat.
    #[must_use]
    pub fn of<S: Real>(heat: S) -> Self {
        if heat < S::literal(WARNING) {
            Self::Cool
        } else if heat <= S::literal(FAULT) {
            Self::Warm
        } else {
            // NaN too: what cannot be told from hot is hot.
            Self::Overheated
        }
    }
}
