//! Sine and cosine: our own polynomials, or libm's.
//!
//! The controller needs both functions of every joint angle in every tick. On a Cortex-M4F `libm::sincosf` computes in
//! f64, which that chip does in software; [`Polynomial`] stays in the precision of its argument, has no branch, no
//! division and no fused operation, and so gives the same bits on every machine.
//!
//! # How it works
//! 1. **Range.** If |x| is beyond the limit, infinite or NaN, a select replaces it by NaN, and both results are NaN.
//! 2. **Reduction.** `k = round(x 2/pi)` (adding and subtracting 1.5 * 2^23 rounds, ties to even, hence symmetrically)
//!    and `r = x - k pi/2`. pi/2 is split into parts of so few bits that the products of `k` with the leading parts are
//!    exact, and so are the first two differences: what remains is the rounding of the last subtraction.
//!    |r| passes pi/4 by less than 2^-10, by the rounding of `x 2/pi`; the polynomials are fitted that far.
//! 3. **Polynomials** in `z = r^2`, by a Remez exchange that rounds one coefficient at a time and fits the others again
//!    (`tools/minimax.py constants` prints every constant of this module with its approximation error).
//! 4. **Quadrant.** The low bits of `k`: odd swaps, (sin, cos) = (cos r, -sin r), and bit 1 changes both signs.
//!
//! The f32 version spends as few instructions as it can. The f64 version is for the desk: it carries the rounding error
//! of the reduction along as a second float, and so stays below one unit in the last place.
//!
//! `sin(-x) == -sin(x)` and `cos(-x) == cos(x)` hold to the bit, and `sin(-0) == -0`.
//!
//! # Measured errors
//! Against f64 libm, all floats of each range (`tests/trig.rs`, the exhaustive test; the strided one pins the same
//! numbers from both sides). The unit in the last place (ulp) is that of the result, for results of at least 2^-8;
//! closer to a zero the error is bounded absolutely.
//!
//! | f32, \|x\| up to | absolute, sin | absolute, cos | ulp, sin | ulp, cos | absolute where the result is below 2^-8 |
//! |---|---|---|---|---|---|
//! | TABLE |
//!
//! # Cost
//! TABLE
mod double;
mod single;

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

    /// Both of each angle, rad.
    #[inline]
    fn sin_cos_all<const N: usize>(&self, angles: &[S; N]) -> [SinCos<S>; N] {
        angles.map(|angle| self.sin_cos(angle))
    }
}

/// Our own polynomials, in the precision of the angle alone. The same bits on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Polynomial;

impl Polynomial {
    /// The largest f32 angle, rad, either sign; beyond it both results are NaN.
    pub const LIMIT_F32: f32 = single::LIMIT;
    /// The largest f64 angle, rad, either sign; beyond it both results are NaN.
    pub const LIMIT_F64: f64 = double::LIMIT;
}

impl Trig<f32> for Polynomial {
    #[inline]
    fn sin_cos(&self, angle: f32) -> SinCos<f32> {
        single::sin_cos(angle)
    }
}

impl Trig<f64> for Polynomial {
    #[inline]
    fn sin_cos(&self, angle: f64) -> SinCos<f64> {
        double::sin_cos(angle)
    }
}

/// The `libm` crate. Any finite angle; its f32 functions compute in f64, 2,000 to 3,000 instructions a pair on a chip
/// without a double-precision unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Libm;

impl Trig<f32> for Libm {
    #[inline]
    fn sin_cos(&self, angle: f32) -> SinCos<f32> {
        let (sin, cos) = libm::sincosf(angle);
        SinCos { sin, cos }
    }
}

impl Trig<f64> for Libm {
    #[inline]
    fn sin_cos(&self, angle: f64) -> SinCos<f64> {
        let (sin, cos) = libm::sincos(angle);
        SinCos { sin, cos }
    }
}

/// A choice made at run time, by a scene or a command line. Firmware names one of the two instead, and links only that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// [`Polynomial`]
    #[default]
    Polynomial,
    /// [`Libm`]
    Libm,
}

impl<S: Copy> Trig<S> for Method
where
    Polynomial: Trig<S>,
    Libm: Trig<S>,
{
    #[inline]
    fn sin_cos(&self, angle: S) -> SinCos<S> {
        match self {
            Self::Polynomial => Polynomial.sin_cos(angle),
            Self::Libm => Libm.sin_cos(angle),
        }
    }
}
