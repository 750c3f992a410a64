//! What rounding costs the two levels, against the recursion in double precision.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, SinCos, Term, Trig};
use nalgebra::Vector3;
use robot_compiler::Robot;
use robot_compiler::kernel::functions::input_values;
use robot_compiler::kernel::{Function, Level, Precision, compile};

mod common;
use common::top;

const STATES: usize = 1000;

/// Numbers in [-1, 1), the same in every run: a linear congruence with Knuth's multiplier.
struct Random(u64);

impl Random {
    fn joints(&mut self, size: f64) -> [f64; 6] {
        core::array::from_fn(|_| {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // Inputs that single precision holds: what is measured is the kernel's error, not theirs.
            f64::from((size * ((self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)) as f32)
        })
    }
}

/// Largest error of each level in f32, relative to the largest torque of the state.
fn errors(robot: &str) -> [f64; 2] {
    let model = Robot::load(&top(&format!("robots/{robot}.toml"))).unwrap().model::<6>().unwrap();
    let scene = Scene { gravity: Term::Constant(Vector3::new(0.0, 0.0, -9.81)), ..Scene::free_space() };
    let recursion = Dynamics::new(model, scene);
    let kernels = Level::ALL.map(|level| compile(Function::InverseDynamics, &model, &scene, level, Precision::Single));
    let mut random = Random(7);
    let mut worst = [0.0_f64; 2];
    for _ in 0..STATES {
        let (q, qd, qdd) = (random.joints(3.0), random.joints(2.0), random.joints(5.0));
        let rounded = Libm.sin_cos_all(&q).map(|t| (t.sin as f32, t.cos as f32));
        let turn = rounded.map(|(sin, cos)| SinCos { sin: f64::from(sin), cos: f64::from(cos) });
        let wanted = recursion.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero());
        let size = wanted.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let single = |x: [f64; 6]| x.map(|x| x as f32);
        let turn = rounded.map(|(sin, cos)| SinCos { sin, cos });
        let inputs = input_values(&turn, &single(q), &single(qd), &single(qdd), &Live::zero());
        for (kernel, worst) in kernels.iter().zip(&mut worst) {
            for (found, wanted) in kernel.evaluate(&inputs).into_iter().zip(wanted) {
                *worst = worst.max((f64::from(found) - wanted).abs() / size);
            }
        }
    }
    worst
}

/// Errors are those written here, to a twentieth; the second at most twice the first.
#[track_caller]
fn assert_errors(robot: &str, exact: f64, regrouped: f64) {
    let found = errors(robot);
    println!("{robot}: {found:?}");
    for (found, wanted) in found.into_iter().zip([exact, regrouped]) {
        assert!((found / wanted - 1.0).abs() < 0.05, "{robot}: {found:e}, not {wanted:e}");
    }
    assert!(found[1] <= 2.0 * found[0], "{robot}: {found:?}");
}

#[test]
fn ur5_in_single_precision() {
    assert_errors("ur5", 8.51e-7, 3.56e-7);
}

#[test]
fn puma_in_single_precision() {
    assert_errors("puma560", 5.33e-7, 4.38e-7);
}

#[test]
fn stanford_in_single_precision() {
    assert_errors("stanford", 7.81e-7, 6.58e-7);
}
