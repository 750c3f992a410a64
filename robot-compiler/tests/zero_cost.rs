//! A term that a scene does not use costs nothing: not one byte of the kernel's text.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_core::joint::Rotor;
use dynamics_core::{Body, Term, Wrench};
use nalgebra::Vector3;
use robot_compiler::emit::kernel::{Title, module};
use robot_compiler::kernel::{Function, Level, Precision};
use robot_compiler::scene::ModelTerm;
use robot_compiler::{Robot, SceneFile, emit, with_dof};

use crate::common::{files, top};

/// Every shipped arm in a scene with all its possible terms; only the velocity terms are live.
fn everything() -> Vec<SceneFile> {
    let robots = files(&top("robots"), &["toml"]);
    assert!(robots.len() >= 6, "found {}", robots.len());
    let with_everything = |mut robot: Robot| {
        for joint in &mut robot.joints {
            joint.friction.get_or_insert(robot_compiler::JointFriction {
                viscous: 0.3,
                coulomb: 0.7,
                ..Default::default()
            });
            if joint.spec.rotor.reflected() == 0.0 {
                joint.spec.rotor = Rotor { inertia: 1e-4, gear: 30.0 };
            }
        }
        let mut scene = SceneFile::default_for(robot);
        let com = Vector3::new(0.01, 0.02, 0.05);
        scene.model.payload = Term::Constant(Body { mass: 1.5, com, ..Body::massless() });
        let moment = Vector3::new(0.1, 0.2, -0.3);
        scene.model.tip_wrench = Term::Constant(Wrench { force: Vector3::new(1.0, -2.0, 3.0), moment });
        scene
    };
    robots.iter().map(|path| with_everything(Robot::load(path).unwrap())).collect()
}

/// The kernel of inverse dynamics without its head, which lists the terms.
fn kernel(scene: &SceneFile, level: Level) -> String {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().unwrap();
        let title = Title { robot: "arm", scene: "scene", hash: 0 };
        let text = module(Function::InverseDynamics, &model, &scene.scene(&model), level, Precision::Single, &title);
        text.lines().filter(|line| !line.starts_with("//!")).flat_map(|line| [line, "\n"]).collect()
    })
}

fn without(scene: &SceneFile, term: ModelTerm) -> SceneFile {
    SceneFile { model: scene.model.without(&[term]), ..scene.clone() }
}

/// The scene in a world without the cause of a term: the term is requested, but is zero.
fn never_had(scene: &SceneFile, term: ModelTerm) -> SceneFile {
    let mut scene = scene.clone();
    let model = &mut scene.model;
    match term {
        ModelTerm::Gravity => model.gravity = Term::Constant(Vector3::zeros()),
        ModelTerm::Payload => model.payload = Term::Constant(Body::massless()),
        ModelTerm::TipWrench => model.tip_wrench = Term::Constant(Wrench::zero()),
        ModelTerm::VelocityTerms => model.coriolis = Term::Constant(vec![0.0; scene.robot.dof()]),
        ModelTerm::Rotors => scene.robot.joints.iter_mut().for_each(|joint| joint.spec.rotor = Rotor::default()),
        ModelTerm::Friction => scene.robot.joints.iter_mut().for_each(|joint| joint.friction = None),
    }
    scene
}

#[test]
fn a_kernel_without_a_term_is_that_of_an_arm_that_never_had_it() {
    let mut differ = Vec::new();
    for scene in everything() {
        for level in Level::ALL {
            let all = kernel(&scene, level);
            for term in ModelTerm::ALL {
                let (left_out, never) =
                    (kernel(&without(&scene, term), level), kernel(&never_had(&scene, term), level));
                let which = format!("{}, {}, {}", scene.robot.name, level.name(), term.name());
                if term == ModelTerm::VelocityTerms {
                    // Every arm has velocity terms. A steady speed of zero comes closest to an arm without: its numbers are on the tape before
                    // they are folded. This reorders some sums, and changes no operation count.
                    assert!(left_out.contains("_qd: ") && never.contains("_qd: "), "{which}");
                    if operations(&left_out) != operations(&never) {
                        differ.push(which.clone());
                    }
                } else if left_out != never {
                    differ.push(which.clone());
                }
                // Friction is not part of a kernel, and neither is the weight of an arm that moves in a horizontal plane.
                let felt = with_dof!(scene.robot.dof(), N => felt::<N>(&scene, term));
                assert_eq!(left_out != all, felt, "{which}");
            }
        }
    }
    assert_eq!(differ, [""; 0]);
}

