//! Rounding errors of the two levels, compared with the recursion in double-double arithmetic.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Real, Scalar, Scene, SinCos, Term, Trig};
use nalgebra::Vector3;
use robot_compiler::Robot;
use robot_compiler::kernel::inputs::input_values;
use robot_compiler::kernel::{Function, Level, Precision, compile};
use robot_compiler::precision::DoubleDouble;

use crate::common::top;

const STATES: usize = 1000;

/// Numbers in [-1, 1), the same in every run: a linear congruence with Knuth's multiplier.
struct Random(u64);

impl Random {
    fn joints(&mut self, size: f64) -> [f64; 6] {
        core::array::from_fn(|_| {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // Inputs that single precision holds exactly: the test measures the kernel's error, not the inputs'.
            f64::from((size * ((self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)) as f32)
        })
    }
}

/// Largest errors of the kernels of the levels `exact` and `regrouped`, computed in `S`, relative to the largest torque of the state.
fn errors<S: Real>(robot: &str) -> [f64; 2] {
    let model = Robot::load(&top(&format!("robots/{robot}.toml"))).unwrap().model::<6>().unwrap();
    let scene = Scene { gravity: Term::Constant(Vector3::new(0.0, 0.0, -9.81)), ..Scene::free_space() };
    let recursion = Dynamics::new(model.cast::<DoubleDouble>(), scene.cast());
    let level = |level| compile(Function::InverseDynamics, &model, &scene, level, Precision::of::<S>());
    let kernels = Level::ALL.map(level);
    let mut random = Random(7);
    let mut worst = [0.0_f64; 2];
    for _ in 0..STATES {
        let (q, qd, qdd) = (random.joints(3.0), random.joints(2.0), random.joints(5.0));
        let turn = Libm.sin_cos_all(&q).map(|t| SinCos { sin: S::literal(t.sin), cos: S::literal(t.cos) });
        let exact = turn.map(|t| SinCos { sin: Scalar::literal(t.sin.to_f64()), cos: Scalar::literal(t.cos.to_f64()) });
        let [rq, rqd, rqdd] = [q, qd, qdd].map(|x| x.map(DoubleDouble::literal));
        let wanted = recursion.inverse_dynamics(&exact, &rq, &rqd, &rqdd, &Live::zero());
        let size = wanted.iter().fold(0.0_f64, |size, x| size.max(x.minus(0.0).abs()));
        let [q, qd, qdd] = [q, qd, qdd].map(|x| x.map(S::literal));
        let inputs = input_values(&turn, &q, &qd, &qdd, &Live::zero());
        for (kernel, worst) in kernels.iter().zip(&mut worst) {
            for (found, wanted) in kernel.evaluate(&inputs).into_iter().zip(wanted) {
                *worst = worst.max(wanted.minus(found.to_f64()).abs() / size);
            }
        }
    }
    worst
}

/// Asserts these errors, to a twentieth, and that the second is at most twice the first.
#[track_caller]
fn assert_errors<S: Real>(robot: &str, exact: f64, regrouped: f64) {
    let found = errors::<S>(robot);
    println!("{robot}: {found:?}");
    for (found, wanted) in found.into_iter().zip([exact, regrouped]) {
        assert!((found / wanted - 1.0).abs() < 0.05, "{robot}: {found:e}, not {wanted:e}");
    }
    assert!(found[1] <= 2.0 * found[0], "{robot}: {found:?}");
}

#[test]
fn ur5_in_single_precision() {
    assert_errors::<f32>("ur5", 8.51e-7, 6.58e-7);
}

#[test]
fn puma_in_single_precision() {
    assert_errors::<f32>("puma560", 5.20e-7, 4.18e-7);
}

#[test]
fn stanford_in_single_precision() {
    assert_errors::<f32>("stanford", 7.81e-7, 9.89e-7);
}

#[test]
fn ur5_in_double_precision() {
    assert_errors::<f64>("ur5", 1.51e-15, 1.18e-15);
}

#[test]
fn puma_in_double_precision() {
    assert_errors::<f64>("puma560", 1.20e-15, 8.96e-16);
}

#[test]
fn stanford_in_double_precision() {
    assert_errors::<f64>("stanford", 1.24e-15, 1.50e-15);
}
