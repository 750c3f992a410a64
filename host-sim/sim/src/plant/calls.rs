//! Counters of the simulated effects, for tests only.

use core::cell::Cell;

/// An effect that the simulation computes only if a scene asks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    Friction,
    Breakaway,
    TipWrench,
    Noise,
    Encoder,
    SensorDelay,
    ActuatorDelay,
    Saturation,
    Lag,
    Ripple,
    Elasticity,
    Backlash,
    RotorCoupling,
    SensorJitter,
    ActuatorJitter,
}

impl Effect {
    pub(crate) const ALL: [Self; 15] = [
        Self::Friction,
        Self::Breakaway,
        Self::TipWrench,
        Self::Noise,
        Self::Encoder,
        Self::SensorDelay,
        Self::ActuatorDelay,
        Self::Saturation,
        Self::Lag,
        Self::Ripple,
        Self::Elasticity,
        Self::Backlash,
        Self::RotorCoupling,
        Self::SensorJitter,
        Self::ActuatorJitter,
    ];
}

thread_local! {
    /// Counters per thread, because tests run in parallel.
    static CALLS: [Cell<u64>; Effect::ALL.len()] = const { [const { Cell::new(0) }; Effect::ALL.len()] };
}

/// Counts a call.
pub(crate) fn count(effect: Effect) {
    CALLS.with(|calls| calls[effect as usize].set(calls[effect as usize].get() + 1));
}

/// Effects computed since the last call of this function, each with its count.
pub(crate) fn taken() -> Vec<(Effect, u64)> {
    let all = CALLS.with(|calls| Effect::ALL.map(|effect| (effect, calls[effect as usize].take())));
    all.into_iter().filter(|(_, calls)| *calls > 0).collect()
}
