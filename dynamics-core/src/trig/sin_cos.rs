//! Sine and cosine of an angle, and the interface of what computes them.

use crate::scalar::Real;

/// Sine and cosine of one angle. In C: `struct { S sin; S cos; }`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct SinCos<S> {
    /// Sine.
    pub sin: S,
    /// Cosine.
    pub cos: S,
}

/// An implementation of sine and cosine.
pub trait Trig<S: Copy>: Copy {
    /// Sine and cosine of an angle in radians.
    fn sin_cos(&self, angle: S) -> SinCos<S>;

    /// Sine and cosine of each angle, rad: the same bits as [`Trig::sin_cos`].
    #[inline]
    fn sin_cos_all<const N: usize>(&self, angles: &[S; N]) -> [SinCos<S>; N] {
        pairs(self, angles)
    }

    /// Sine and cosine of each angle, rad, as two lists: the same bits as [`Trig::sin_cos`]. Fills as many as the shortest list has.
    #[inline]
    fn sin_cos_lists(&self, angles: &[S], sin: &mut [S], cos: &mut [S]) {
        for ((angle, sin), cos) in angles.iter().zip(sin).zip(cos) {
            let both = self.sin_cos(*angle);
            (*sin, *cos) = (both.sin, both.cos);
        }
    }
}

/// Sine and cosine of each angle, computed as two lists, which compilers turn into vector instructions.
#[inline]
pub(super) fn pairs<S: Copy, const N: usize>(trig: &impl Trig<S>, angles: &[S; N]) -> [SinCos<S>; N] {
    let (mut sin, mut cos) = (*angles, *angles);
    trig.sin_cos_lists(angles, &mut sin, &mut cos);
    core::array::from_fn(|i| SinCos { sin: sin[i], cos: cos[i] })
}

/// Operations of `f32` and `f64` that reduce an angle.
pub(super) trait Binary: Real {
    /// The bits that count quarter turns.
    type Turns: Copy;

    /// `f` of an angle. A type whose reduced angle can be zero for an angle that is not, and so loses the sign of the sine, computes `f` of the
    /// magnitude and applies the angle's sign to the sine.
    fn symmetric(self, f: impl FnOnce(Self) -> SinCos<Self>) -> SinCos<Self>;

    /// Returns the rest of an angle after the nearest multiple of a quarter turn, and that multiple.
    fn reduce(self) -> (Self, Self::Turns);

    /// Sine and cosine after this many quarter turns.
    fn turned(sine: Self, cosine: Self, quarter_turns: Self::Turns) -> SinCos<Self>;

    /// `round(self per_unit)`, or NaN beyond the limit: as a number, and in the low bits of an integer.
    fn nearest(self, per_unit: Self) -> (Self, usize);
}
