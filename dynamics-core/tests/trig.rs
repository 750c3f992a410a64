//! Accuracy of every [`Method`], compared with libm's f64 functions (f32), and of [`Polynomial`], compared with a table of many digits (f64).
//! Bounds hold from both sides: an error above its bound fails, and so does an unexplained smaller error.
#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test may panic, and symmetry is meant to the bit")]

use core::f64::consts::FRAC_PI_4;
use dynamics_core::Real;
use dynamics_core::trig::{Libm, Method, Polynomial, Polynomial3, Polynomial5, SinCos, Table, Trig};
use proptest::prelude::proptest;

/// Results smaller than this have an absolute bound instead of one in units in the last place.
const SMALL: f64 = 1.0 / 256.0;

/// Largest errors over the tested angles.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    absolute_sin: f64,
    absolute_cos: f64,
    ulp_sin: f64,
    ulp_cos: f64,
    absolute_small: f64,
}

impl Worst {
    fn see(&mut self, sin: (f64, f64), cos: (f64, f64), unit: impl Fn(f64) -> f64) {
        let Self { absolute_sin, absolute_cos, ulp_sin, ulp_cos, absolute_small } = self;
        for ((error, truth), absolute, ulp) in [(sin, absolute_sin, ulp_sin), (cos, absolute_cos, ulp_cos)] {
            let error = error.abs();
            *absolute = absolute.max(error);
            if truth.abs() >= SMALL {
                *ulp = ulp.max(error / unit(truth));
            } else {
                *absolute_small = absolute_small.max(error);
            }
        }
    }

    /// The larger of both for each kind of error.
    fn or(self, other: Self) -> Self {
        let [absolute_sin, absolute_cos, ulp_sin, ulp_cos, absolute_small] =
            core::array::from_fn(|i| self.fields()[i].max(other.fields()[i]));
        Self { absolute_sin, absolute_cos, ulp_sin, ulp_cos, absolute_small }
    }

    fn fields(&self) -> [f64; 5] {
        [self.absolute_sin, self.absolute_cos, self.ulp_sin, self.ulp_cos, self.absolute_small]
    }

    /// Asserts that no error is above the stated one, and none below `least` times the stated one.
    fn hold(&self, stated: &[f64; 5], least: f64) {
        for (measured, stated) in self.fields().into_iter().zip(stated) {
            assert!(measured <= *stated, "{measured:e} exceeds the stated {stated:e}: {self:?}");
            assert!(measured >= least * stated, "{measured:e} is far below the stated {stated:e}: {self:?}");
        }
    }
}

/// Spacing of f32 numbers at the size of `x`.
fn unit_f32(x: f64) -> f64 {
    let x = x.abs() as f32;
    f64::from(x.next_up()) - f64::from(x)
}

fn see_f32(worst: &mut Worst, trig: &impl Trig<f32>, angle: f32) {
    let SinCos { sin, cos } = of_either_sign(trig, angle);
    let (true_sin, true_cos) = libm::sincos(f64::from(angle));
    worst.see((f64::from(sin) - true_sin, true_sin), (f64::from(cos) - true_cos, true_cos), unit_f32);
}

