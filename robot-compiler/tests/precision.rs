//! The reference more precise than f64 and the bound on rounding errors: both hold, and the tests detect wrong ones.
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]
#![allow(clippy::float_cmp, reason = "what double-double holds is exact")]

use dynamics_core::{
    Body, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Rotor, Scalar, Scene, SinCos,
    Term, Tool,
};
use nalgebra::{Matrix3, Vector3};
use num_traits::{One, Zero};
use robot_compiler::precision::{Bounded, Double, DoubleDouble, Rounding, Single};
use serde_json::Value;

#[path = "common/wrong_rounding.rs"]
mod wrong_rounding;

use crate::common::top;
use wrong_rounding::{FreeProducts, QuarterUnit};

fn dd(x: f64) -> DoubleDouble {
    DoubleDouble::literal(x)
}

#[test]
fn a_double_double_holds_twice_the_digits() {
    let tiny = dd(f64::EPSILON * f64::EPSILON);
    assert_eq!((DoubleDouble::one() + tiny).minus(1.0), f64::EPSILON * f64::EPSILON);
    // (1 + e)^2 = 1 + 2 e + e^2, to the last term.
    let near = dd(1.0 + f64::EPSILON);
    assert_eq!((near * near).minus(1.0 + 2.0 * f64::EPSILON), f64::EPSILON * f64::EPSILON);
    let third = DoubleDouble::one() / dd(3.0);
    assert!((third * dd(3.0)).minus(1.0).abs() < 1e-31);
}

#[test]
fn sine_and_cosine_agree_with_sixty_digits_to_the_thirtieth() {
    let text = std::fs::read_to_string(top("dynamics-core/tests/trig_reference.txt")).unwrap();
    let (mut count, mut worst) = (0, 0.0_f64);
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let bits = |word: &str| f64::from_bits(u64::from_str_radix(word, 16).unwrap());
        let numbers: Vec<f64> = line.split_whitespace().map(bits).collect();
        let &[angle, sin, sin_rest, cos, cos_rest] = numbers.as_slice() else { unreachable!("{line}") };
        let found = DoubleDouble::sin_cos(angle);
        for (found, wanted, rest) in [(found.sin, sin, sin_rest), (found.cos, cos, cos_rest)] {
            worst = worst.max((found - DoubleDouble::sum(wanted, rest)).to_f64().abs());
        }
        count += 1;
    }
    println!("{count} angles: {worst:e}");
    assert!(count > 1000);
    assert!(worst < 1e-30 && worst > 1e-33, "{worst:e}");
}

/// A joint about z with its link along x.
fn rod(mass: f64, centre: f64, inertia: f64, at: f64) -> JointSpec {
    JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::Placement {
            rotation: Matrix3::identity(),
            translation: Vector3::new(at, 0.0, 0.0),
            axis: Vector3::z(),
        },
        body: Body {
            mass,
            com: Vector3::new(centre, 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.0, inertia, inertia)),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    }
}

/// Torques by the recursion in double-double arithmetic, including sine and cosine.
fn torques<const N: usize>(
    model: &Model<f64, N>,
    gravity: Vector3<f64>,
    [q, qd, qdd]: [[f64; N]; 3],
) -> [DoubleDouble; N] {
    let scene = Scene { gravity: Term::Constant(gravity), ..Scene::free_space() };
    let dynamics = Dynamics::new(model.cast::<DoubleDouble>(), scene.cast());
    let turn = q.map(DoubleDouble::sin_cos);
    dynamics.inverse_dynamics(&turn, &q.map(dd), &qd.map(dd), &qdd.map(dd), &Live::zero())
}

/// Position, velocity, acceleration of two joints.
type Motion = [[f64; 2]; 3];

/// Two rods in a plane, all numbers exact in binary, by `tau = D qdd + C qd + G` with 60 digits (mpmath). Each torque is
/// given as the nearest f64 and the f64 nearest to the remainder.
const PLANAR: [(Motion, [(f64, f64); 2]); 3] = [
    (
        [[0.75, -1.25], [2.0, -3.5], [4.0, -7.0]],
        [(28.705196877213023, -1.2758478244963725e-15), (1.8099861977655045, 1.8490993785055058e-17)],
    ),
    (
        [[-3.0, 2.5], [-1.5, 6.25], [-20.0, 11.5]],
        [(-60.881100993032696, -2.732536242341761e-15), (8.414642571395698, -5.941915257582992e-16)],
    ),
    (
        [[100.25, -7.0], [0.5, 0.125], [0.0, 1.0]],
        [(26.037961721527576, 9.956657597753676e-16), (2.0896713532362643, -7.002791504359473e-17)],
    ),
];

