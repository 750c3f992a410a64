//! Sine and cosine: our own polynomials of three lengths, a table, or libm's.
//!
//! The controller needs both functions of every joint angle in every tick. On a Cortex-M4F `libm::sincosf` computes in
//! f64, which that chip does in software; [`Polynomial`] stays in the precision of its argument, has no branch, no
//! division and no fused operation, and so gives the same bits on every machine.
//!
//! # How it works
//! 1. **Range.** `x c 0`, with `c` so large that the product overflows just beyond the limit, is zero for an accepted
//!    angle, and NaN for all others. Added to the number that rounds, it changes nothing or makes both results NaN.
//! 2. **Reduction.** `k = round(x 2/pi)` (adding and subtracting 1.5 * 2^23 rounds, ties to even, hence symmetrically)
//!    and `r = x - k pi/2`. pi/2 is split into parts of so few bits that the products of `k` with the leading parts are
//!    exact, and so are the first two differences: what remains is the rounding of the last subtraction.
//!    |r| passes pi/4 by less than 2^-10, by the rounding of `x 2/pi`; the polynomials are fitted that far.
//! 3. **Polynomials** in `z = r^2`, by a Remez exchange that rounds one coefficient at a time and fits the others again
//!    (`tools/minimax.py constants` prints every constant of this module with its approximation error).
//! 4. **Quadrant.** The low bits of `k`: odd swaps, (sin, cos) = (cos r, -sin r), and bit 1 changes both signs. Both by
//!    `and` and `xor` on the bits of the floats: nothing is compared, so a loop over angles is vectorised on the desk.
//!
//! The f32 version spends as few instructions as it can. The f64 version is for the desk: it carries the rounding error
//! of the reduction along as a second float, and so stays below one unit in the last place.
//!
//! `sin(-x) == -sin(x)` and `cos(-x) == cos(x)` hold to the bit, and `sin(-0) == -0`.
//!
//! # Measured errors
//! f32: against libm's f64 functions, every float of each range (`tests/trig.rs`, the ignored test; a sample pins the
//! same numbers from both sides in every run). f64: near 1,500 angles whose functions are known to 32 digits. A unit
//! in the last place (ulp) is that of the result; if the result is smaller than 2^-8 the bound is absolute instead.
//!
//! | \|x\| up to | sin, absolute | cos, absolute | sin, ulp | cos, ulp | absolute, result below 2^-8 |
//! |---|---|---|---|---|---|
//! | f32, pi/4 | 6.29e-8 | 5.87e-8 | 1.17 | 0.984 | 2.23e-10 |
//! | f32, 2 pi | 8.20e-8 | 7.80e-8 | 1.97 | 1.97 | 3.33e-10 |
//! | f32, 100 | 8.20e-8 | 8.12e-8 | 1.97 | 1.97 | 3.33e-10 |
//! | f32, 8192 ([`Polynomial::LIMIT_F32`]) | 8.20e-8 | 8.36e-8 | 1.99 | 1.98 | 3.38e-10 |
//! | f64, 2^20 ([`Polynomial::LIMIT_F64`]) | 8.45e-17 | 8.59e-17 | 0.77 | 0.78 | 2.19e-19 |
//!
//! The other implementations, measured over a sample of the same angles and pinned from both sides (`tests/trig.rs`). Absolute errors, the
//! worse of sine and cosine:
//!
//! | | f32, 2 pi | f32, 100 | f32, 8192 | f64, 2^20 |
//! |---|---|---|---|---|
//! | [`Polynomial5`] | 6.40e-7 | 6.40e-7 | 7.09e-7 | 5.70e-7 |
//! | [`Polynomial3`] | 1.53e-4 | 1.53e-4 | 1.53e-4 | 1.53e-4 |
//! | [`Table`] | 8.76e-8 | 8.76e-8 | 1.86e-7 | 5.90e-8 |
//!
//! At the tabled zeros and quadrant changes the f64 results stay below 0.78 ulp too. The f32 results do not, because they lack
//! the second float: next to a zero far from the origin their absolute error is small, but not their relative error.
//!
//! # Cost
//! Instructions on a Cortex-M4F (thumbv7em-none-eabihf, rustc 1.95, opt-level 3), counted in the disassembly of a
//! function that does nothing else, entry and exit included; the code is straight, so each is executed once.
//!
//! | f32 | default tuning | `-C target-cpu=cortex-m4` |
//! |---|---|---|
//! | one pair | 50 | 61 |
//! | six pairs, `sin_cos_all` | 247, 41.2 a pair | 300, 50.0 a pair |
//!
//! The other implementations, default tuning:
//!
//! | f32 | one pair | six pairs |
//! |---|---|---|
//! | [`Polynomial5`] | 43 | 214 |
//! | [`Polynomial3`] | 39 | 190 |
//! | [`Table`], and 2.5 KiB of flash | 35 | 162 |
//!
//! Six pairs share the loads of the constants. The default tuning uses VMLA, which rounds the product as a separate VMUL does
//! (same bits, fewer instructions, not fewer cycles). Tuned for the M4, the compiler keeps VMUL and VADD apart.
//!
//! `docs/measured/batch.md` compares the time of six pairs on the desk with libm's and glibc's.
//!
//! In f32 the sine is `r (1 + z S)` and not the more accurate `r + r z S` (1.5 instead of 2 ulp). The latter turns the sine
//! of -0 into +0, and repairing the sign costs three instructions a pair.
mod double;
mod short;
mod sin_cos;
mod single;
mod table;

