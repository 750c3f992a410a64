//! The differential equation of arms side by side, with dry friction in it.

use super::state::Lanes;

/// Differential equation of a point.
pub(super) trait Flow<Y, const N: usize, const L: usize> {
    /// Inputs from outside at one instant.
    type Input;

    /// One for each joint with dry friction, zero for the others; `None` if there is no dry friction.
    fn rough(&self) -> Option<&[[f64; L]; N]>;

    /// Inputs at `t` (s into the tick).
    fn input(&self, t: &[f64; L]) -> Self::Input;

    /// Write the rate of change of the point under the input, per second, to `slope`, with joints that slide or are held as `dry` says.
    /// Writes to it what loads the held joints.
    fn slope(&self, point: &Y, input: &Self::Input, dry: &mut Dry<N, L>, slope: &mut Y, lanes: &mut Lanes<L>);
}

/// Dry friction of arms over a step, one a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dry<const N: usize, const L: usize> {
    /// Direction of the motion that friction opposes, 1 or -1; 0 for a joint that is held, or has no dry friction.
    pub(super) sign: [[f64; L]; N],
    /// 1 for a joint that may move, 0 for one that is held.
    pub(super) free: [[f64; L]; N],
    /// Torque on a held joint at the last slope; without meaning for a free one.
    pub(super) load: [[f64; L]; N],
    /// Level of the friction at the last slope.
    pub(super) level: [[f64; L]; N],
    /// Level less load of a held joint at the start of the step.
    pub(super) margin: [[f64; L]; N],
    /// True if some joint of some lane is at rest.
    pub(super) rests: bool,
}

impl<const N: usize, const L: usize> Dry<N, L> {
    /// No joint has dry friction.
    pub(super) const fn none() -> Self {
        let zero = [[0.0; L]; N];
        Self { sign: zero, free: [[1.0; L]; N], load: zero, level: zero, margin: zero, rests: false }
    }
}
