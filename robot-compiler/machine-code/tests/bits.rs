//! Every lane has the bits that the program's own evaluation gives.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use machine_code::{Instructions, Kernel, LANES};
use proptest::prelude::*;
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{Precision, Program, RuleSet};

const INPUTS: usize = 5;

/// A program that repeatedly makes a new value of two earlier ones; `rules` may be none, so that nothing is simplified.
fn program(steps: &[(u8, usize, usize)], outputs: usize, rules: RuleSet) -> Program {
    let (values, arena) = trace(Arena::new(rules, Precision::Double), || {
        let mut values: Vec<Expr> = (0..INPUTS).map(|number| input(number as u32)).collect();
        values.push(<Expr as dynamics_core::Scalar>::literal(1.5));
        values.push(<Expr as dynamics_core::Scalar>::literal(-0.25));
        for &(operation, a, b) in steps {
            let (a, b) = (values[a % values.len()], values[b % values.len()]);
            values.push(match operation % 5 {
                0 => a + b,
                1 => a - b,
                2 => a * b,
                3 => a / b,
                _ => -a,
            });
        }
        values
    });
    let outputs: Vec<Expr> = values.iter().rev().take(outputs).copied().collect();
    Program::new(arena, &outputs)
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

/// The kernel of one state, on each state.
fn alone_agrees(program: &Program, states: &[[f64; INPUTS]; 8]) {
    let Some(mut kernel) = Kernel::of_one(program, INPUTS) else {
        assert!(!Instructions::AvxOne.are_here());
        return;
    };
    for state in states {
        for (number, value) in state.iter().enumerate() {
            kernel.inputs()[number * LANES] = *value;
        }
        kernel.run_one();
        for (number, wanted) in program.evaluate(state).into_iter().enumerate() {
            let found = kernel.outputs()[number * LANES];
            assert!(same(found, wanted), "alone: output {number}: {found:e}, not {wanted:e}");
        }
    }
}

fn agrees(program: &Program, states: &[[f64; INPUTS]; 8]) {
    alone_agrees(program, states);
    for instructions in Instructions::ALL.into_iter().filter(|it| it.are_here()) {
        let mut kernel = Kernel::with(program, INPUTS, instructions).unwrap();
        // Twice: values that the first run leaves in memory must have no effect.
        for _ in 0..2 {
            for number in 0..INPUTS {
                for lane in 0..LANES {
                    kernel.inputs()[number * LANES + lane] = states[lane][number];
                }
            }
            kernel.run();
        }
        for lane in 0..LANES {
            for (number, wanted) in program.evaluate(&states[lane]).into_iter().enumerate() {
                let found = kernel.outputs()[number * LANES + lane];
                assert!(
                    same(found, wanted),
                    "{instructions:?}: output {number} of lane {lane}: {found:e}, not {wanted:e}"
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]
    #[test]
    fn any_program_has_the_same_bits_in_every_lane(
        steps in prop::collection::vec((0_u8..5, any::<usize>(), any::<usize>()), 0..400),
        outputs in 1_usize..40,
        states in prop::array::uniform8(prop::array::uniform5(-3.0..3.0_f64)),
        simplified in any::<bool>(),
    ) {
        let rules = if simplified { RuleSet::ALL } else { RuleSet::NONE };
        agrees(&program(&steps, outputs, rules), &states);
    }
}

#[test]
fn an_output_may_be_an_input_or_a_number_and_may_occur_twice() {
    let (outputs, arena) = trace(Arena::new(RuleSet::ALL, Precision::Double), || {
        let number = <Expr as dynamics_core::Scalar>::literal(7.0);
        let sum = input(0) + input(1);
        [input(3), number, sum, sum, -input(2)]
    });
    agrees(&Program::new(arena, &outputs), &[[1.0, 2.0, 0.0, 4.0, 5.0]; 8]);
}

#[test]
fn infinities_and_nan_come_out_as_they_went_in() {
    let steps = [(0, 0, 1), (2, 0, 7), (3, 7, 8), (1, 9, 2)];
    agrees(
        &program(&steps, 4, RuleSet::NONE),
        &[[f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -0.0, f64::MIN_POSITIVE / 2.0]; 8],
    );
}

#[test]
fn a_clone_has_the_same_code_and_inputs_and_a_memory_of_its_own() {
    let program = program(&[(0, 0, 1)], 1, RuleSet::ALL);
    let Some(mut kernel) = Kernel::new(&program, INPUTS) else { return };
    kernel.inputs().fill(2.0);
    let mut clone = kernel.clone();
    clone.run();
    assert_eq!(clone.outputs(), vec![4.0; LANES]);
    assert_ne!(kernel.outputs(), clone.outputs(), "a clone has a memory of its own");
}