#[test]
fn the_recursion_agrees_with_sixty_digits_to_the_twenty_eighth() {
    let rods = [rod(2.0, 0.5, 0.125, 0.0), rod(1.5, 0.25, 0.0625, 1.0)];
    let model = Model::new(&rods, &Tool::default()).unwrap();
    for (state, wanted) in PLANAR {
        let found = torques(&model, Vector3::new(0.0, -9.8125, 0.0), state);
        for (found, (wanted, rest)) in found.into_iter().zip(wanted) {
            let error = (found - DoubleDouble::sum(wanted, rest)).to_f64().abs();
            assert!(error < 1e-28, "{error:e}");
        }
    }
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    core::array::from_fn(|i| value[i].as_f64().unwrap())
}

fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| value[r][c].as_f64().unwrap())
}

/// The arm of a golden file, from its placements.
fn golden_model<const N: usize>(data: &Value) -> Model<f64, N> {
    let joints: [JointSpec; N] = core::array::from_fn(|i| {
        let joint = &data["joints"][i];
        JointSpec {
            kind: if joint["type"] == "R" { JointKind::Revolute } else { JointKind::Prismatic },
            frame: Frame::Placement {
                rotation: matrix(&joint["placement_R"]),
                translation: numbers::<3>(&joint["placement_p"]).into(),
                axis: numbers::<3>(&joint["axis"]).into(),
            },
            body: Body {
                mass: joint["mass"].as_f64().unwrap(),
                com: numbers::<3>(&joint["com"]).into(),
                inertia: matrix(&joint["inertia_com"]),
            },
            rotor: Rotor::default(),
            limits: Limits::none(),
        }
    });
    Model::new_unphysical(&joints, &Tool::default()).unwrap()
}

/// Largest difference from the golden torques, relative to the largest torque of the state.
fn golden_error<const N: usize>(name: &str) -> f64 {
    let text = std::fs::read_to_string(top(&format!("robots/golden/{name}.json"))).unwrap();
    let data: Value = serde_json::from_str(&text).unwrap();
    let model = golden_model::<N>(&data);
    let gravity = numbers::<3>(&data["gravity"]).into();
    let mut worst = 0.0_f64;
    for state in data["states"].as_array().unwrap() {
        let found = torques(&model, gravity, ["q", "qd", "qdd"].map(|key| numbers::<N>(&state[key])));
        let wanted = numbers::<N>(&state["tau"]);
        let size = wanted.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        for (found, wanted) in found.into_iter().zip(wanted) {
            worst = worst.max(found.minus(wanted).abs() / size);
        }
    }
    println!("{name}: {worst:e}");
    worst
}

#[test]
fn the_golden_torques_agree_to_the_digits_that_are_printed() {
    // The printed value and the model's own numbers (bodies moved to the joints) are rounded to f64: about 1.1e-16 each. The
    // axes of the random arm have arbitrary directions, and its model's frames are turned onto them in f64.
    for (name, error, allowed) in [
        ("planar2r", golden_error::<2>("planar2r"), 4e-16),
        ("puma560", golden_error::<6>("puma560"), 2e-16),
        ("scara", golden_error::<4>("scara"), 2e-16),
        ("random6_generic", golden_error::<6>("random6_generic"), 4e-15),
    ] {
        assert!(error < allowed, "{name}: {error:e}");
    }
}

/// Error of `count` additions of `x` to 1 in f32, and the bound for numbers from 0 to `x` in each of them.
fn chain<R: Rounding>(count: usize, x: f32) -> (f64, f64) {
    let mut single = 1.0_f32;
    let mut exact = dd(1.0);
    let mut bounded = Bounded::<R>::exact(1.0, 1.0);
    for _ in 0..count {
        single += x;
        exact += dd(f64::from(x));
        bounded += Bounded::exact(0.0, f64::from(x));
    }
    (exact.minus(f64::from(single)).abs(), bounded.error())
}

/// Half the distance from 1 to the next f32: a tie, which rounds back to 1 every time, the worst case.
const TIE: f32 = 1.0 / (1 << 24) as f32;

#[test]
fn on_a_chain_of_additions_the_bound_is_the_worst_case() {
    for count in [1, 10, 1000] {
        let (found, bound) = chain::<Single>(count, TIE);
        assert_eq!(found, count as f64 * f64::from(TIE));
        assert!(bound >= found && bound < found * (1.0 + 1e-9), "{count}: {found:e}, {bound:e}");
    }
}

#[test]
fn a_unit_that_is_too_small_is_caught() {
    let (found, bound) = chain::<QuarterUnit>(1000, TIE);
    assert!(found > 3.9 * bound, "{found:e}, {bound:e}");
}

/// `a b + c` in f32: the error, and the bound.
fn product_and_sum<R: Rounding>([a, b, c]: [f32; 3]) -> (f64, f64) {
    let exact = dd(f64::from(a)) * dd(f64::from(b)) + dd(f64::from(c));
    let [x, y, z] = [a, b, c].map(|x| Bounded::<R>::exact(f64::from(x), f64::from(x)));
    (exact.minus(f64::from(a * b + c)).abs(), (x * y + z).error())
}