/// Range, rad, and its largest errors (absolute sin and cos, ulp sin and cos, absolute for small results), as measured by
/// the exhaustive test for [`Polynomial`] and by the sample for the others, rounded up in the third digit. The
/// documentation of the module repeats them.
const STATED_F32: [(Method, [Range; 4]); 4] = [
    (
        Method::Polynomial,
        [
            (core::f32::consts::FRAC_PI_4, [6.29e-8, 5.87e-8, 1.17, 0.984, 2.23e-10]),
            (2.0 * core::f32::consts::PI, [8.20e-8, 7.80e-8, 1.97, 1.97, 3.33e-10]),
            (100.0, [8.20e-8, 8.12e-8, 1.97, 1.97, 3.33e-10]),
            (Polynomial::LIMIT_F32, [8.20e-8, 8.36e-8, 1.99, 1.98, 3.38e-10]),
        ],
    ),
    (
        Method::Polynomial5,
        [
            (core::f32::consts::FRAC_PI_4, [6.24e-7, 9.49e-8, 85.6, 1.60, 2.00e-8]),
            (2.0 * core::f32::consts::PI, [6.40e-7, 6.33e-7, 85.6, 85.3, 2.00e-8]),
            (100.0, [6.40e-7, 6.40e-7, 86.6, 86.0, 2.06e-8]),
            (Polynomial::LIMIT_F32, [7.09e-7, 7.06e-7, 357.0, 341.0, 1.50e-7]),
        ],
    ),
    (
        Method::Polynomial3,
        [
            (core::f32::consts::FRAC_PI_4, [1.53e-4, 1.25e-5, 1.64e4, 209.0, 3.81e-6]),
            (2.0 * core::f32::consts::PI, [1.53e-4, 1.53e-4, 1.64e4, 1.64e4, 3.81e-6]),
            (100.0, [1.53e-4, 1.53e-4, 1.64e4, 1.64e4, 3.81e-6]),
            (Polynomial::LIMIT_F32, [1.53e-4, 1.53e-4, 1.66e4, 1.65e4, 3.90e-6]),
        ],
    ),
    (
        Method::Table,
        [
            (core::f32::consts::FRAC_PI_4, [8.75e-8, 8.24e-8, 82.9, 1.39, 9.94e-9]),
            (2.0 * core::f32::consts::PI, [8.75e-8, 8.76e-8, 82.9, 82.7, 9.98e-9]),
            (100.0, [8.75e-8, 8.76e-8, 84.0, 84.2, 1.06e-8]),
            (Polynomial::LIMIT_F32, [1.86e-7, 1.86e-7, 356.0, 337.0, 1.38e-7]),
        ],
    ),
];

/// The end of a range of angles, rad, and the largest errors in it.
type Range = (f32, [f64; 5]);

/// Runs a function over parts of a range on all cores.
fn on_all_cores<T: Send>(
    range: core::ops::RangeInclusive<u32>,
    part: impl Fn(core::ops::RangeInclusive<u32>) -> T + Sync,
) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get() as u32);
    let (start, end) = range.into_inner();
    let size = (end - start) / cores + 1;
    std::thread::scope(|scope| {
        let part = &part;
        let parts = (0..cores).map(|core| {
            let first = start + core * size;
            scope.spawn(move || part(first..=end.min(first + (size - 1))))
        });
        parts.collect::<Vec<_>>().into_iter().map(|part| part.join().unwrap()).collect()
    })
}

/// Sine and cosine of an angle. Asserts that those of its negative are the same, except for the sign of the sine.
fn of_either_sign(trig: &impl Trig<f32>, angle: f32) -> SinCos<f32> {
    let (plus, minus) = (trig.sin_cos(angle), trig.sin_cos(-angle));
    assert!(
        plus.sin.to_bits() ^ minus.sin.to_bits() == 1 << 31 && plus.cos.to_bits() == minus.cos.to_bits(),
        "{angle:e}"
    );
    plus
}

/// Up to this angle the computed sine is the angle and the cosine one. The exact values differ by less than `x^3 / 6` and `x^2 / 2`, a twelfth
/// of an ulp and half of one.
const TINY: f32 = 1.0 / 4096.0;

/// Asserts that every so many angles up to the tiny one are their own sine.
fn tiny_angles_are_their_own_sine(stride: usize) {
    on_all_cores(0..=TINY.to_bits(), |bits| {
        for bits in bits.step_by(stride) {
            let SinCos { sin, cos } = of_either_sign(&Polynomial, f32::from_bits(bits));
            assert!(sin.to_bits() == bits && cos == 1.0, "{bits:x}");
        }
    });
}

#[test]
fn f32_angles_up_to_the_tiny_one_are_their_own_sine() {
    // A square of at most 2^-24 vanishes compared with one, for every such angle by the same argument. A sample is enough here; the
    // ignored test checks every angle.
    tiny_angles_are_their_own_sine(499);
}

