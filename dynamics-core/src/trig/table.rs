//! Sine and cosine by a table. The derivation is in the documentation of [`super`].

use super::{Binary, SinCos, Trig};
use core::f64::consts::{FRAC_PI_2, TAU};

/// Entries in a turn; a power of two.
const TURN: usize = 512;
const QUARTER: usize = TURN / 4;

/// Sines of a turn and of the quarter that follows it: the cosine of an entry is the sine a quarter turn later.
static SINES: [f32; TURN + QUARTER] = sines();

/// 2 pi / 512 in three parts. The first two have 5 bits and one, so their products with k, below 2^19.4, are exact. With two
/// parts a difference can be zero next to a multiple of pi/2, and then the sine has no sign.
const STEP: [f64; 3] = [0.012_207_031_25, 6.103_515_625e-5, TAU / TURN as f64 - 0.012_207_031_25 - 6.103_515_625e-5];

/// A table of 512 sines a turn (2.5 KiB of flash with the quarter that repeats), and the second order about the nearest entry.
///
/// `sin(a + d) = s + d (c - s d/2)`, `cos(a + d) = c - d (s + c d/2)`, |d| <= pi/512; the first omitted term is d^3/6,
/// 3.9e-8. Linear interpolation between the same entries has an error of 1.9e-5, and loads four numbers instead of two.
///
/// The same limits, symmetries and NaN as [`super::Polynomial`]. The entries are f32 for every precision of the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Table;

impl<S: Binary> Trig<S> for Table {
    #[inline]
    fn sin_cos(&self, angle: S) -> SinCos<S> {
        angle.symmetric(near)
    }
}

/// Computes both from the nearest entry.
#[inline]
fn near<S: Binary>(angle: S) -> SinCos<S> {
    let literal = S::literal;
    let (k, bits) = angle.nearest(literal(TURN as f64 / TAU));
    let d = STEP.iter().fold(angle, |d, part| d - k * literal(*part));
    let index = bits % TURN;
    let entry = |i: usize| literal(f64::from(SINES[i]));
    let (s, c) = (entry(index), entry(index + QUARTER));
    let half = d * literal(0.5);
    SinCos { sin: s + d * (c - s * half), cos: c - d * (s + c * half) }
}

/// Computed by the compiler. Exactly odd about zero and half a turn, exactly even about a quarter.
const fn sines() -> [f32; TURN + QUARTER] {
    let mut sines = [0.0; TURN + QUARTER];
    let mut i = 0;
    while i < sines.len() {
        let (quarters, j) = (i / QUARTER % 4, i % QUARTER);
        let from_zero = if quarters % 2 == 0 { j } else { QUARTER - j };
        let sine = sine(FRAC_PI_2 * from_zero as f64 / QUARTER as f64) as f32;
        // Zeros are -0: added to a `d` of either sign, they do not change it.
        sines[i] = if quarters >= 2 || sine == 0.0 { -sine } else { sine };
        i += 1;
    }
    sines
}

/// Taylor's series, up to x = pi/2.
const fn sine(x: f64) -> f64 {
    let mut sum = 0.0;
    let mut n = 21;
    while n >= 3 {
        sum = (1.0 + sum) * (-x * x / ((n * (n - 1)) as f64));
        n -= 2;
    }
    x * (1.0 + sum)
}
