//! Test of the kernel of gravity alone against gravity torques written by hand.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use bench::kernels::puma560_gravity_regrouped_f64::gravity;
use bench::plain;
use dynamics_core::trig::Libm;
use dynamics_core::{SinCos, Trig};
use probe::hand::puma560;
use probe::states::States;
use robot_compiler::kernel::tape::{Arena, input, trace};
use robot_compiler::kernel::{Function, Level, Operations, Precision, Program, RuleSet, compile};

#[test]
fn hand_and_kernel_agree() {
    let mut states = States::new();
    for _ in 0..200 {
        let turn = Libm.sin_cos_all(&states.draw::<f64>().q);
        for (by_hand, found) in puma560(&turn).into_iter().zip(gravity(&turn)) {
            assert!((by_hand - found).abs() < 1e-13, "{by_hand} {found}");
        }
    }
}

/// Compares the number of operations of the hand-written function, without simplification, and of the kernels.
#[test]
fn a_kernel_of_gravity_alone_comes_near_the_hand_written_one() {
    let (outputs, tape) = trace(Arena::new(RuleSet::NONE, Precision::Double), || {
        puma560(&core::array::from_fn(|i| SinCos { sin: input(i as u32), cos: input(6 + i as u32) })).to_vec()
    });
    let by_hand = Program::new(tape, &outputs).operations();
    assert_eq!(by_hand, Operations { mul: 16, add: 4, sub: 4, neg: 1, ..Operations::default() });

    let file = plain::scene("puma560").unwrap();
    let model = file.robot.model::<6>().unwrap();
    let kernel = |level| compile(Function::Gravity, &model, &file.scene(&model), level, Precision::Double);
    assert_eq!(Level::ALL.map(|level| kernel(level).operations().total()), [121, 28]);
}
