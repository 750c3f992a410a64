//! Loops with a simplified model: a constant inertia, evaluation in some ticks only, two precisions.

use dynamics_core::control::{Between, ControlLaw};
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use robot_compiler::scene::{MotionSpec, ScalarChoice};
use sim::run::closed_loop::End;
use sim::run::record::Record;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn load(path: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The undisturbed Puma with an exact model.
fn puma() -> SceneFile {
    load("../../scenes/puma560_ideal.toml")
}

fn run(scene: &SceneFile) -> Run {
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    let run = simulation::run(scene, &stop, &bar).unwrap();
    assert_eq!((run.end, run.summary.faults.as_slice()), (End::Complete, [].as_slice()));
    run
}

/// Greatest tracking error of any joint, rad.
fn error(scene: &SceneFile) -> f64 {
    run(scene).summary.tracking_max.iter().copied().fold(0.0, f64::max)
}

fn csv(record: &Record) -> Vec<u8> {
    let mut bytes = Vec::new();
    record.write_csv(&mut bytes).unwrap();
    bytes
}

/// Asserts that a number is within 3 % of the measured one.
fn assert_near(found: f64, measured: f64, what: &str) {
    println!("{what}: {found:.3e}");
    assert!((found / measured - 1.0).abs() < 0.03, "{what}: {found:e}, measured before: {measured:e}");
}

#[test]
fn a_fixed_inertia_follows_better_than_gravity_alone_and_worse_than_the_model() {
    for (law, measured) in [
        (ControlLaw::ComputedTorque, 7.965e-6),
        (ControlLaw::DiagonalInertia, 1.564e-3),
        (ControlLaw::PdGravity, 2.711e-3),
    ] {
        let mut scene = puma();
        scene.control.law = law;
        assert_near(error(&scene), measured, &format!("{law:?}"));
    }
}

#[test]
fn the_error_grows_with_the_ticks_between_evaluations_and_more_slowly_along_a_line() {
    let measured = [
        (1, 7.965e-6, 7.965e-6),
        (2, 9.842e-6, 7.972e-6),
        (4, 1.358e-5, 8.091e-6),
        (8, 3.885e-5, 8.612e-6),
        (16, 9.042e-5, 2.662e-5),
        (32, 1.917e-4, 1.059e-4),
    ];
    for (every, held, extrapolated) in measured {
        for (between, measured) in [(Between::Hold, held), (Between::Extrapolate, extrapolated)] {
            let mut scene = puma();
            (scene.control.model_every, scene.control.model_between) = (every, between);
            assert_near(error(&scene), measured, &format!("every {every}, {between:?}"));
        }
    }
}

#[test]
fn gravity_held_costs_next_to_nothing_when_the_inertia_is_fixed_anyway() {
    for (every, measured) in [(1, 1.564e-3), (4, 1.564e-3), (32, 1.561e-3)] {
        let mut scene = puma();
        (scene.control.law, scene.control.model_every) = (ControlLaw::DiagonalInertia, every);
        assert_near(error(&scene), measured, &format!("diagonal inertia, every {every}"));
    }
}

#[test]
fn the_shipped_scene_tracks_nearly_as_the_pick_does() {
    assert_near(error(&load("../../scenes/puma560_pick.toml")), 8.053e-4, "in every tick");
    let mut slow = load("../../scenes/puma560_slow_model.toml");
    assert_eq!((slow.control.model_every, slow.control.model_between), (4, Between::Extrapolate));
    assert_near(error(&slow), 8.018e-4, "in every 4th tick, along a line");
    slow.control.model_between = Between::Hold;
    assert_near(error(&slow), 8.059e-4, "in every 4th tick, held");
    // The same world: with the model evaluated in every tick, it equals the pick scene bit for bit.
    slow.control.model_every = 1;
    assert_eq!(csv(&run(&slow).record), csv(&run(&load("../../scenes/puma560_pick.toml")).record));
}

/// The Puma that fetches 2 kg, slowly: to the farthest point of its motion and back, at a tenth of its speed limits.
fn slow_pick(law: ControlLaw, every: u32) -> SceneFile {
    let mut scene = load("../../scenes/puma560_pick.toml");
    if let MotionSpec::Quintic { points, .. } = &mut scene.motion {
        points.remove(1);
        for point in &mut points[1..] {
            (point.duration, point.dwell) = (Some(5.86), 0.0);
        }
    }
    (scene.control.law, scene.control.model_every) = (law, every);
    scene.control.model_between = Between::Extrapolate;
    scene
}

#[test]
fn on_a_slow_course_smoothed_friction_is_the_error_and_coupled_feedback_gives_way_to_it_further() {
    let [full, rarely, gravity] = [
        slow_pick(ControlLaw::ComputedTorque, 1),
        slow_pick(ControlLaw::ComputedTorque, 16),
        slow_pick(ControlLaw::PdGravity, 1),
    ];
    let with_friction = [(&full, 4.773e-3), (&rarely, 4.324e-3), (&gravity, 3.455e-3)];
    for (scene, measured) in with_friction {
        assert_near(error(scene), measured, &format!("{:?}, every {}", scene.control.law, scene.control.model_every));
    }
    // Most of the error is the friction that the feedforward lacks below its smoothing speed.
    let sharp = |scene: &SceneFile| {
        let mut scene = scene.clone();
        scene.model.friction_smoothing = 0.005;
        error(&scene)
    };
    let [sharp_full, sharp_gravity] = [&full, &gravity].map(sharp);
    assert!(sharp_full < 0.2 * 4.773e-3 && sharp_gravity < 0.3 * 3.455e-3, "{sharp_full} {sharp_gravity}");
    // In a world without friction the better model follows better.
    let smooth = |scene: &SceneFile| {
        let mut scene = scene.clone();
        (scene.model.friction, scene.plant.friction) = (false, false);
        error(&scene)
    };
    let [full, rarely, gravity] = [&full, &rarely, &gravity].map(smooth);
    assert!(full < gravity && gravity < rarely, "{full} {gravity} {rarely}");
}

/// The planar arm, `turns` turns away from the origin, with an encoder of a million counts per turn.
fn far(turns: f64, scalar: ScalarChoice) -> SceneFile {
    let mut scene = load("../tests/fixtures/swing.toml");
    scene.control.scalar = scalar;
    scene.sensors.encoder = true;
    for joint in &mut scene.robot.joints {
        joint.spec.limits.position = (f64::NEG_INFINITY, f64::INFINITY);
        joint.encoder.as_mut().unwrap().counts_per_turn = 1e6;
    }
    let away = |q: &mut Vec<f64>| q.iter_mut().for_each(|q| *q += turns * TAU);
    if let MotionSpec::Quintic { points, .. } = &mut scene.motion {
        points.iter_mut().for_each(|point| away(&mut point.q));
    }
    away(&mut scene.plant.start);
    scene
}

#[test]
fn a_thousand_turns_away_double_tracks_as_at_home_and_single_does_not() {
    use ScalarChoice::{F32, F64};
    let table = [(0.0, [(F32, 1.472e-4), (F64, 1.477e-4)]), (1e3, [(F32, 6.083e-3), (F64, 1.477e-4)])];
    for (turns, scalars) in table {
        for (scalar, measured) in scalars {
            assert_near(error(&far(turns, scalar)), measured, &format!("{turns} turns, {scalar:?}"));
        }
    }
}

#[test]
fn a_run_says_in_which_ticks_its_model_is_evaluated() {
    let slow = run(&load("../../scenes/puma560_slow_model.toml")).summary;
    assert!(slow.table().contains("every 4 ticks, extrapolate between"), "{}", slow.table());
    assert!(!run(&puma()).summary.table().contains("\nmodel"));
}
