//! Sine and cosine in C: the operations of `dynamics_core::trig`, with its constants. Tests compare the bits.

use crate::kernel::Precision;
use dynamics_core::trig::{Method, Polynomial};

/// Text of `PREFIX_sin_cos`. A method that is not written in C counts as [`Method::Polynomial`]; [`c_library`](super::c_library) refuses it.
pub(super) fn sin_cos(method: Method, precision: Precision, prefix: &str) -> String {
    let (text, real, overflow) = match precision {
        Precision::Single => (include_str!("single.c"), "float", format!("{:?}f", f32::MAX / Polynomial::LIMIT_F32)),
        Precision::Double => (include_str!("double.c"), "double", format!("{:?}", f64::MAX / Polynomial::LIMIT_F64)),
    };
    let (reduction, polynomials) = parts(method, precision);
    let indented =
        |lines: &[&str]| lines.iter().map(|line| format!("    const {real} {line};")).collect::<Vec<_>>().join("\n");
    text.replace("REDUCTION", &indented(reduction))
        .replace("POLYNOMIALS", &indented(polynomials))
        .replace("OVERFLOW", &overflow)
        .replace("PREFIX", prefix)
}

/// Definitions after the reduction to `k` quarter turns: of the rest `r`, and of `sine` and `cosine`.
fn parts(method: Method, precision: Precision) -> (&'static [&'static str], &'static [&'static str]) {
    match (precision, method) {
        (Precision::Single, Method::Polynomial5) => (&REDUCTION_SHORT_SINGLE, &POLYNOMIAL_5_SINGLE),
        (Precision::Single, Method::Polynomial3) => (&REDUCTION_SHORT_SINGLE, &POLYNOMIAL_3_SINGLE),
        (Precision::Single, _) => (
            &["r = angle - k * 1.5703125f - k * 4.837513e-4f - k * 7.54979e-8f"],
            &[
                "sine = r * (1.0f + z * (-1.6666655e-1f + z * (8.332187e-3f + z * -1.9517896e-4f)))",
                "cosine = 1.0f - (0.5f * z - z * z * (4.1666646e-2f + z * (-1.388731e-3f + z * 2.4432327e-5f)))",
            ],
        ),
        (Precision::Double, Method::Polynomial5) => (&REDUCTION_SHORT_DOUBLE, &POLYNOMIAL_5_DOUBLE),
        (Precision::Double, Method::Polynomial3) => (&REDUCTION_SHORT_DOUBLE, &POLYNOMIAL_3_DOUBLE),
        (Precision::Double, _) => (
            &[
                "coarse = x - k * 1.5707963267341256 - k * 6.077094383272197e-11",
                "fine = k * 6.123233995384610e-17",
                "r = coarse - fine",
                "tail = ((coarse - r) - fine) - k * 3.5215598651832e-27",
            ],
            &[
                "half_z = 0.5 * z",
                "sine_terms = -0.1666666666666663 + z * (0.00833333333332184 + z * (-0.00019841269829358533 + z * (2.755731353851786e-6 + z * (-2.505073439001923e-8 + z * 1.5895433339655842e-10))))",
                "cosine_terms = 0.041666666666666595 + z * (-0.0013888888888873299 + z * (2.4801587288956048e-5 + z * (-2.7557314199610994e-7 + z * (2.087570258028113e-9 + z * -1.1358584301803508e-11))))",
                "sine = r + (r * z * sine_terms + (tail - tail * half_z))",
                "leading = 1.0 - half_z",
                "cosine = leading + (((1.0 - leading) - half_z) + (z * z * cosine_terms - r * tail))",
            ],
        ),
    }
}

const REDUCTION_SHORT_SINGLE: [&str; 1] = ["r = angle - k * 1.5703125f - k * 4.838268e-4f"];
const REDUCTION_SHORT_DOUBLE: [&str; 1] = ["r = x - k * 1.5707963267341256 - k * 6.077100506506192e-11"];

const POLYNOMIAL_5_SINGLE: [&str; 2] = [
    "sine = r * (9.9999493e-1f + z * (-1.6660106e-1f + z * 8.12065e-3f))",
    "cosine = 1.0f + z * (-4.9999893e-1f + z * (4.165616e-2f + z * -1.3595929e-3f))",
];
const POLYNOMIAL_3_SINGLE: [&str; 2] =
    ["sine = r * (9.9902666e-1f + z * -1.6032855e-1f)", "cosine = 1.0f + z * (-4.997752e-1f + z * 4.048604e-2f)"];

/// The coefficients are those of single precision.
const POLYNOMIAL_5_DOUBLE: [&str; 2] = [
    "sine = r * ((double)9.9999493e-1f + z * ((double)-1.6660106e-1f + z * (double)8.12065e-3f))",
    "cosine = 1.0 + z * ((double)-4.9999893e-1f + z * ((double)4.165616e-2f + z * (double)-1.3595929e-3f))",
];
const POLYNOMIAL_3_DOUBLE: [&str; 2] = [
    "sine = r * ((double)9.9902666e-1f + z * (double)-1.6032855e-1f)",
    "cosine = 1.0 + z * ((double)-4.997752e-1f + z * (double)4.048604e-2f)",
];
