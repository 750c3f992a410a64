//! Motion of an arm that its brakes stop.

use super::state::State;

/// Time in which the brakes bring the arm to rest, s.
pub const BRAKING_TIME: f64 = 0.1;

#[derive(Clone, Debug)]
pub(super) struct Braking<const N: usize> {
    pub(super) from: State<N>,
    pub(super) motor_from: Option<State<N>>,
    pub(super) ticks: u32,
}

/// State at `t` (s) after the brakes have engaged.
pub(super) fn braked<const N: usize>(from: &State<N>, t: f64) -> State<N> {
    let t = t.min(BRAKING_TIME);
    let left = 1.0 - t / BRAKING_TIME;
    State {
        q: core::array::from_fn(|i| from.q[i] + from.qd[i] * t * (1.0 + left) / 2.0),
        qd: from.qd.map(|qd| qd * left),
    }
}
