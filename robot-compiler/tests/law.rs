//! The computed-torque law traced as one function, compared with the controller that runs it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "level exact claims equality")]

use dynamics_core::control::ControlLaw;
use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Command, Controller, ControllerConfig, Dynamics, Limits, Measurement, Real, Reference, Sensed, Trig,
};
use robot_compiler::kernel::functions::Springs;
use robot_compiler::kernel::inputs::{input_values, reference_values};
use robot_compiler::kernel::{Function, Level, Precision, Program, compile};
use robot_compiler::{SceneFile, with_dof};

use crate::common::{files, top};

const STATES: u32 = 50;

/// The law alone: the configuration without the controller's other parts.
fn law_alone<const N: usize>(config: ControllerConfig<f64, N>) -> ControllerConfig<f64, N> {
    ControllerConfig {
        law: ControlLaw::ComputedTorque,
        friction: None,
        integral: None,
        limits: [Limits::none(); N],
        ..config
    }
}

/// Largest difference between a controller and a traced law in some states, relative to the largest torque of the state.
fn distance<S: Real, const N: usize>(file: &SceneFile, program: &Program) -> S
where
    Polynomial: Trig<S>,
{
    let model = file.robot.model::<N>().unwrap();
    let dynamics = Dynamics::new(model.cast::<S>(), file.scene(&model).cast());
    let mut config = law_alone(file.controller_config(&model));
    config.guard = config.guard.map(|mut guard| {
        guard.velocity_max = f64::INFINITY;
        guard
    });
    let mut worst = S::zero();
    for state in 0..STATES {
        let wave = |phase: f64| core::array::from_fn(|i| S::literal((f64::from(state) * 0.7 + i as f64 + phase).sin()));
        let (q, qd): ([S; N], [S; N]) = (wave(0.0), wave(1.0));
        let reference = Reference { q: wave(0.1), qd: wave(1.2), qdd: wave(2.0) };
        let mut controller = Controller::new(config.cast::<S>(), dynamics, Polynomial);
        let live = file.live(&model);
        *controller.live_mut() = dynamics_core::Live {
            gravity: dynamics_core::inertia::cast_vector(&live.gravity),
            payload: live.payload.cast(),
            tip_wrench: live.tip_wrench.cast(),
            rotor: live.rotor.map(S::literal),
        };
        let mut inputs =
            input_values(&Polynomial.sin_cos_all(&q), &q, &qd, &[S::literal(f64::NAN); N], controller.live_mut());
        inputs.extend(reference_values(&reference));
        let measured = Measurement { sensed: Sensed::State { q, qd }, age_ticks: 0 };
        let Command::Drive { torque, .. } = controller.tick(&reference, &measured) else { panic!("{}", file.name) };
        let largest = torque.iter().fold(S::one(), |largest, t| if t.abs() > largest { t.abs() } else { largest });
        for (found, wanted) in program.evaluate(&inputs).iter().zip(torque) {
            let off = (*found - wanted).abs() / largest;
            // A NaN must not pass for a small difference.
            worst = if off <= worst { worst } else { off };
        }
    }
    worst
}

fn traced<const N: usize>(file: &SceneFile, level: Level, precision: Precision) -> Program {
    let model = file.robot.model::<N>().unwrap();
    let springs = Springs::new(&file.controller_config(&model).gains);
    compile(Function::ComputedTorque(springs), &model, &file.scene(&model), level, precision)
}

fn scenes() -> Vec<SceneFile> {
    files(&top("scenes"), &["toml"]).iter().map(|path| SceneFile::load(path).unwrap()).collect()
}

#[test]
fn the_traced_law_equals_the_controller_in_every_shipped_scene_and_both_precisions() {
    for file in scenes() {
        with_dof!(file.robot.dof(), N => {
            let single = traced::<N>(&file, Level::Exact, Precision::Single);
            assert_eq!(distance::<f32, N>(&file, &single), 0.0, "{}", file.name);
            let double = traced::<N>(&file, Level::Exact, Precision::Double);
            assert_eq!(distance::<f64, N>(&file, &double), 0.0, "{}", file.name);
            let regrouped = distance::<f64, N>(&file, &traced::<N>(&file, Level::Regrouped, Precision::Double));
            assert!(regrouped < 1e-13, "{}: {regrouped:e}", file.name);
        });
    }
}

#[test]
fn a_traced_law_with_other_gains_is_another() {
    let mut file = scenes().into_iter().find(|file| file.name == "puma560_pick").unwrap();
    let program = traced::<6>(&file, Level::Exact, Precision::Single);
    file.control.damping = vec![1.001; 6];
    assert!(distance::<f32, 6>(&file, &program) > 1e-6);
}

#[test]
fn the_law_costs_six_operations_a_joint_beside_its_inverse_dynamics() {
    let file = scenes().into_iter().find(|file| file.name == "puma560_pick").unwrap();
    let model = file.robot.model::<6>().unwrap();
    let torques = compile(Function::InverseDynamics, &model, &file.scene(&model), Level::Exact, Precision::Single);
    let law = traced::<6>(&file, Level::Exact, Precision::Single);
    assert_eq!(law.operations().total(), torques.operations().total() + 6 * 6);
}