/// Largest errors of [`Polynomial`] over every float with these bits.
fn worst_of(bits: core::ops::RangeInclusive<u32>) -> Worst {
    let parts = on_all_cores(bits, |bits| {
        let mut worst = Worst::default();
        for bits in bits {
            see_f32(&mut worst, &Polynomial, f32::from_bits(bits));
        }
        worst
    });
    parts.into_iter().fold(Worst::default(), Worst::or)
}

#[test]
fn f32_errors_over_every_other_float_up_to_a_turn_are_the_stated_ones() {
    let (_, ranges) = STATED_F32[0];
    let (turn, stated) = &ranges[1];
    worst_of(TINY.to_bits()..=turn.to_bits()).hold(stated, 0.99);
}

#[test]
#[ignore = "1.2e9 angles, half a minute; `cargo xtask test` runs it, or cargo nextest run -p dynamics-core --run-ignored only"]
fn f32_errors_over_every_float_are_the_stated_ones() {
    tiny_angles_are_their_own_sine(1);
    let mut worst = Worst::default();
    let mut next = TINY.to_bits();
    for (end, stated) in STATED_F32[0].1 {
        worst = worst.or(worst_of(next..=end.to_bits()));
        next = end.to_bits() + 1;
        println!("{end}: {:?}", worst.fields().map(|error| format!("{error:.3e}")));
        worst.hold(&stated, 0.99);
    }
}

#[test]
fn f32_errors_of_a_sample_are_the_stated_ones() {
    for (method, ranges) in &STATED_F32 {
        for (end, stated) in ranges {
            let mut worst = Worst::default();
            let mut see = |angle| see_f32(&mut worst, method, angle);
            // First evenly spread over the float patterns, that is over magnitudes; then evenly over the range.
            let stride = 1_009;
            (0..=end.to_bits()).step_by(stride).for_each(|bits| see(f32::from_bits(bits)));
            (0..=400_000_u32).for_each(|i| see(end * (i as f32 / 400_000.0)));
            quarter_turn_neighbours(*end).for_each(see);
            // A sample may miss the worst float.
            worst.hold(stated, 0.85);
        }
    }
}

/// The floats within three steps of every multiple of pi/4 up to `end`: the zeros, and where the quadrant changes.
fn quarter_turn_neighbours(end: f32) -> impl Iterator<Item = f32> {
    let multiples = (f64::from(end) / FRAC_PI_4) as u32;
    (1..=multiples)
        .flat_map(|k| {
            let nearest = (f64::from(k) * FRAC_PI_4) as f32;
            (0..7).map(move |step| f32::from_bits(nearest.to_bits() - 3 + step))
        })
        .filter(move |angle| *angle <= end)
}

/// An f64 angle with its sine and cosine, each as a sum of two f64.
struct Row {
    angle: f64,
    sin: (f64, f64),
    cos: (f64, f64),
}

/// Output of `tools/minimax.py reference`.
fn reference() -> Vec<Row> {
    let float = |hex: &str| f64::from_bits(u64::from_str_radix(hex, 16).unwrap());
    include_str!("trig_reference.txt")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            let [angle, s, s_rest, c, c_rest] = line.split(' ').map(float).collect::<Vec<_>>().try_into().unwrap();
            Row { angle, sin: (s, s_rest), cos: (c, c_rest) }
        })
        .collect()
}

/// Spacing of f64 numbers at the size of `x`.
fn unit_f64(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}

#[test]
fn f64_results_are_within_an_ulp_of_the_reference_at_zeros_and_everywhere_else() {
    let rows = reference();
    assert!(rows.len() > 1_500);
    let mut worst = 0.0_f64;
    for Row { angle, sin, cos } in rows {
        let ours = Polynomial.sin_cos(angle);
        for (ours, (near, rest)) in [(ours.sin, sin), (ours.cos, cos)] {
            let error = ((ours - near) - rest).abs() / unit_f64(near);
            assert!(error < STATED_F64[2].max(STATED_F64[3]), "{angle:e}: {ours:e} for {near:e}");
            worst = worst.max(error);
        }
    }
    // The rounding of the result alone is half an ulp.
    assert!(worst > 0.5);
}

