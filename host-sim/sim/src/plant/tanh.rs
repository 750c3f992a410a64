//! Hyperbolic tangent of several numbers at once, with the bits of `libm::tanh`.
//!
//! Every number takes all ways and keeps its own, so that the lanes of a vector go together. The formulas and their constants are those
//! that `libm` computes with (FreeBSD's `s_tanh.c` and `s_expm1.c`):
//!
//! ```text
//! tanh |x| = 1 - 2 / (t + 2)    t = expm1(2 |x|)     from ln(3)/2 on
//!          = t / (t + 2)        t = expm1(2 |x|)     from ln(5/3)/2 on
//!          = -t / (t + 2)       t = expm1(-2 |x|)    below
//!
//! expm1 u  = 2^k (r - e + 1 - 2^-k)                  u = k ln 2 + r,  |r| <= ln(2)/2
//! ```

use machine_code::{Instructions, Work};

/// ln 2 in two parts; the first has few bits, so that its product with `k` is exact.
const LN_2: [f64; 2] = [f64::from_bits(0x3fe6_2e42_fee0_0000), f64::from_bits(0x3dea_39ef_3579_3c76)];

/// Coefficients of `6/r (exp(r) + 1)/(exp(r) - 1)` less its first terms, in powers of `r^2/2`.
const Q: [f64; 5] = [
    f64::from_bits(0xbfa1_1111_1111_10f4),
    f64::from_bits(0x3f5a_01a0_19fe_5585),
    f64::from_bits(0xbf14_ce19_9eaa_dbb7),
    f64::from_bits(0x3ed0_cfca_86e6_5239),
    f64::from_bits(0xbe8a_fdb7_6e09_c32d),
];

/// Bounds at which `libm` changes its formula; it compares the upper halves of the numbers' bits.
const LN_3_HALF: f64 = f64::from_bits(0x3fe1_93eb_0000_0000);
const LN_5_3_HALF: f64 = f64::from_bits(0x3fd0_58af_0000_0000);
const LN_2_HALF: f64 = f64::from_bits(0x3fd6_2e43_0000_0000);
const LN_2_AND_A_HALF: f64 = f64::from_bits(0x3ff0_a2b2_0000_0000);

/// Magnitude above which the tangent is one to the last bit.
pub(super) const ONE_FROM: f64 = 20.5;

/// 1.5 * 2^52: rounds to the nearest integer, which then lies in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Hyperbolic tangent of every number, in vectors if the processor has them.
pub(super) fn tanh_of_vectors<const L: usize>(x: &[f64; L]) -> [f64; L] {
    Instructions::Avx.run(Tanh(x))
}

struct Tanh<'a, const L: usize>(&'a [f64; L]);

impl<const L: usize> Work for Tanh<'_, L> {
    type Outcome = [f64; L];

    #[inline(always)]
    fn run(self) -> [f64; L] {
        tanh(self.0)
    }
}

/// Hyperbolic tangent of every lane.
#[inline(always)]
pub(super) fn tanh<const L: usize>(x: &[f64; L]) -> [f64; L] {
    let mut tanh = [0.0; L];
    for lane in 0..L {
        tanh[lane] = one(x[lane]);
    }
    tanh
}

/// Hyperbolic tangent without a branch.
#[inline(always)]
fn one(x: f64) -> f64 {
    // NaN stays.
    let magnitude = select(x.abs() > ONE_FROM, ONE_FROM, x.abs());
    let (large, small) = (magnitude >= LN_3_HALF, magnitude < LN_5_3_HALF);
    let t = exp_less_one(2.0 * magnitude, select(small, -2.0 * magnitude, 2.0 * magnitude));
    let quotient = select(large, 2.0, select(small, -t, t)) / (t + 2.0);
    select(large, 1.0 - quotient, quotient).copysign(x)
}

