//! The differential equation of several arms, one per lane, with dry friction.

use super::state::Lanes;

/// Differential equation of the state.
pub(super) trait Flow<Y, const N: usize, const L: usize> {
    /// External inputs at one instant.
    type Input;

    /// One for each joint with dry friction, zero for the others; `None` if there is no dry friction.
    fn rough(&self) -> Option<&[[f64; L]; N]>;

    /// Inputs at `t` (s into the tick).
    fn input(&self, t: &[f64; L]) -> Self::Input;

    /// Writes the rate of change of the state under the input, per second, to `slope`; `dry` specifies which joints slide and which are held. Writes
    /// the loads of the held joints to `dry`.
    fn slope(&self, point: &Y, input: &Self::Input, dry: &mut Dry<N, L>, slope: &mut Y, lanes: &mut Lanes<L>);
}

/// State of the dry friction over a step, for several arms, one per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dry<const N: usize, const L: usize> {
    /// Direction of the motion that friction opposes, 1 or -1; 0 for a joint that is held, or has no dry friction.
    pub(super) sign: [[f64; L]; N],
    /// 1 for a joint that may move, 0 for one that is held.
    pub(super) free: [[f64; L]; N],
    /// Torque on a held joint at the last evaluation of the slope, N m or N; undefined for a free joint.
    pub(super) load: [[f64; L]; N],
    /// Level of the dry friction at the last evaluation of the slope, N m or N.
    pub(super) level: [[f64; L]; N],
    /// Level minus load of a held joint at the start of the step, N m or N.
    pub(super) margin: [[f64; L]; N],
    /// True if some joint in some lane is at rest.
    pub(super) rests: bool,
}

impl<const N: usize, const L: usize> Dry<N, L> {
    /// No joint has dry friction.
    pub(super) const fn none() -> Self {
        let zero = [[0.0; L]; N];
        Self { sign: zero, free: [[1.0; L]; N], load: zero, level: zero, margin: zero, rests: false }
    }
}