#[test]
fn the_missing_error_of_one_product_is_caught() {
    let mut caught = 0;
    for i in 0..1000 {
        let x = 1.0 + i as f32 * 1.1e-3;
        // The sum is exact: it cancels most of the product.
        let numbers = [x, x, -(x * x * 0.75)];
        let (found, bound) = product_and_sum::<Single>(numbers);
        assert!(found <= bound, "{numbers:?}: {found:e}, {bound:e}");
        let (_, without) = product_and_sum::<FreeProducts>(numbers);
        caught += usize::from(found > without);
    }
    assert!(caught > 100, "{caught}");
}

#[test]
fn sines_and_cosines_of_a_range_enclose_those_of_its_angles() {
    for (lo, hi) in [(0.1, 0.2), (-0.3, 1.8), (3.0, 3.3), (-7.0, -1.4), (100.0, 101.0), (2.5, 2.5), (-1e3, 1e3)] {
        let SinCos { sin, cos } = Bounded::<Single>::sin_cos(0, (lo, hi), (1e-7, 2e-7));
        assert_eq!((sin.error(), cos.error()), (1e-7, 2e-7));
        let mut seen = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        for k in 0..=10_000 {
            let angle = lo + (hi - lo) * f64::from(k) / 10_000.0;
            for (bounded, (value, seen)) in [sin, cos].iter().zip([angle.sin(), angle.cos()].into_iter().zip(&mut seen))
            {
                let (low, high) = bounded.interval();
                assert!((low..=high).contains(&value), "{angle}: {value} outside {low}..{high}");
                *seen = (seen.0.min(value), seen.1.max(value));
            }
        }
        for (bounded, (low, high)) in [sin, cos].iter().zip(seen) {
            let wider = (low - bounded.interval().0).max(bounded.interval().1 - high);
            assert!(wider < 0.02, "{lo}..{hi}: wider by {wider}");
        }
    }
}

#[test]
fn a_turned_vector_is_bounded_by_its_length_and_by_its_error() {
    let SinCos { sin, cos } = Bounded::<Single>::sin_cos(3, (-4.0, 4.0), (0.0, 0.0));
    let (x, y) = (Bounded::within(-3.0, 3.0, 0.03), Bounded::within(-4.0, 4.0, 0.04));
    let turned = cos * x + sin * y;
    // The corner of the box is 5 from the origin, and its error is 0.05 long; plain intervals give 7 and 0.07.
    assert!((turned.interval().1 - 5.0).abs() < 1e-12 && (turned.error() - 0.05).abs() < 2e-6, "{turned:?}");
    // With two joints, both terms may be at their maximum.
    let other = Bounded::<Single>::sin_cos(4, (-4.0, 4.0), (0.0, 0.0)).sin;
    let both = cos * x + other * y;
    assert!((both.interval().1 - 7.0).abs() < 1e-12 && both.error() > 0.07, "{both:?}");
    // The same holds for the same cosine twice, or for a doubled sine.
    assert!((cos * x + cos * y).error() > 0.07);
    assert!((cos * x + (sin + sin) * y).error() > 0.1);
}

#[test]
fn what_is_exact_adds_no_error_and_what_may_overflow_has_no_bound() {
    let x = Bounded::<Single>::exact(-3.0, 5.0);
    let zero = Bounded::<Single>::zero();
    for exact in [x + zero, zero + x, x * Bounded::one(), -x * Bounded::literal(-1.0), x * Bounded::literal(4.0)] {
        assert_eq!(exact.error(), 0.0, "{exact:?}");
    }
    assert_eq!((x * zero).interval(), (0.0, 0.0));
    assert!((x * Bounded::literal(0.5)).error() > 0.0 && (x * Bounded::literal(0.5)).error() < 1e-44);
    assert_eq!(Bounded::<Single>::literal(0.1).error(), (0.1 - f64::from(0.1_f32)).abs());
    assert_eq!(Bounded::<Double>::literal(0.1).error(), 0.0);

    let huge = Bounded::<Single>::exact(0.0, 3e38);
    assert_eq!((huge + huge).error(), f64::INFINITY);
    assert_eq!((huge * huge).error(), f64::INFINITY);
    assert_eq!((huge * huge * zero).error(), f64::INFINITY);
    assert_eq!(((huge * huge) * x - huge * huge).error(), f64::INFINITY);
    assert_eq!((x / x).error(), f64::INFINITY);
    let third = Bounded::<Single>::one() / Bounded::exact(3.0, 3.0);
    assert!((f64::from(1.0_f32 / 3.0) - 1.0 / 3.0).abs() <= third.error() && third.error() < 2e-8, "{third:?}");
    // A divisor whose computed value may be zero.
    assert_eq!((x / Bounded::within(0.5, 1.0, 0.5)).error(), f64::INFINITY);
}
