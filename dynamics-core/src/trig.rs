//! Sine and cosine.
/// Sine and cosine of one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinCos<S> {
    /// Sine.
    pub sin: S,
    /// Cosine.
    pub cos: S,
}
/// The choice of sine and cosine.
pub trait Trig<S>: Copy {
    /// Both of one angle, rad.
    fn sin_cos(&self, angle: S) -> SinCos<S>;
    /// Both of each angle, rad.
    fn sin_cos_all<const N: usize>(&self, angles: &[S; N]) -> [SinCos<S>; N]
    where
        S: Copy,
    {
        core::array::from_fn(|i| self.sin_cos(angles[i]))
    }
}