use crate::scalar::Scalar;
pub use short::{Polynomial3, Polynomial5};
use sin_cos::Binary;
pub use sin_cos::{SinCos, Trig};
pub use table::Table;

/// Our own polynomials, in the precision of the angle alone. The same bits on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Polynomial;

impl Polynomial {
    /// The largest f32 angle, rad, either sign; beyond it both results are NaN.
    pub const LIMIT_F32: f32 = single::LIMIT;
    /// The largest f64 angle, rad, either sign; beyond it both results are NaN.
    pub const LIMIT_F64: f64 = double::LIMIT;

    /// Sine and cosine by sums, differences and products alone, so that they can be traced. For scalars of double precision. Equal (`==`) to the
    /// f64 results for angles within [`Polynomial::LIMIT_F64`], except that a zero may have the other sign; meaningless beyond.
    #[must_use]
    pub fn by_arithmetic<S: Scalar>(angle: S) -> SinCos<S> {
        double::by_arithmetic(angle)
    }
}

impl Trig<f32> for Polynomial {
    #[inline]
    fn sin_cos(&self, angle: f32) -> SinCos<f32> {
        single::sin_cos(angle)
    }

    #[inline]
    fn sin_cos_all<const N: usize>(&self, angles: &[f32; N]) -> [SinCos<f32>; N] {
        // The same bits in another order. Step by step suits a float unit for single numbers; lists suit vector instructions.
        if cfg!(all(target_arch = "arm", target_abi = "eabihf")) {
            single::sin_cos_all(angles)
        } else {
            sin_cos::pairs(self, angles)
        }
    }
}

impl Trig<f64> for Polynomial {
    #[inline]
    fn sin_cos(&self, angle: f64) -> SinCos<f64> {
        double::sin_cos(angle)
    }
}

/// The `libm` crate. Its f32 functions compute in f64, 2,000 to 3,000 instructions a pair on a chip without a
/// double-precision unit.
///
/// In f64 it accepts any finite angle. In f32 it accepts angles up to [`Polynomial::LIMIT_F32`]; beyond, both results are NaN. The functions
/// could go on, but the angle is rounded by half a milliradian or more: a torque from it would be wrong without a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Libm;

impl Trig<f32> for Libm {
    #[inline]
    fn sin_cos(&self, angle: f32) -> SinCos<f32> {
        let (sin, cos) = libm::sincosf(angle + single::within(angle));
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

/// A choice made at run time, by a scene or a command line. Firmware names one type instead, and links only that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// [`Polynomial`]
    #[default]
    Polynomial,
    /// [`Polynomial5`]
    Polynomial5,
    /// [`Polynomial3`]
    Polynomial3,
    /// [`Table`]
    Table,
    /// [`Libm`]
    Libm,
}

impl<S: Binary> Trig<S> for Method
where
    Polynomial: Trig<S>,
    Libm: Trig<S>,
{
    #[inline]
    fn sin_cos(&self, angle: S) -> SinCos<S> {
        match self {
            Self::Polynomial => Polynomial.sin_cos(angle),
            Self::Polynomial5 => Polynomial5.sin_cos(angle),
            Self::Polynomial3 => Polynomial3.sin_cos(angle),
            Self::Table => Table.sin_cos(angle),
            Self::Libm => Libm.sin_cos(angle),
        }
    }

    #[inline]
    fn sin_cos_lists(&self, angles: &[S], sin: &mut [S], cos: &mut [S]) {
        match self {
            Self::Polynomial => Polynomial.sin_cos_lists(angles, sin, cos),
            Self::Polynomial5 => Polynomial5.sin_cos_lists(angles, sin, cos),
            Self::Polynomial3 => Polynomial3.sin_cos_lists(angles, sin, cos),
            Self::Table => Table.sin_cos_lists(angles, sin, cos),
            Self::Libm => Libm.sin_cos_lists(angles, sin, cos),
        }
    }
}
