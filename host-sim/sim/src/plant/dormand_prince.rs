//! A step of Dormand and Prince's embedded pair, and the length of the next one.

use super::curve::Curve;
use super::flow::{Dry, Flow};
use super::state::{Lanes, Point};

/// `start + slope * h`.
#[inline(always)]
pub(super) fn along<Y: Point<N, L>, const N: usize, const L: usize>(start: &Y, slope: &Y, h: &[f64; L]) -> Y {
    start.combine([slope], |lane, x, [k]| x + k * h[lane])
}

/// `sum a_i k_i`.
#[inline(always)]
pub(super) fn sum<const K: usize>(a: [f64; K], k: [f64; K]) -> f64 {
    a.into_iter().zip(k).fold(0.0, |sum, (a, k)| sum + a * k)
}

/// A step of the embedded pair: the fifth-order points, their slopes, and the errors of the fourth-order points relative to the tolerances. If an
/// event ends the step, the points are those at the first event, with the fractions of the step.
pub(super) struct EmbeddedPair<Y, const L: usize> {
    pub(super) end: Y,
    pub(super) slope: Y,
    pub(super) error: [f64; L],
    pub(super) part: Option<[f64; L]>,
}

/// One step of Dormand and Prince's pair from `t` of length `h`. (J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta
/// formulae, 1980.)
#[inline(always)]
pub(super) fn dormand_prince<Y: Point<N, L>, F: Flow<Y, N, L>, const N: usize, const L: usize>(
    flow: &F,
    (start, k1): (&Y, &Y),
    (t, h): (&[f64; L], &[f64; L]),
    tolerance: &[f64; L],
    (dry, among): (&mut Dry<N, L>, [bool; L]),
    lanes: &mut Lanes<L>,
) -> EmbeddedPair<Y, L> {
    // Every slope is written before it is read.
    let [mut k2, mut k3, mut k4, mut k5, mut k6, mut k7] = [*k1; 6];
    let mut slope = |c: f64, at: &Y, k: &mut Y| {
        if !lanes.over() {
            flow.slope(at, &flow.input(&core::array::from_fn(|lane| t[lane] + c * h[lane])), dry, k, lanes);
        }
    };
    slope(1.0 / 5.0, &along(start, k1, &h.map(|h| h / 5.0)), &mut k2);
    let at = start.combine([k1, &k2], |lane, x, k| x + h[lane] * sum([3.0 / 40.0, 9.0 / 40.0], k));
    slope(3.0 / 10.0, &at, &mut k3);
    const A4: [f64; 3] = [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0];
    slope(4.0 / 5.0, &start.combine([k1, &k2, &k3], |lane, x, k| x + h[lane] * sum(A4, k)), &mut k4);
    const A5: [f64; 4] = [19_372.0 / 6561.0, -25_360.0 / 2187.0, 64_448.0 / 6561.0, -212.0 / 729.0];
    slope(8.0 / 9.0, &start.combine([k1, &k2, &k3, &k4], |lane, x, k| x + h[lane] * sum(A5, k)), &mut k5);
    const A6: [f64; 5] = [9017.0 / 3168.0, -355.0 / 33.0, 46_732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18_656.0];
    slope(1.0, &start.combine([k1, &k2, &k3, &k4, &k5], |lane, x, k| x + h[lane] * sum(A6, k)), &mut k6);
    const B5: [f64; 5] = [35.0 / 384.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
    let end = start.combine([k1, &k3, &k4, &k5, &k6], |lane, x, k| x + h[lane] * sum(B5, k));
    slope(1.0, &end, &mut k7);
    // The weights of fifth order less the weights of fourth.
    const E: [f64; 6] =
        [71.0 / 57_600.0, -71.0 / 16_695.0, 71.0 / 1920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
    let error = start.combine([&end, k1, &k3, &k4, &k5, &k6, &k7], |lane, x, [end, k @ ..]| {
        // Equal to `f64::max`, because `x` is not NaN. There is no vector instruction for `f64::max`.
        let size = if end.abs() > x.abs() { end.abs() } else { x.abs() };
        h[lane] * sum(E, k) / (tolerance[lane] * (1.0 + size))
    });
    let error = error.largest();
    let curve = Curve { start, end: &end, first: k1, last: Some(&k7), fourth: None, h };
    let Some(events) = flow.rough().and_then(|_| dry.events(&curve, among)) else {
        return EmbeddedPair { end, slope: k7, error, part: None };
    };
    // The interpolant of fourth order (L. F. Shampine, Some practical Runge-Kutta formulas, 1986).
    const D: [f64; 6] = [
        -12_715_105_075.0 / 11_282_082_432.0,
        87_487_479_700.0 / 32_700_410_799.0,
        -10_690_763_975.0 / 1_880_347_072.0,
        701_980_252_875.0 / 199_316_789_632.0,
        -1_453_857_185.0 / 822_651_844.0,
        69_997_945.0 / 29_380_423.0,
    ];
    let fourth = start.combine([k1, &k3, &k4, &k5, &k6, &k7], |lane, _, k| h[lane] * sum(D, k));
    let curve = Curve { fourth: Some(&fourth), ..curve };
    let events = dry.events(&curve, among).unwrap_or(events);
    EmbeddedPair { end: events.cut(&curve), slope: k7, error, part: Some(events.part) }
}

/// Ratio of the next step to this one: `0.9 error^(-1/5)`, limited to 1/5 to 5.
pub(super) fn factor(error: f64) -> f64 {
    // Below this error the power exceeds the limit and need not be computed.
    const SURELY_FIVE: f64 = 1.8e-4;
    if error < SURELY_FIVE {
        5.0
    } else if error.is_finite() {
        (0.9 * libm::pow(error, -0.2)).clamp(0.2, 5.0)
    } else {
        0.2
    }
}