/// As in [`STATED_F32`], for |angle| up to [`Polynomial::LIMIT_F64`], from the sample below.
const STATED_F64: [f64; 5] = [8.45e-17, 8.59e-17, 0.77, 0.78, 2.19e-19];

#[test]
fn f64_errors_of_a_sample_are_the_stated_ones() {
    let mut worst = Worst::default();
    for Row { angle, sin, cos } in reference().iter().filter(|row| row.angle.abs() > 1.0 / 64.0) {
        for step in -150..=150 {
            // Near an angle of the table the exact value follows by the addition theorem, with a small loss: |d| < 2^-14.
            let near = (angle + f64::from(step) * 3.9e-7).clamp(-Polynomial::LIMIT_F64, Polynomial::LIMIT_F64);
            let d = near - angle;
            let sin_d = d - d * d * d / 6.0 + d * d * d * d * d / 120.0;
            let cos_d_less_one = -d * d / 2.0 + d * d * d * d / 24.0;
            let sin_moves = cos.0 * sin_d + sin.0 * cos_d_less_one;
            let cos_moves = cos.0 * cos_d_less_one - sin.0 * sin_d;
            let ours = Polynomial.sin_cos(near);
            let error = |ours: f64, (near, rest): (f64, f64), moves| ((ours - near) - moves) - rest;
            worst.see(
                (error(ours.sin, *sin, sin_moves), sin.0 + sin_moves),
                (error(ours.cos, *cos, cos_moves), cos.0 + cos_moves),
                unit_f64,
            );
        }
    }
    worst.hold(&STATED_F64, 0.97);
}

/// f32 angles of every size, subnormal to the limit, with the multiples of pi/4.
fn angles_f32() -> impl Iterator<Item = f32> {
    (0..=Polynomial::LIMIT_F32.to_bits())
        .step_by(10_007)
        .map(f32::from_bits)
        .chain([0.0, f32::from_bits(1), f32::MIN_POSITIVE, Polynomial::LIMIT_F32])
        .chain(quarter_turn_neighbours(Polynomial::LIMIT_F32))
}

/// f64 angles of every size, subnormal to the limit.
fn angles_f64() -> impl Iterator<Item = f64> {
    (0..=Polynomial::LIMIT_F64.to_bits())
        .step_by(47_000_000_000_017)
        .map(f64::from_bits)
        .chain([0.0, f64::from_bits(1), f64::MIN_POSITIVE, Polynomial::LIMIT_F64])
        .chain(reference().into_iter().map(|row| row.angle.abs()))
}

#[test]
fn sine_is_odd_and_cosine_even_to_the_bit() {
    for angle in angles_f32() {
        let (plus, minus) = (Polynomial.sin_cos(angle), Polynomial.sin_cos(-angle));
        assert_eq!((-plus.sin).to_bits(), minus.sin.to_bits(), "sin {angle:e}");
        assert_eq!(plus.cos.to_bits(), minus.cos.to_bits(), "cos {angle:e}");
    }
    for angle in angles_f64() {
        let (plus, minus) = (Polynomial.sin_cos(angle), Polynomial.sin_cos(-angle));
        assert_eq!((-plus.sin).to_bits(), minus.sin.to_bits(), "sin {angle:e}");
        assert_eq!(plus.cos.to_bits(), minus.cos.to_bits(), "cos {angle:e}");
    }
}

#[test]
fn squares_add_up_to_one_and_no_result_exceeds_one() {
    for angle in angles_f32() {
        let SinCos { sin, cos } = Polynomial.sin_cos(angle);
        let (sin, cos) = (f64::from(sin), f64::from(cos));
        assert!((sin * sin + cos * cos - 1.0).abs() < 1.8e-7, "{angle:e}");
        assert!(sin.abs() <= 1.0 && cos.abs() <= 1.0, "{angle:e}");
    }
    for angle in angles_f64() {
        let SinCos { sin, cos } = Polynomial.sin_cos(angle);
        assert!((sin * sin + cos * cos - 1.0).abs() < 5e-16, "{angle:e}");
        assert!(sin.abs() <= 1.0 && cos.abs() <= 1.0, "{angle:e}");
    }
}

