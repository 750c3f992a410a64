//! When a measurement or a reference is a fault.

use super::config::ControllerConfig;
use super::{Fault, Reference};
use crate::fields::record;
use crate::scalar::Real;

record! {
    /// When a measurement is no longer believed.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Guard<S> {
        /// How far beyond a position limit a joint may be before it is a fault, rad or m.
        pub position_margin: S,
        /// Speed at which it is a fault, rad/s or m/s.
        pub velocity_max: S,
    }
}

/// Where position and velocity of a joint are believed: between the first two, and no faster than the third. Infinite where there is no
/// limit.
#[inline]
pub(crate) fn believed<S: Real, const N: usize>(config: &ControllerConfig<S, N>, i: usize) -> (S, S, S) {
    let Guard { position_margin, velocity_max } = config.guard[i];
    let (lo, hi) = config.limits[i].position;
    (lo - position_margin, hi + position_margin, velocity_max)
}

/// Whether a state is believed. False where a value is NaN or infinite.
#[inline]
pub(super) fn state_is_inside<S: Real, const N: usize>(
    q: &[S; N],
    qd: &[S; N],
    config: &ControllerConfig<S, N>,
) -> bool {
    // Worked out when the program is built: no infinity is inside a finite bound, so the values need no second look.
    let finite = |x: S| x.clamp_symmetric(S::MAX);
    for i in 0..N {
        let (lo, hi, velocity_max) = believed(config, i);
        if !(q[i] >= finite(lo) && q[i] <= finite(hi) && qd[i].abs() <= finite(velocity_max)) {
            return false;
        }
    }
    true
}

/// What is wrong where a state is not believed, on the first joint where something is: with the reference before the state.
#[cold]
pub(super) fn name_fault<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    q: &[S; N],
    qd: &[S; N],
    config: &ControllerConfig<S, N>,
) -> Fault {
    if let Some(fault) = name_reference(reference) {
        return fault;
    }
    for i in 0..N {
        let joint = i as u8;
        let (lo, hi, velocity_max) = believed(config, i);
        if !(q[i].is_finite() && qd[i].is_finite()) {
            return Fault::NonFiniteMeasurement { joint };
        }
        if q[i] < lo || q[i] > hi {
            return Fault::PositionOutOfBounds { joint };
        }
        if qd[i].abs() > velocity_max {
            return Fault::VelocityOutOfBounds { joint };
        }
    }
    // Only a bound that is NaN brings us here: a configuration that no number can meet.
    Fault::NonFiniteMeasurement { joint: 0 }
}

/// The first joint whose reference is not a finite number, if there is one.
#[cold]
pub(crate) fn name_reference<S: Real, const N: usize>(reference: &Reference<S, N>) -> Option<Fault> {
    let finite = |i: usize| reference.q[i].is_finite() && reference.qd[i].is_finite() && reference.qdd[i].is_finite();
    (0..N).find(|&i| !finite(i)).map(|joint| Fault::NonFiniteReference { joint: joint as u8 })
}
