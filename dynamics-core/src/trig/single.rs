//! Sine and cosine in f32 arithmetic alone. The derivation is in the documentation of [`super`].

use super::{Binary, SinCos};

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

/// Overflows when it multiplies an angle beyond the limit, and for no other: `2^115 (1 - 2^-24)`.
const OVERFLOW: f32 = f32::MAX / LIMIT;

/// pi/2 in two parts, for polynomials less accurate than the third part. The products with the second part may round.
const HALF_PI_SHORT: [f32; 2] = [1.570_312_5, 4.838_268e-4];

#[inline]
pub(super) fn sin_cos(x: f32) -> SinCos<f32> {
    let (r, quarter_turns) = reduce(x, &HALF_PI);
    let z = r * r;
    // The last step multiplies: r + r z S would turn the sine of -0 into +0.
    let sine = r * (1.0 + z * (SINE[0] + z * (SINE[1] + z * SINE[2])));
    let cosine = 1.0 - (0.5 * z - z * z * (COSINE[0] + z * (COSINE[1] + z * COSINE[2])));
    f32::turned(sine, cosine, quarter_turns)
}

/// [`sin_cos`] of each angle, the same bits. Each step is done for all of them, so that no instruction waits for the result of the one before it, which
/// takes a further cycle on a Cortex-M4F.
#[inline]
pub(super) fn sin_cos_all<const N: usize>(x: &[f32; N]) -> [SinCos<f32>; N] {
    let reduced = x.map(|x| reduce(x, &HALF_PI));
    let z = reduced.map(|(r, _)| r * r);
    let step = |sum: [f32; N], c: f32| core::array::from_fn(|i| c + z[i] * sum[i]);
    let sine = [SINE[1], SINE[0], 1.0].into_iter().fold([SINE[2]; N], step);
    let cosine = [COSINE[1], COSINE[0]].into_iter().fold([COSINE[2]; N], step);
    let half = z.map(|z| 0.5 * z);
    let square = z.map(|z| z * z);
    let sine: [f32; N] = core::array::from_fn(|i| reduced[i].0 * sine[i]);
    let fourth: [f32; N] = core::array::from_fn(|i| square[i] * cosine[i]);
    let rest: [f32; N] = core::array::from_fn(|i| half[i] - fourth[i]);
    core::array::from_fn(|i| f32::turned(sine[i], 1.0 - rest[i], reduced[i].1))
}

/// Zero within the limit; NaN beyond it, for an infinity and for NaN.
#[inline]
pub(super) fn within(x: f32) -> f32 {
    x * OVERFLOW * 0.0
}

/// The multiple of `1 / per_unit` that is nearest to `x`: as a number, and in the low bits.
#[inline]
fn nearest(x: f32, per_unit: f32) -> (f32, u32) {
    let shifted = x * per_unit + (ROUND + within(x));
    (shifted - ROUND, shifted.to_bits())
}

/// x - k pi/2, and k in the low bits.
#[inline]
fn reduce<const P: usize>(x: f32, half_pi: &[f32; P]) -> (f32, u32) {
    let (k, quarter_turns) = nearest(x, TWO_OVER_PI);
    (half_pi.iter().fold(x, |r, part| r - k * *part), quarter_turns)
}

impl Binary for f32 {
    type Turns = u32;

    /// The reduced angle of an f32 is zero only for the angle zero: the parts of pi/2 and of a table's step were chosen for that.
    #[inline]
    fn symmetric(self, f: impl FnOnce(Self) -> SinCos<Self>) -> SinCos<Self> {
        f(self)
    }

    #[inline]
    fn reduce(self) -> (Self, u32) {
        reduce(self, &HALF_PI_SHORT)
    }

    /// A quarter turn takes (sin, cos) to (cos, -sin), a half turn changes both signs.
    #[inline]
    fn turned(sine: Self, cosine: Self, quarter_turns: u32) -> SinCos<Self> {
        let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
        let odd = (quarter_turns & 1).wrapping_neg();
        let half_turn_sign = (quarter_turns & 2) << 30;
        let change = ((sine ^ cosine) & odd) ^ half_turn_sign;
        SinCos { sin: Self::from_bits(sine ^ change), cos: Self::from_bits(cosine ^ change ^ (quarter_turns << 31)) }
    }

    #[inline]
    fn nearest(self, per_unit: Self) -> (Self, usize) {
        let (k, bits) = nearest(self, per_unit);
        (k, bits as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::{sin_cos, sin_cos_all};

    /// The order of a chip's float unit, compared here because the desk does not use it.
    #[test]
    fn all_angles_at_once_have_the_bits_of_each_alone() {
        // Which NaN results is not specified.
        let bits = |pair: super::SinCos<f32>| {
            [pair.sin, pair.cos].map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() })
        };
        // A stride that is no power of two meets all exponents, both signs, infinities and numbers that are none.
        for first in (0..u32::MAX - 6 * 104_729).step_by(10_007) {
            let angles = core::array::from_fn::<_, 6, _>(|i| f32::from_bits(first + 104_729 * i as u32));
            assert_eq!(sin_cos_all(&angles).map(bits), angles.map(|angle| bits(sin_cos(angle))), "{angles:?}");
        }
    }
}