#[test]
fn tiny_angles_are_their_own_sine_with_sign() {
    for angle in [0.0_f32, -0.0, f32::from_bits(1), -f32::from_bits(77), f32::MIN_POSITIVE, -1e-20, 1e-5] {
        let SinCos { sin, cos } = Polynomial.sin_cos(angle);
        assert_eq!((sin.to_bits(), cos), (angle.to_bits(), 1.0), "{angle:e}");
    }
    for angle in [0.0_f64, -0.0, f64::from_bits(1), -f64::from_bits(77), f64::MIN_POSITIVE, -1e-200, 1e-9] {
        let SinCos { sin, cos } = Polynomial.sin_cos(angle);
        assert_eq!((sin.to_bits(), cos), (angle.to_bits(), 1.0), "{angle:e}");
    }
}

#[test]
fn beyond_the_limit_both_are_nan_and_at_the_limit_neither() {
    let single = Polynomial::LIMIT_F32;
    for angle in [single.next_up(), 1e30, f32::MAX, f32::INFINITY, f32::NAN, f32::from_bits(0x7f80_0001)] {
        for angle in [angle, -angle] {
            let SinCos { sin, cos } = Polynomial.sin_cos(angle);
            assert!(sin.is_nan() && cos.is_nan(), "{angle:e}");
        }
    }
    let double = Polynomial::LIMIT_F64;
    for angle in [double.next_up(), 1e300, f64::MAX, f64::INFINITY, f64::NAN] {
        for angle in [angle, -angle] {
            let SinCos { sin, cos } = Polynomial.sin_cos(angle);
            assert!(sin.is_nan() && cos.is_nan(), "{angle:e}");
        }
    }
    assert!(Polynomial.sin_cos(single).sin.is_finite() && Polynomial.sin_cos(-single).cos.is_finite());
    assert!(Polynomial.sin_cos(double).sin.is_finite() && Polynomial.sin_cos(-double).cos.is_finite());
}

/// The bits, with all NaNs treated as equal: which NaN results is not specified.
fn bits<S: Real>(both: SinCos<S>) -> [u64; 2] {
    [both.sin, both.cos].map(|x| if x.is_finite() { x.to_f64().to_bits() } else { f64::NAN.to_bits() })
}

/// Asserts the same bits for `N` angles computed all at once, as a list, and one by one.
fn assert_same_bits<S: Real, const N: usize>(trig: &impl Trig<S>, angles: [S; N]) {
    let single = angles.map(|angle| bits(trig.sin_cos(angle)));
    assert_eq!(trig.sin_cos_all(&angles).map(bits), single, "{angles:?}");
    let (mut sin, mut cos) = ([S::zero(); N], [S::zero(); N]);
    trig.sin_cos_lists(&angles, &mut sin, &mut cos);
    let listed = core::array::from_fn(|i| bits(SinCos { sin: sin[i], cos: cos[i] }));
    assert_eq!(listed, single, "{angles:?}");
}

proptest! {
    #[test]
    fn all_at_once_have_the_bits_of_one_by_one(
        any32 in proptest::array::uniform6(proptest::num::f32::ANY), any64 in proptest::array::uniform6(proptest::num::f64::ANY),
        usual in proptest::array::uniform6(-10.0..10.0), large in proptest::array::uniform32(-9e3..9e3),
    ) {
        for trig in METHODS {
            assert_same_bits(&trig, any32);
            assert_same_bits(&trig, any64);
            assert_same_bits(&trig, usual);
            assert_same_bits(&trig, usual.map(|x| x as f32));
            assert_same_bits(&trig, large);
            assert_same_bits(&trig, large.map(|x| x as f32));
            let [a, b, c, d, e, _] = any64;
            assert_same_bits(&trig, [a]);
            assert_same_bits(&trig, [a, b]);
            assert_same_bits(&trig, [a, b, c]);
            assert_same_bits(&trig, [a, b, c, d]);
            assert_same_bits(&trig, [a, b, c, d, e]);
        }
    }
}

