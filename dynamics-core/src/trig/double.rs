//! Sine and cosine in f64 arithmetic. The derivation is in the documentation of [`super`].

use super::{Binary, SinCos};
use crate::Scalar;

/// Largest accepted |angle|, rad.
pub(super) const LIMIT: f64 = 1_048_576.0;

const TWO_OVER_PI: f64 = core::f64::consts::FRAC_2_PI;

/// 1.5 * 2^52: rounds to the nearest integer, as the f32 constant does.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// pi/2 in four parts. The first three have at most 33 bits, so their products with |k| < 2^20 are exact.
const HALF_PI: [f64; 4] =
    [1.570_796_326_734_125_6, 6.077_094_383_272_197e-11, 6.123_233_995_384_61e-17, 3.521_559_865_183_2e-27];

/// sin r = r + r z (S0 + z (S1 + ...)), z = r^2; relative error 2^-57.9.
const SINE: [f64; 6] = [
    -0.166_666_666_666_666_3,
    0.008_333_333_333_321_84,
    -0.000_198_412_698_293_585_33,
    2.755_731_353_851_786e-6,
    -2.505_073_439_001_923e-8,
    1.589_543_333_965_584_2e-10,
];

/// cos r = 1 - z/2 + z^2 (C0 + z (C1 + ...)); relative error 2^-63.9.
const COSINE: [f64; 6] = [
    0.041_666_666_666_666_595,
    -0.001_388_888_888_887_329_9,
    2.480_158_728_895_604_8e-5,
    -2.755_731_419_961_099_4e-7,
    2.087_570_258_028_113e-9,
    -1.135_858_430_180_350_8e-11,
];

/// Overflows when it multiplies an angle beyond the limit, and for no other: `2^1004 (1 - 2^-53)`.
const OVERFLOW: f64 = f64::MAX / LIMIT;

/// pi/2 in two parts, for the short polynomials.
const HALF_PI_SHORT: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

#[inline]
pub(super) fn sin_cos(angle: f64) -> SinCos<f64> {
    angle.symmetric(|x| {
        let (k, quarter_turns) = nearest(x, TWO_OVER_PI);
        let (r, tail) = reduce(x, k);
        let (sine, cosine) = near_zero(r, tail);
        f64::turned(sine, cosine, quarter_turns)
    })
}

/// The multiple of `1 / per_unit` that is nearest to `x`: as a number, and in the low bits.
#[inline]
fn nearest(x: f64, per_unit: f64) -> (f64, u64) {
    // Zero within the limit; NaN beyond it, for an infinity and for NaN.
    let within = x * OVERFLOW * 0.0;
    let shifted = x * per_unit + (ROUND + within);
    (shifted - ROUND, shifted.to_bits())
}

/// x - k pi/2 as a sum of two floats.
#[inline]
fn reduce<S: Scalar>(x: S, k: S) -> (S, S) {
    let half_pi = HALF_PI.map(S::literal);
    // Exact: every bit of these differences is a bit of x or lies above 2^-54.
    let coarse = x - k * half_pi[0] - k * half_pi[1];
    let fine = k * half_pi[2];
    let r = coarse - fine;
    // Rounding error of the last subtraction, exact too: either |coarse| > |fine|, or the subtraction lost nothing.
    let lost = (coarse - r) - fine;
    (r, lost - k * half_pi[3])
}

/// Sine and cosine of r + tail, |r| <= pi/4.
#[inline]
fn near_zero<S: Scalar>(r: S, tail: S) -> (S, S) {
    let z = r * r;
    let half_z = S::literal(0.5) * z;
    let sine = r + (r * z * horner(&SINE, z) + (tail - tail * half_z));
    // 1 - z/2 rounds; the first term of the correction restores the rounding error.
    let leading = S::one() - half_z;
    let cosine = leading + (((S::one() - leading) - half_z) + (z * z * horner(&COSINE, z) - r * tail));
    (sine, cosine)
}

#[inline]
fn horner<S: Scalar>(coefficients: &[f64; 6], z: S) -> S {
    let [c0, c1, c2, c3, c4, c5] = coefficients.map(S::literal);
    c0 + z * (c1 + z * (c2 + z * (c3 + z * (c4 + z * c5))))
}

/// Sine and cosine without access to bits.
#[inline]
pub(super) fn by_arithmetic<S: Scalar>(x: S) -> SinCos<S> {
    let [round, one] = [ROUND, 1.0].map(S::literal);
    let nearest = |x: S| (x + round) - round;
    let k = nearest(x * S::literal(TWO_OVER_PI));
    let (r, tail) = reduce(x, k);
    let (sine, cosine) = near_zero(r, tail);
    // Quarter turns, from -2 to 2, and their cosine 1, 0, -1 and sine 0, 1, 0: each product below is exact.
    let turns = k - nearest(k * S::literal(0.25)) * S::literal(4.0);
    let square = turns * turns;
    let c = one - square * (S::literal(7.0) - square) * S::literal(1.0 / 6.0);
    let s = turns * (S::literal(4.0) - square) * S::literal(1.0 / 3.0);
    SinCos { sin: sine * c + cosine * s, cos: cosine * c - sine * s }
}

impl Binary for f64 {
    type Turns = u64;

    #[inline]
    fn symmetric(self, f: impl FnOnce(Self) -> SinCos<Self>) -> SinCos<Self> {
        // Working on |angle| makes the symmetries exact by construction, for -0 too.
        let x = self.abs();
        let angle_sign = self.to_bits() ^ x.to_bits();
        let SinCos { sin, cos } = f(x);
        SinCos { sin: Self::from_bits(sin.to_bits() ^ angle_sign), cos }
    }

    #[inline]
    fn reduce(self) -> (Self, u64) {
        let (k, quarter_turns) = nearest(self, TWO_OVER_PI);
        (self - k * HALF_PI_SHORT[0] - k * HALF_PI_SHORT[1], quarter_turns)
    }

    /// A quarter turn takes (sin, cos) to (cos, -sin), a half turn changes both signs.
    #[inline]
    fn turned(sine: Self, cosine: Self, quarter_turns: u64) -> SinCos<Self> {
        let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
        let odd = (quarter_turns & 1).wrapping_neg();
        let half_turn_sign = (quarter_turns & 2) << 62;
        let change = ((sine ^ cosine) & odd) ^ half_turn_sign;
        SinCos { sin: Self::from_bits(sine ^ change), cos: Self::from_bits(cosine ^ change ^ (quarter_turns << 63)) }
    }

    #[inline]
    fn nearest(self, per_unit: Self) -> (Self, usize) {
        let (k, bits) = nearest(self, per_unit);
        (k, bits as usize)
    }
}
