//! The interpreter's results equal the program's.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "the same operations give the same bits")]

use dynamics_core::Trig;
use dynamics_core::regressor::inverse_dynamics_regressor;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Live};
use robot_compiler::kernel::inputs::{forward_input_values, input_values};
use robot_compiler::kernel::interpreter::Interpreter;
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{Function, Level, Precision, Program, RuleSet, compile};
use robot_compiler::{SceneFile, with_dof};

use crate::common::{files, top};

fn agrees<const N: usize>(file: &SceneFile, function: Function, level: Level) {
    let model = file.robot.model::<N>().unwrap();
    let program = compile(function, &model, &file.scene(&model), level, Precision::Double);
    let values = if function == Function::ForwardDynamics { forward_input_values } else { input_values };
    let live = file.live(&model);
    let mut interpreter = None;
    for k in 0..20 {
        let wave = |phase: f64| core::array::from_fn(|i| (f64::from(k) * 0.7 + i as f64 + phase).sin() * 2.0);
        let (q, qd, qdd): ([f64; N], [f64; N], [f64; N]) = (wave(0.0), wave(1.0), wave(2.0));
        let inputs = values(&Libm.sin_cos_all(&q), &q, &qd, &qdd, &live);
        let wanted = program.evaluate(&inputs);
        let interpreter = interpreter.get_or_insert_with(|| Interpreter::new(&program, inputs.len()).unwrap());
        let mut found = vec![f64::NAN; wanted.len()];
        interpreter.run(&inputs, &mut found);
        assert_eq!(found, wanted, "{} {} {}, state {k}", file.name, function.name(), level.name());
    }
}

#[test]
fn every_function_in_every_shipped_scene_has_the_values_of_its_program() {
    for path in files(&top("scenes"), &["toml"]) {
        let file = SceneFile::load(&path).unwrap();
        for (function, level) in Function::ALL.into_iter().flat_map(|f| Level::ALL.map(|level| (f, level))) {
            with_dof!(file.robot.dof(), N => agrees::<N>(&file, function, level));
        }
    }
}

fn regressor_agrees<const N: usize>(file: &SceneFile) {
    let model = file.robot.model::<N>().unwrap();
    let scene = file.scene(&model);
    let program = compile(Function::Regressor, &model, &scene, Level::Exact, Precision::Double);
    let dynamics = Dynamics::new(model, scene);
    for k in 0..5 {
        let wave = |phase: f64| core::array::from_fn(|i| (f64::from(k) * 0.7 + i as f64 + phase).sin() * 2.0);
        let (q, qd, qdd): ([f64; N], [f64; N], [f64; N]) = (wave(0.0), wave(1.0), wave(2.0));
        let turn = Libm.sin_cos_all(&q);
        let columns = inverse_dynamics_regressor(&dynamics, &turn, &q, &qd, &qdd, &Live::zero());
        let wanted: Vec<f64> = columns.iter().enumerate().flat_map(|(i, row)| row[i..].concat()).collect();
        assert_eq!(program.evaluate(&input_values(&turn, &q, &qd, &qdd, &Live::zero())), wanted, "{}", file.name);
    }
}

#[test]
fn the_traced_regressor_is_the_regressor_to_the_bit() {
    for name in ["puma560_ideal", "scara_pick", "stanford_reach", "planar2r_sine"] {
        let mut file = SceneFile::load(&top(&format!("scenes/{name}.toml"))).unwrap();
        file.model.gravity = dynamics_core::Term::Constant(nalgebra::Vector3::new(0.3, -1.0, -9.7));
        with_dof!(file.robot.dof(), N => regressor_agrees::<N>(&file));
    }
}

fn program(write: impl FnOnce() -> Vec<Expr>) -> Program {
    let (outputs, tape) = trace(Arena::new(RuleSet::ALL, Precision::Double), write);
    Program::new(tape, &outputs)
}

#[test]
fn outputs_may_be_inputs_numbers_and_the_same_value_twice() {
    let made = program(|| {
        let (a, b) = (input(0), input(2));
        let sum = a + b;
        vec![a, dynamics_core::Scalar::literal(7.0), sum, sum, sum * sum, -(a * b), a / b]
    });
    let mut interpreter = Interpreter::new(&made, 3).unwrap();
    let mut found = [0.0; 7];
    for [a, b] in [[1.0, 4.0], [-3.0, 0.5]] {
        interpreter.run(&[a, f64::NAN, b], &mut found);
        assert_eq!(found, [a, 7.0, a + b, a + b, (a + b) * (a + b), -(a * b), a / b]);
    }
    // Missing inputs count as zero, even if an earlier run set them.
    interpreter.run(&[2.0], &mut found);
    assert_eq!(found[..6], [2.0, 7.0, 2.0, 2.0, 4.0, 0.0]);
}

#[test]
fn a_program_that_does_not_fit_is_refused() {
    let sum = |n: u32| program(|| vec![(1..n).fold(input(0), |sum, k| sum + input(k) * input(k))]);
    assert!(Interpreter::<f64>::new(&sum(400), 400).is_some());
    assert!(Interpreter::<f64>::new(&sum(600), 600).is_none());
    assert!(Interpreter::<f64>::new(&sum(10), 9).is_none(), "an input that the caller does not have");
}
