//! States of motion, and boxes of them.

/// State of a motion at one instant, in numbers that `f32` represents exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// Position, rad or m.
    pub q: [f32; N],
    /// Velocity, rad/s or m/s.
    pub qd: [f32; N],
    /// Acceleration, rad/s^2 or m/s^2.
    pub qdd: [f32; N],
}

/// A box of states: lower and upper end of each input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<const N: usize> {
    /// Position, velocity, acceleration, in the units of [`State`].
    pub inputs: [[(f64, f64); N]; 3],
}

impl<const N: usize> Region<N> {
    /// Creates a region from limits, rounded to `f32` as in the controller. Velocity and acceleration extend in both directions.
    #[must_use]
    pub fn new(q: [(f64, f64); N], qd: [f64; N], qdd: [f64; N]) -> Self {
        let round = |x: f64| f64::from(x as f32);
        let both = |x: f64| (-round(x), round(x));
        Self { inputs: [q.map(|(lo, hi)| (round(lo), round(hi))), qd.map(both), qdd.map(both)] }
    }

    /// Region of a single state.
    #[must_use]
    pub fn of(state: &State<N>) -> Self {
        let point = |x: f32| (f64::from(x), f64::from(x));
        Self { inputs: [state.q, state.qd, state.qdd].map(|all| all.map(point)) }
    }

    /// Both halves of the region, cut along one input. The index counts through all positions, velocities and accelerations.
    pub(super) fn halves(&self, input: usize) -> [Self; 2] {
        let (lo, hi) = self.inputs[input / N][input % N];
        let middle = lo + (hi - lo) / 2.0;
        [(lo, middle), (middle, hi)].map(|half| {
            let mut region = *self;
            region.inputs[input / N][input % N] = half;
            region
        })
    }

    /// State at given shares of each input's range.
    pub(super) fn state(&self, mut share: impl FnMut() -> f64) -> State<N> {
        let [q, qd, qdd] = self.inputs.map(|all| all.map(|(lo, hi)| clamped(lo + (hi - lo) * share(), (lo, hi))));
        State { q, qd, qdd }
    }
}

/// Clamps to a range. Its ends are exact in `f32`, so rounding does not leave the range.
pub(super) fn clamped(x: f64, (lo, hi): (f64, f64)) -> f32 {
    x.clamp(lo, hi) as f32
}
