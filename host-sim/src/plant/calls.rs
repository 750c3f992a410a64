//! How often the simulated world computes each of its effects; in tests only.

use core::cell::Cell;

/// An effect that a scene has to ask for.
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
    SensorJitter,
    ActuatorJitter,
}

impl Effect {
    pub(crate) const ALL: [Self; 14] = [
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
        Self::SensorJitter,
        Self::ActuatorJitter,
    ];
}

thread_local! {
    /// Of this thread alone: tests run side by side.
    static CALLS: [Cell<u64>; Effect::ALL.len()] = const { [const { Cell::new(0) }; Effect::ALL.len()] };
}

/// Count a call.
pub(crate) fn count(effect: Effect) {
    CALLS.with(|calls| calls[effect as usize].set(calls[effect as usize].get() + 1));
}

/// The effects that were called since the last time this was asked, each with how often.
pub(crate) fn taken() -> Vec<(Effect, u64)> {
    let all = CALLS.with(|calls| Effect::ALL.map(|effect| (effect, calls[effect as usize].take())));
    all.into_iter().filter(|(_, calls)| *calls > 0).collect()
}
