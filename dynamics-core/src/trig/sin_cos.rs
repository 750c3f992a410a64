//! Sine and cosine of an angle, and what computes them.

use crate::scalar::Real;

/// Sine and cosine of one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinCos<S> {
    /// Sine.
    pub sin: S,
    /// Cosine.
    pub cos: S,
}

/// The choice of sine and cosine.
pub trait Trig<S: Copy>: Copy {
    /// Both of one angle, rad.
    fn sin_cos(&self, angle: S) -> SinCos<S>;

    /// Both of each angle, rad: the bits of [`Trig::sin_cos`].
    #[inline]
    fn sin_cos_all<const N: usize>(&self, angles: &[S; N]) -> [SinCos<S>; N] {
        let (mut sin, mut cos) = (*angles, *angles);
        self.sin_cos_lists(angles, &mut sin, &mut cos);
        core::array::from_fn(|i| SinCos { sin: sin[i], cos: cos[i] })
    }

    /// Both of each angle, rad, as two lists: the bits of [`Trig::sin_cos`]. As many as the shortest list has.
    #[inline]
    fn sin_cos_lists(&self, angles: &[S], sin: &mut [S], cos: &mut [S]) {
        for ((angle, sin), cos) in angles.iter().zip(sin).zip(cos) {
            let both = self.sin_cos(*angle);
            (*sin, *cos) = (both.sin, both.cos);
        }
    }
}

/// Operations of `f32` and `f64` that reduce an angle.
pub(super) trait Binary: Real {
    /// The bits that count quarter turns.
    type Turns: Copy;

    /// `f` of an angle. Where the reduced angle can be zero and so has no sign for the sine, this is `f` of the
    /// magnitude, with the angle's sign given to the sine.
    fn symmetric(self, f: impl FnOnce(Self) -> SinCos<Self>) -> SinCos<Self>;

    /// The rest of an angle after the nearest multiple of a quarter turn, and that multiple.
    fn reduce(self) -> (Self, Self::Turns);

    /// Sine and cosine after so many quarter turns.
    fn turned(sine: Self, cosine: Self, quarter_turns: Self::Turns) -> SinCos<Self>;

    /// `round(self per_unit)`, or NaN beyond the limit: as a number, and in the low bits of an integer.
    fn nearest(self, per_unit: Self) -> (Self, usize);
}
