//! The recursion and the sine in f32, everything about them in f64.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so")]
#![allow(clippy::float_cmp, reason = "the two precisions are promised to agree to the bit where they meet")]

use dynamics_core::mixed::{Narrow, Reduced};
use dynamics_core::trig::{Libm, Polynomial};
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, SinCos, Tool,
    Trig,
};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Number `index` of a sequence that is spread evenly over `[-width, width)`: multiples of an irrational number, less whole ones.
/// Each `dimension` has its own.
fn within(index: u32, dimension: u32, width: f64) -> f64 {
    let irrational = f64::from([2_u32, 3, 5, 7, 11, 13][dimension as usize]).sqrt();
    width * (2.0 * (f64::from(index) * irrational).fract() - 1.0)
}

/// Greatest error of sine and cosine over 100,000 angles up to `width`, rad.
fn worst(trig: impl Trig<f64>, width: f64) -> f64 {
    (0..100_000).fold(0.0, |worst: f64, index| {
        let angle = within(index, 0, width);
        let (found, exact) = (trig.sin_cos(angle), angle.sin_cos());
        worst.max((found.sin - exact.0).abs()).max((found.cos - exact.1).abs())
    })
}

#[test]
fn an_angle_is_as_good_after_a_hundred_thousand_turns_as_in_the_first() {
    for width in [TAU / 2.0, 1e3 * TAU, Reduced::<Polynomial>::LIMIT] {
        let error = worst(Reduced(Polynomial), width);
        assert!((MIXED.0..MIXED.1).contains(&error), "{error:e} up to {width} rad");
        let error = worst(Reduced(Libm), width);
        assert!((MIXED.0..MIXED.1).contains(&error), "libm, {error:e} up to {width} rad");
    }
}

/// Least and greatest error that is believed: that of the rounding to f32 of an angle near pi, and of the sine.
const MIXED: (f64, f64) = (1.3e-7, 2.1e-7);

#[test]
fn the_ends_of_the_range_are_as_they_should_be() {
    let limit = Reduced::<Polynomial>::LIMIT;
    let nan = |angle: f64| {
        let SinCos { sin, cos } = Reduced(Polynomial).sin_cos(angle);
        assert_eq!(sin.is_nan(), cos.is_nan());
        sin.is_nan()
    };
    for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, limit.next_up(), -limit.next_up(), f64::MAX] {
        assert!(nan(angle), "{angle}");
    }
    for angle in [limit, -limit, 0.0, f64::MIN_POSITIVE, TAU / 2.0] {
        assert!(!nan(angle), "{angle}");
    }
    assert_eq!(Reduced(Polynomial).sin_cos(-0.0).sin.to_bits(), (-0.0_f64).to_bits());
    for angle in [0.3, 3.0, 4.0, 1234.5, limit] {
        let (plus, minus) = (Reduced(Polynomial).sin_cos(angle), Reduced(Polynomial).sin_cos(-angle));
        assert_eq!((plus.sin.to_bits(), plus.cos.to_bits()), ((-minus.sin).to_bits(), minus.cos.to_bits()), "{angle}");
    }
}

/// Sine and cosine that remember what a tick asked, and give it again in every later one until they forget.
#[derive(Clone, Copy, Debug, Default)]
struct First(Option<f32>);

impl Trig<f32> for First {
    fn sin_cos(&self, angle: f32) -> SinCos<f32> {
        Polynomial.sin_cos(angle)
    }

    fn tick<const N: usize>(&mut self, angles: &[f32; N]) -> [SinCos<f32>; N] {
        let first = *self.0.get_or_insert(angles[0]);
        [Polynomial.sin_cos(first); N]
    }

    fn forget(&mut self) {
        self.0 = None;
    }
}

#[test]
fn what_remembers_inside_is_told_of_ticks_and_of_resets() {
    let mut trig = Reduced(First::default());
    let sines = |angle: f64| Reduced(Polynomial).sin_cos(angle);
    assert_eq!(trig.tick(&[1.0]), [sines(1.0)]);
    assert_eq!(trig.tick(&[2.0]), [sines(1.0)]);
    trig.forget();
    assert_eq!(trig.tick(&[TAU + 2.0]), [sines(TAU + 2.0)]);
}

