//! The external torque of every joint, estimated from momentum alone; `collision.rs` has the equations.

use crate::fields::record;
use crate::momentum::Momentum;
use crate::scalar::Real;

record! {
    /// The filter of the observer: bandwidth and period as the numbers that a tick needs.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct MomentumFilter<S> made by from_numbers {
        gain: S,
        period: S,
        half_period: S,
    }
}

impl<S: Real> MomentumFilter<S> {
    /// A residual that follows the external torque with this bandwidth.
    ///
    /// | name | quantity | unit |
    /// |---|---|---|
    /// | `bandwidth` | bandwidth of the residual | rad/s |
    /// | `period` | time between ticks | s |
    #[must_use]
    pub fn new(bandwidth: f64, period: f64) -> Self {
        let gain = (1.0 - libm::exp(-bandwidth * period)) / period;
        Self::from_numbers(S::literal(gain), S::literal(period), S::literal(0.5 * period))
    }

    /// From the numbers that [`MomentumFilter::numbers`] returned, for example on the desk at build time.
    #[must_use]
    pub const fn from_numbers(gain: S, period: S, half_period: S) -> Self {
        Self { gain, period, half_period }
    }

    /// `[k, h, h/2]`.
    #[must_use]
    pub const fn numbers(&self) -> [S; 3]
    where
        S: Copy,
    {
        [self.gain, self.period, self.half_period]
    }
}

/// State of the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentumObserver<S, const N: usize> {
    /// `J`, kg m^2/s or kg m/s. Until [`MomentumObserver::drove`], it lacks the torque of the running tick.
    integral: [S; N],
    /// `r`, N m or N.
    residual: [S; N],
    /// True after the first tick.
    started: bool,
}

impl<S: Real, const N: usize> Default for MomentumObserver<S, N> {
    fn default() -> Self {
        Self { integral: [S::zero(); N], residual: [S::zero(); N], started: false }
    }
}

impl<S: Real, const N: usize> MomentumObserver<S, N> {
    /// The estimated external torque of each joint, N m or N; zero in the first tick.
    ///
    /// | name | quantity | unit | shape |
    /// |---|---|---|---|
    /// | `momentum` | momentum now, and its rate without actuators and friction | kg m^2/s, N m | N |
    /// | `friction` | friction torque at this velocity | N m or N | N |
    /// | return | `r` | N m or N | N |
    ///
    /// Cost: `9 N` operations with [`MomentumObserver::drove`].
    #[inline]
    pub fn observe(&mut self, filter: &MomentumFilter<S>, momentum: &Momentum<S, N>, friction: &[S; N]) -> &[S; N] {
        let Momentum { momentum, rate } = momentum;
        for i in 0..N {
            let half = filter.half_period * (rate[i] - friction[i]);
            let until_now = if self.started { self.integral[i] + half } else { momentum[i] };
            self.residual[i] = filter.gain * (momentum[i] - until_now);
            self.integral[i] = until_now + (filter.period * self.residual[i] + half);
        }
        self.started = true;
        &self.residual
    }

    /// Records the torque that is held until the next tick, N m or N.
    #[inline]
    pub fn drove(&mut self, filter: &MomentumFilter<S>, torque: &[S; N]) {
        for i in 0..N {
            self.integral[i] += filter.period * torque[i];
        }
    }

    /// The last `r`, N m or N.
    #[must_use]
    pub const fn residual(&self) -> &[S; N] {
        &self.residual
    }
}