#[test]
fn special_angles_side_by_side_have_the_bits_that_they_have_alone() {
    let (single, double) = (Polynomial::LIMIT_F32, Polynomial::LIMIT_F64);
    assert_same_bits(&Polynomial, [f32::NAN, -0.0, f32::INFINITY, single, -single.next_up(), 0.0, 1.0, -single]);
    assert_same_bits(&Polynomial, [f64::NAN, -0.0, f64::INFINITY, double, -double.next_up(), 0.0, 1.0, -double]);
}

#[test]
fn lists_are_filled_as_far_as_the_shortest_goes() {
    let (mut sin, mut cos) = ([7.0; 3], [7.0; 4]);
    Polynomial.sin_cos_lists(&[0.5; 5], &mut sin, &mut cos[..2]);
    let SinCos { sin: s, cos: c } = Polynomial.sin_cos(0.5);
    assert_eq!((sin, cos), ([s, s, 7.0], [c, c, 7.0, 7.0]));
}

const METHODS: [Method; 5] =
    [Method::Polynomial, Method::Polynomial5, Method::Polynomial3, Method::Table, Method::Libm];

#[test]
fn a_method_chosen_at_run_time_gives_the_bits_of_the_one_it_names() {
    fn same<S: Real>(trig: impl Trig<S>, method: Method, angles: [S; 6])
    where
        Method: Trig<S>,
    {
        for step in [0.0, 0.01, 0.02, 1.0] {
            let angles = angles.map(|angle| angle + S::literal(step));
            assert_eq!(method.sin_cos_all(&angles), trig.sin_cos_all(&angles), "{method:?}");
        }
    }
    assert_eq!(Method::default(), Method::Polynomial);
    let angles = [-3.0, -0.1, 0.0, 0.7, 2.0, 6.0];
    same(Polynomial, Method::Polynomial, angles);
    same(Polynomial5, Method::Polynomial5, angles);
    same(Polynomial3, Method::Polynomial3, angles);
    same(Table, Method::Table, angles);
    same(Libm, Method::Libm, angles);
    let angles = angles.map(|angle| angle as f32);
    same(Polynomial, Method::Polynomial, angles);
    same(Polynomial5, Method::Polynomial5, angles);
    same(Polynomial3, Method::Polynomial3, angles);
    same(Table, Method::Table, angles);
    same(Libm, Method::Libm, angles);
    // No two methods have the same rounding errors: over many angles they must differ somewhere.
    for (i, one) in METHODS.iter().enumerate() {
        for other in &METHODS[..i] {
            assert!(angles_f32().any(|angle| one.sin_cos(angle) != other.sin_cos(angle)), "{one:?} and {other:?}");
        }
    }
}

/// As in [`STATED_F32`], sine and cosine, absolute, for f64 angles of every size: the error of the coefficients and
/// entries.
const STATED_SHORT_F64: [(Method, f64, f64); 3] = [
    (Method::Polynomial5, 5.70e-7, 5.70e-7),
    (Method::Polynomial3, 1.53e-4, 1.53e-4),
    (Method::Table, 5.90e-8, 5.90e-8),
];

#[test]
fn f64_errors_of_the_lesser_methods_are_the_stated_ones() {
    for (method, stated_sin, stated_cos) in STATED_SHORT_F64 {
        let (mut worst_sin, mut worst_cos) = (0.0_f64, 0.0_f64);
        let spread = (0..400_000).map(|i| f64::from(i) * 2.5);
        for angle in angles_f64().chain(spread).chain((0..400_000).map(|i| f64::from(i) * 1.6e-5)) {
            let (plus, minus) = (method.sin_cos(angle), method.sin_cos(-angle));
            assert_eq!((-plus.sin).to_bits(), minus.sin.to_bits(), "{method:?}: sin {angle:e}");
            assert_eq!(plus.cos.to_bits(), minus.cos.to_bits(), "{method:?}: cos {angle:e}");
            let (sin, cos) = libm::sincos(angle);
            worst_sin = worst_sin.max((plus.sin - sin).abs());
            worst_cos = worst_cos.max((plus.cos - cos).abs());
        }
        for (worst, stated) in [(worst_sin, stated_sin), (worst_cos, stated_cos)] {
            assert!(worst <= stated && worst >= 0.97 * stated, "{method:?}: {worst:e} for the stated {stated:e}");
        }
    }
}

