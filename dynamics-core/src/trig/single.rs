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

#[inline]
pub(super) fn sin_cos(angle: f32) -> SinCos<f32> {
    // NaN compares false, so it takes the same way out as a huge angle.
    let x = if angle.abs() <= LIMIT { angle } else { f32::NAN };

    let shifted = x * TWO_OVER_PI + ROUND;
    let quarter_turns = shifted.to_bits();
    let k = shifted - ROUND;
    let r = x - k * HALF_PI[0] - k * HALF_PI[1] - k * HALF_PI[2];

    let z = r * r;
    // The last step multiplies: r + r z S would turn the sine of -0 into +0.
    let sine = r * (1.0 + z * (SINE[0] + z * (SINE[1] + z * SINE[2])));
    let cosine = 1.0 - (0.5 * z - z * z * (COSINE[0] + z * (COSINE[1] + z * COSINE[2])));

    // A quarter turn takes (sin, cos) to (cos, -sin), a half turn changes both signs.
    let (sin, cos) = if quarter_turns & 1 == 0 { (sine, cosine) } else { (cosine, -sine) };
    let half_turn_sign = (quarter_turns & 2) << 30;
    SinCos { sin: f32::from_bits(sin.to_bits() ^ half_turn_sign), cos: f32::from_bits(cos.to_bits() ^ half_turn_sign) }
}