/// `exp(u) - 1` for `u` of this magnitude, from -0.52 to 41.
#[inline(always)]
#[expect(clippy::float_cmp, reason = "`k` is an integer")]
fn exp_less_one(magnitude: f64, u: f64) -> f64 {
    // k: 0, 1 or -1 by the bounds, and from there on the nearest of u / ln 2, as libm rounds it.
    let y = core::f64::consts::LOG2_E * u + 0.5;
    let nearest = (y + ROUND) - ROUND;
    let floor = nearest - select(nearest > y, 1.0, 0.0);
    let near = select(magnitude >= LN_2_HALF, 1.0_f64.copysign(u), 0.0);
    let k = select(magnitude >= LN_2_AND_A_HALF, floor, near);
    let (high, low) = (u - k * LN_2[0], k * LN_2[1]);
    let r = high - low;
    let lost = (high - r) - low;

    let half = 0.5 * r;
    let z = r * half;
    let r1 = 1.0 + z * (Q[0] + z * (Q[1] + z * (Q[2] + z * (Q[3] + z * Q[4]))));
    let t = 3.0 - r1 * half;
    let e = z * ((r1 - t) / (6.0 - r * t));
    let e = r * (e - lost) - lost - z;

    let exponent = (k + ROUND).to_bits();
    let two_to_k = f64::from_bits(exponent.wrapping_add(1023) << 52);
    let two_to_minus_k = f64::from_bits(1023_u64.wrapping_sub(exponent) << 52);
    let few = r - e + (1.0 - two_to_minus_k);
    let many = r - (e + two_to_minus_k) + 1.0;
    let one = select((k == 1.0) & (r < -0.25), (r + 0.5) - e, few);
    select(k >= 20.0, many, one) * two_to_k
}

/// One of two numbers, by their bits: a branch would keep the lanes apart.
#[inline(always)]
fn select(first: bool, a: f64, b: f64) -> f64 {
    let mask = u64::from(first).wrapping_neg();
    f64::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
}

#[cfg(test)]
mod tests {
    use super::{LN_2_AND_A_HALF, LN_2_HALF, LN_3_HALF, LN_5_3_HALF, tanh};
    use proptest::prelude::*;

    fn check(x: f64) {
        assert_eq!(tanh(&[x, -x]).map(f64::to_bits), [x, -x].map(|x| libm::tanh(x).to_bits()), "{x:e}");
    }

    #[test]
    fn every_magnitude_has_the_bits_of_libm() {
        let bounds = [0.549, 0.2554, 0.1733, 0.5199, 0.0866, 20.5, 22.0, 20.0, 19.4, 1.0, 0.0, f64::MIN_POSITIVE];
        let ends = [1e-310, 5e-324, 1e-17, 1e-16, 1e300, f64::INFINITY];
        let spaced = (0..400_000).map(|k| f64::from(k) * 7e-5);
        let scaled = (0..100_000).map(|k| libm::exp(f64::from(k - 90_000) * 0.008));
        for x in bounds.into_iter().chain(ends).chain(spaced).chain(scaled) {
            check(x);
        }
        // Where k is next, and where a formula is.
        let next = (1..=120).map(|k| f64::from(k) * core::f64::consts::LN_2 / 4.0);
        let other = [LN_2_AND_A_HALF, LN_2_HALF, LN_3_HALF, LN_5_3_HALF].map(|bound| [bound, bound / 2.0, bound / 4.0]);
        for x in next.chain(other.into_iter().flatten()) {
            for step in -1000..1000 {
                check(f64::from_bits(x.to_bits().wrapping_add_signed(step)));
            }
        }
        assert!(tanh(&[f64::NAN]).iter().all(|x| x.is_nan()));
    }

    proptest! {
        #[test]
        fn a_lane_has_the_bits_that_it_has_alone(x in prop::array::uniform8(prop_oneof![-30.0..30.0, any::<f64>()])) {
            let alone = x.map(libm::tanh);
            for (found, wanted) in tanh(&x).into_iter().zip(alone) {
                prop_assert!(found.to_bits() == wanted.to_bits() || found.is_nan() && wanted.is_nan());
            }
        }
    }
}
