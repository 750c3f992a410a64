//! Sine and cosine by polynomials of fewer terms. The derivation is in the documentation of [`super`].

use super::{Binary, SinCos, Trig};

/// sin r = r (S0 + z (S1 + z S2)), z = r^2; absolute error 5.7e-7.
const SINE_5: [f32; 3] = [9.999_949_3e-1, -1.666_010_6e-1, 8.120_65e-3];

/// cos r = 1 + z (C0 + z (C1 + z C2)); absolute error 3.4e-8.
const COSINE_6: [f32; 3] = [-4.999_989_3e-1, 4.165_616e-2, -1.359_592_9e-3];

/// sin r = r (S0 + z S1), z = r^2; absolute error 1.6e-4.
const SINE_3: [f32; 2] = [9.990_266_6e-1, -1.603_285_5e-1];

/// cos r = 1 + z (C0 + z C1); absolute error 1.3e-5.
const COSINE_4: [f32; 2] = [-4.997_752e-1, 4.048_604e-2];

/// Polynomials with a sine of degree 5 and a cosine of degree 6; otherwise as [`super::Polynomial`].
///
/// `sin r = r (S0 + S1 r^2 + S2 r^4)`, `cos r = 1 + C0 r^2 + C1 r^4 + C2 r^6`, fitted for the least largest absolute error. A cosine of
/// degree 4 would have an error of 1.3e-5, 20 times that of the sine.
///
/// The same limits, symmetries and NaN as [`super::Polynomial`]. The sine of a tiny angle is 5.1e-6 of the angle too small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Polynomial5;

/// Polynomials with a sine of degree 3 and a cosine of degree 4; otherwise as [`super::Polynomial`].
///
/// `sin r = r (S0 + S1 r^2)`, `cos r = 1 + C0 r^2 + C1 r^4`, fitted for the least largest absolute error. A cosine of degree 2 would
/// have ten times the error of the sine.
///
/// The same limits, symmetries and NaN as [`super::Polynomial`]. The sine of a tiny angle is a thousandth of the angle
/// too small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Polynomial3;

impl<S: Binary> Trig<S> for Polynomial5 {
    #[inline]
    fn sin_cos(&self, angle: S) -> SinCos<S> {
        sin_cos(angle, &SINE_5, &COSINE_6)
    }
}

impl<S: Binary> Trig<S> for Polynomial3 {
    #[inline]
    fn sin_cos(&self, angle: S) -> SinCos<S> {
        sin_cos(angle, &SINE_3, &COSINE_4)
    }
}

#[inline]
fn sin_cos<S: Binary, const A: usize, const B: usize>(angle: S, sine: &[f32; A], cosine: &[f32; B]) -> SinCos<S> {
    angle.symmetric(|angle| {
        let (r, quarter_turns) = angle.reduce();
        let z = r * r;
        // The last step multiplies, so the sine of -0 is -0.
        S::turned(r * horner(sine, z), S::one() + z * horner(cosine, z), quarter_turns)
    })
}

#[inline]
fn horner<S: Binary, const A: usize>(coefficients: &[f32; A], z: S) -> S {
    let term = |c: &f32| S::literal(f64::from(*c));
    let [lower @ .., last] = coefficients.as_slice() else { return S::zero() };
    lower.iter().rev().fold(term(last), |sum, c| term(c) + z * sum)
}