/// Multiplications, and additions with subtractions, of a kernel's text.
fn operations(text: &str) -> (usize, usize) {
    let count = |sign| text.lines().filter(|line| line.trim().split(' ').nth(4) == Some(sign)).count();
    (count("*"), count("+") + count("-"))
}

/// True if a term changes a torque in some state.
fn felt<const N: usize>(scene: &SceneFile, term: ModelTerm) -> bool {
    use dynamics_core::trig::Libm;
    use dynamics_core::{Dynamics, InverseDynamics, Live, Trig};
    let model = scene.robot.model::<N>().unwrap();
    let state = |k: f64| -> [f64; N] { core::array::from_fn(|i| 0.3 + k * (i as f64 + 1.0)) };
    let (q, qd, qdd) = (state(0.17), state(-0.29), state(0.41));
    let torque = |scene: &SceneFile| {
        let dynamics = Dynamics::new(model, scene.scene(&model));
        dynamics.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero())
    };
    let (with, without) = (torque(scene), torque(&without(scene, term)));
    with.iter().zip(without).any(|(a, b)| (a - b).abs() > 1e-9)
}

#[test]
fn an_arm_without_rotors_or_friction_is_the_same_firmware_whether_or_not_they_were_left_out() {
    for scene in everything() {
        let bare = never_had(&never_had(&scene, ModelTerm::Friction), ModelTerm::Rotors);
        let neither = [ModelTerm::Rotors, ModelTerm::Friction];
        let left_out = SceneFile { model: bare.model.without(&neither), ..bare.clone() };
        with_dof!(scene.robot.dof(), N => {
            let model = bare.robot.model::<N>().unwrap();
            // Read again with the reader's defaults, it has no friction to feed forward.
            let fresh = SceneFile::default_for(bare.robot.clone()).model;
            assert!(!fresh.friction && fresh.rotor == Term::Absent);
            assert!(emit::arm_module(&left_out, &model).contains("friction: None"));
            // Dropping the friction of an arm that has it gives the same numbers, and so the same text and the same hash.
            let has = never_had(&scene, ModelTerm::Rotors);
            let has = SceneFile { model: has.model.without(&neither), ..has };
            let model_of_has = has.robot.model::<N>().unwrap();
            assert_eq!(emit::arm_module(&has, &model_of_has), emit::arm_module(&left_out, &model));
            assert_eq!(emit::dynamics_module(&has, &model_of_has), emit::dynamics_module(&left_out, &model));
            assert_eq!(has.hash(&model_of_has), left_out.hash(&model));
        });
    }
}

#[test]
fn a_live_term_is_paid_for_even_where_it_is_zero() {
    // Control for the first test: values that are known only in the tick cannot be folded away.
    for scene in everything() {
        let live = SceneFile {
            model: robot_compiler::scene::ModelSpec {
                payload: Term::Live,
                tip_wrench: Term::Live,
                ..scene.model.clone()
            },
            ..scene.clone()
        };
        for term in [ModelTerm::Payload, ModelTerm::TipWrench] {
            let (with, without) = (kernel(&live, Level::Exact), kernel(&without(&live, term), Level::Exact));
            let lines = |text: &str| text.lines().filter(|line| line.trim_start().starts_with("let ")).count();
            assert!(lines(&with) > lines(&without), "{}, {}", scene.robot.name, term.name());
        }
    }
}