/// Two links in the vertical xy plane.
fn planar() -> Dynamics<f64, 2> {
    let joints = [(0.7, 3.0), (0.5, 2.0)].map(|(length, mass)| JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: length, ..Dh::default() }),
        body: Body {
            mass,
            com: Vector3::new(-0.5 * length, 0.0, 0.0),
            inertia: Matrix3::from_diagonal_element(mass * length * length / 12.0),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    });
    let model = Model::new(&joints, &Tool::default()).unwrap();
    Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model))
}

fn single() -> Dynamics<f32, 2> {
    let arm = planar();
    Dynamics::new(arm.model().cast(), arm.scene().cast())
}

#[test]
fn the_recursion_inside_is_that_of_an_f32_controller() {
    let mut mixed = Narrow(single());
    for index in 0..1000 {
        let two = |first: u32, width| [first, first + 1].map(|dimension| within(index, dimension, width) as f32);
        let (q, qd, qdd) = (two(0, 3.0), two(2, 4.0), two(4, 20.0));
        let turn = Polynomial.sin_cos_all(&q);
        let expected = single().inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero()).map(f64::from);
        let wide = |x: [f32; 2]| x.map(f64::from);
        let turn = turn.map(|SinCos { sin, cos }| SinCos { sin: f64::from(sin), cos: f64::from(cos) });
        let (q, qd, qdd) = (wide(q), wide(qd), wide(qdd));
        assert_eq!(mixed.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero()), expected);
        assert_eq!(mixed.tick(|| turn, &q, &qd, &qdd, &Live::zero()), expected);
    }
}

/// Greatest torque error, N m, over 10,000 states about so many turns: f32, mixed, f64, each against libm in f64.
fn torque_errors(turns: f64) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    for index in 0..10_000 {
        let two = |first: u32, width| [first, first + 1].map(|dimension| within(index, dimension, width));
        let q = two(0, 3.0).map(|q| turns * TAU + q);
        let (qd, qdd) = (two(2, 4.0), two(4, 20.0));
        let narrow = |x: [f64; 2]| x.map(|x| x as f32);
        let exact = planar().inverse_dynamics(&Libm.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero());
        let small = narrow(q);
        let turn = Polynomial.sin_cos_all(&small);
        let found = [
            single().inverse_dynamics(&turn, &small, &narrow(qd), &narrow(qdd), &Live::zero()).map(f64::from),
            Narrow(single()).inverse_dynamics(&Reduced(Polynomial).sin_cos_all(&q), &q, &qd, &qdd, &Live::zero()),
            planar().inverse_dynamics(&Polynomial.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero()),
        ];
        for (worst, found) in worst.iter_mut().zip(found) {
            for i in 0..2 {
                // Not `max`, which forgets a NaN.
                let error = (found[i] - exact[i]).abs();
                if error > *worst || error.is_nan() {
                    *worst = error;
                }
            }
        }
    }
    worst
}

#[test]
fn far_from_the_origin_mixed_keeps_the_torque_that_single_loses() {
    let found = MEASURED.map(|(turns, _)| torque_errors(turns));
    for (found, (turns, measured)) in found.into_iter().zip(MEASURED) {
        for (found, measured) in found.into_iter().zip(measured) {
            let near = (found / measured - 1.0).abs() < 0.05 || found.is_nan() && measured.is_nan();
            assert!(near, "{turns} turns: {found:e} N m, measured before: {measured:e}");
        }
    }
}

/// Turns, and the greatest torque error of f32, mixed and f64, N m. An f32 angle of 10,000 turns is beyond the polynomial's limit.
const MEASURED: [(f64, [f64; 3]); 3] = [
    (0.0, [1.3022e-5, 1.3022e-5, 2.13e-14]),
    (1e3, [9.8706e-3, 1.3022e-5, 2.84e-14]),
    (1e4, [f64::NAN, 1.3022e-5, 1.42e-14]),
];
