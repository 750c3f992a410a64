//! Sine and cosine in f32 arithmetic alone. The derivation is in the documentation of [`super`].

use super::SinCos;

/// Largest accepted |angle|, rad.
pub(super) const LIMIT: f32 = 8192.0;

const TWO_OVER_PI: f32 = core::f32::consts::FRAC_2_PI;

/// 1.5 * 2^23: a float of this size has no bits below one, so adding it rounds to the nearest integer (ties to even)
/// and leaves that integer in the low bits, in two's complement.
const ROUND: f32 = 12_582_912.0;

/// pi/2 in three parts. The first two have at most 11 bits, so their products with |k| < 2^13 are exact.
const HALF_PI: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// sin r = r (1 + z (S0 + z (S1 + z S2))), z = r^2; relative error 2^-27.9.
const SINE: [f32; 3] = [-1.666_665_5e-1, 8.332_187e-3, -1.951_789_6e-4];

/// cos r = 1 - (z/2 - z^2 (C0 + z (C1 + z C2))); relative error 2^-33.0.
const COSINE: [f32; 3] = [4.166_664_6e-2, -1.388_731e-3, 2.443_232_7e-5];

/// Overflows when it multiplies an angle beyond the limit, and no other: `2^115 (1 - 2^-24)`.
const OVERFLOW: f32 = f32::MAX / LIMIT;

#[inline]
pub(super) fn sin_cos(x: f32) -> SinCos<f32> {
    // Zero, or NaN beyond the limit, for an infinity and for NaN.
    let within = x * OVERFLOW * 0.0;
    let shifted = x * TWO_OVER_PI + (ROUND + within);
    let quarter_turns = shifted.to_bits();
    let k = shifted - ROUND;
    let r = x - k * HALF_PI[0] - k * HALF_PI[1] - k * HALF_PI[2];

    let z = r * r;
    // The last step multiplies: r + r z S would turn the sine of -0 into +0.
    let sine = r * (1.0 + z * (SINE[0] + z * (SINE[1] + z * SINE[2])));
    let cosine = 1.0 - (0.5 * z - z * z * (COSINE[0] + z * (COSINE[1] + z * COSINE[2])));

    // A quarter turn takes (sin, cos) to (cos, -sin), a half turn changes both signs.
    let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
    let odd = (quarter_turns & 1).wrapping_neg();
    let half_turn_sign = (quarter_turns & 2) << 30;
    let change = ((sine ^ cosine) & odd) ^ half_turn_sign;
    SinCos { sin: f32::from_bits(sine ^ change), cos: f32::from_bits(cosine ^ change ^ (quarter_turns << 31)) }
}