#[test]
fn every_method_gives_nan_beyond_the_limit_alone_and_keeps_the_sign_of_zero() {
    for method in METHODS {
        for angle in [Polynomial::LIMIT_F32.next_up(), 1e30, f32::INFINITY, f32::NAN, f32::from_bits(0x7f80_0001)] {
            for angle in [angle, -angle] {
                let SinCos { sin, cos } = method.sin_cos(angle);
                assert!(sin.is_nan() && cos.is_nan(), "{method:?} {angle:e}");
                // libm continues in f64, where such angles still have digits left.
                let SinCos { sin, cos } = method.sin_cos(f64::from(angle) * 128.0);
                let exact = method == Method::Libm && angle.is_finite();
                assert!(sin.is_nan() != exact && cos.is_nan() != exact, "{method:?} {angle:e}");
            }
        }
        for limit in [Polynomial::LIMIT_F32, -Polynomial::LIMIT_F32] {
            assert!(method.sin_cos(limit).sin.is_finite() && method.sin_cos(limit).cos.is_finite(), "{method:?}");
        }
        for zero in [0.0_f32, -0.0] {
            let SinCos { sin, cos } = method.sin_cos(zero);
            assert_eq!((sin.to_bits(), cos), (zero.to_bits(), 1.0), "{method:?}");
            let SinCos { sin, cos } = method.sin_cos(f64::from(zero));
            assert_eq!((sin.to_bits(), cos), (f64::from(zero).to_bits(), 1.0), "{method:?}");
        }
    }
}

#[test]
fn libm_is_itself_inside_the_limit() {
    for angle in angles_f32().flat_map(|angle| [angle, -angle]) {
        let (sin, cos) = libm::sincosf(angle);
        let found = Libm.sin_cos(angle);
        assert_eq!((found.sin.to_bits(), found.cos.to_bits()), (sin.to_bits(), cos.to_bits()), "{angle:e}");
    }
}

#[test]
fn the_second_order_is_the_better_use_of_a_table() {
    // The same 512 entries of a turn, in f64: linear interpolation between two of them, and the first order about the nearest.
    let step = core::f64::consts::TAU / 512.0;
    let (mut line, mut first, mut second) = (0.0_f64, 0.0_f64, 0.0_f64);
    for i in 0..100_000 {
        let angle = f64::from(i) * 6e-5;
        let entry = |k: f64| f64::from((k * step).sin() as f32);
        let (truth, k) = (libm::sin(angle), (angle / step).floor());
        let share = angle / step - k;
        line = line.max((entry(k) + share * (entry(k + 1.0) - entry(k)) - truth).abs());
        let k = (angle / step).round();
        let d = angle - k * step;
        first = first.max((entry(k) + d * entry(k + 128.0) - truth).abs());
        second = second.max((Table.sin_cos(angle).sin - truth).abs());
    }
    assert!((1.8e-5..1.93e-5).contains(&line) && (1.8e-5..1.93e-5).contains(&first), "{line:e} {first:e}");
    assert!(second < line / 100.0, "{second:e}");
}

#[test]
fn by_arithmetic_alone_sine_and_cosine_are_equal_to_those_by_bits() {
    let spaced = (0..200_000).map(|k| f64::from(k) * 0.013_7 - 1_300.0);
    for angle in angles_f64().chain(spaced).filter(|angle| angle.abs() <= Polynomial::LIMIT_F64) {
        let (found, wanted) = (Polynomial::by_arithmetic(angle), Polynomial.sin_cos(angle));
        assert_eq!((found.sin, found.cos), (wanted.sin, wanted.cos), "{angle:e}");
    }
}
