//! The simulated world computes only the effects that a scene asks for.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::calls::{self, Effect};
use crate::run::scene_world;
use crate::run::simulation;
use dynamics_core::{Term, Wrench};
use indicatif::ProgressBar;
use nalgebra::Vector3;
use robot_compiler::scene::{ElasticitySpec, Integrator, Ripple};
use robot_compiler::{Breakaway, JointFriction, Robot, SceneFile};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    paths.sort();
    paths
}

/// Ticks of a run: so few that the arm gets no kernel, whose code is not counted.
const TICKS: u64 = 60;

/// A scene in which the arm moves for that long, without any effect.
fn bare(path: &Path) -> SceneFile {
    let mut scene = SceneFile::default_for(Robot::load(path).unwrap());
    scene.duration = Some(0.06);
    (scene.model.friction, scene.plant.friction) = (false, false);
    scene
}

/// Effects that the run of a scene calls, with their counts.
fn called(scene: &SceneFile) -> Vec<(Effect, u64)> {
    calls::taken();
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    let run = simulation::run(scene, &stop, &bar).unwrap();
    assert_eq!(run.record.ticks() as u64, TICKS);
    calls::taken()
}

#[test]
fn a_step_calls_nothing_that_the_scene_did_not_ask_for() {
    let robots = shipped();
    assert!(robots.len() >= 6, "found {}", robots.len());
    for path in robots {
        assert_eq!(called(&bare(&path)), [], "{}", path.display());
    }
}

/// Springs in the joints, with or without play, and a step short enough for the bare Puma's flange.
fn elastic(scene: &mut SceneFile, backlash: Option<Vec<f64>>) {
    scene.plant.step /= 4.0;
    let (stiffness, damping) = (vec![2e3; 6], vec![0.0; 6]);
    scene.plant.elasticity = Some(ElasticitySpec { stiffness, damping, backlash });
}

/// Change of a scene that switches an effect on.
type Ask = fn(&mut SceneFile);

#[test]
fn each_effect_that_is_asked_for_is_called_and_no_other() {
    let puma = shipped().into_iter().find(|path| path.ends_with("puma560.toml")).unwrap();
    let asks: [(Effect, Ask); 15] = [
        (Effect::Friction, |scene| scene.plant.friction = true),
        (Effect::Breakaway, |scene| {
            let breakaway = Some(Breakaway { torque: 1.0, speed: 1.0, load: 0.0 });
            scene.plant.friction = true;
            scene.plant.friction_law =
                Some(vec![JointFriction { coulomb: 0.5, breakaway, ..JointFriction::default() }; 6]);
        }),
        (Effect::TipWrench, |scene| {
            scene.plant.tip_wrench = Some(Wrench { force: Vector3::new(1.0, 0.0, 0.0), moment: Vector3::zeros() });
        }),
        (Effect::Noise, |scene| scene.sensors.position_noise = 1e-6),
        (Effect::Encoder, |scene| scene.sensors.encoder = true),
        (Effect::SensorDelay, |scene| scene.sensors.delay = 1),
        (Effect::ActuatorDelay, |scene| scene.actuators.delay = 1),
        (Effect::Saturation, |scene| scene.actuators.saturation = true),
        (Effect::Lag, |scene| scene.actuators.lag = 1e-3),
        (Effect::Ripple, |scene| scene.actuators.ripple = Some(Ripple { share: 0.1, cycles: 6.0 })),
        (Effect::Elasticity, |scene| elastic(scene, None)),
        (Effect::Backlash, |scene| elastic(scene, Some(vec![1e-3; 6]))),
        (Effect::RotorCoupling, |scene| scene.plant.rotor_coupling = true),
        (Effect::SensorJitter, |scene| scene.sensors.jitter = 1e-4),
        (Effect::ActuatorJitter, |scene| scene.actuators.jitter = 1e-4),
    ];
    assert_eq!(asks.map(|(effect, _)| effect), Effect::ALL);
    for (effect, ask) in asks {
        let mut scene = bare(&puma);
        ask(&mut scene);
        let mut called = called(&scene);
        if effect == Effect::Breakaway {
            // Breakaway is part of friction.
            assert_eq!(called.remove(0).0, Effect::Friction);
        }
        if effect == Effect::Backlash {
            // Backlash is part of the springs.
            assert_eq!(called.remove(0).0, Effect::Elasticity);
        }
        assert_eq!(called.iter().map(|(effect, _)| *effect).collect::<Vec<_>>(), [effect]);
        // Every joint, in each of four slopes, in each of four steps of a tick.
        let times = match effect {
            Effect::Friction | Effect::Breakaway => TICKS * 4 * 4 * 6,
            Effect::TipWrench | Effect::Ripple | Effect::RotorCoupling => TICKS * 4 * 4,
            Effect::Noise | Effect::Encoder => TICKS * 6,
            Effect::SensorDelay | Effect::ActuatorDelay | Effect::Saturation => TICKS,
            // At the start, the middle and the end of each step, and at the end of the tick.
            Effect::Lag => TICKS * (4 * 3 + 1),
            // In each of four slopes of each of sixteen steps of a tick.
            Effect::Elasticity => TICKS * 4 * 16,
            Effect::Backlash => TICKS * 4 * 16 * 6,
            Effect::SensorJitter | Effect::ActuatorJitter => TICKS,
        };
        // Each instant at which joints break loose or come to rest needs some more slopes. There is at least one: the start.
        let more = match effect {
            Effect::Friction | Effect::Breakaway => 1..=times / 50,
            _ => 0..=0,
        };
        assert!(
            more.contains(&(called[0].1 - times)),
            "{effect:?}: {} calls, expected {times} and {more:?}",
            called[0].1
        );
    }
}

#[test]
fn what_only_the_model_has_is_not_in_the_world() {
    let mut scene = bare(&shipped()[0]);
    scene.model.tip_wrench = Term::Constant(Wrench { force: Vector3::new(1.0, 0.0, 0.0), moment: Vector3::zeros() });
    assert_eq!(called(&scene), []);
}

#[test]
fn a_step_that_would_hide_breakaway_is_refused_with_one_that_would_not() {
    let puma = shipped().into_iter().find(|path| path.ends_with("puma560.toml")).unwrap();
    let mut scene = bare(&puma);
    let breakaway = Some(Breakaway { torque: 30.0, speed: 0.02, load: 0.0 });
    scene.plant.friction = true;
    scene.plant.friction_law = Some(vec![JointFriction { coulomb: 1.0, breakaway, ..JointFriction::default() }; 6]);
    let Err(failure) = scene_world::world::<6>(&scene) else { unreachable!("a step of {} s", scene.plant.step) };
    let report = failure.report();
    assert!(report.to_string().contains("is too long for breakaway"), "{report}");
    let help = report.help().unwrap().to_string();
    let step: f64 = help.split(' ').find_map(|word| word.strip_suffix('`').map_or(word, |w| w).parse().ok()).unwrap();
    assert!(step < scene.plant.step, "{help}");
    scene.plant.step = 0.99 * step;
    assert!(scene_world::world::<6>(&scene).is_ok(), "{help}");
}

#[test]
fn a_step_too_long_for_the_springs_is_refused_with_one_that_is_not() {
    let puma = shipped().into_iter().find(|path| path.ends_with("puma560.toml")).unwrap();
    let mut scene = bare(&puma);
    let (stiffness, damping) = (vec![1e3; 6], vec![0.0; 6]);
    scene.plant.elasticity = Some(ElasticitySpec { stiffness, damping, backlash: None });
    let Err(failure) = scene_world::world::<6>(&scene) else { unreachable!("a step of {} s", scene.plant.step) };
    let report = failure.report();
    assert!(report.to_string().contains("is too long for the springs"), "{report}");
    let help = report.help().unwrap().to_string();
    let step: f64 = help.split(' ').find_map(|word| word.parse().ok()).unwrap();
    assert!(step < scene.plant.step, "{help}");
    // The adaptive integrator chooses its own steps.
    let mut adaptive = scene.clone();
    adaptive.plant.integrator = Integrator::Adaptive { tolerance: 1e-6 };
    assert!(scene_world::world::<6>(&adaptive).is_ok());
    // Half of the allowed step, because the steps may become slightly longer when the period is divided.
    scene.plant.step = 0.5 * step;
    assert!(scene_world::world::<6>(&scene).is_ok(), "{help}");
    // A damper can require a shorter step than its spring.
    if let Some(springs) = &mut scene.plant.elasticity {
        springs.damping = vec![10.0; 6];
    }
    assert!(scene_world::world::<6>(&scene).is_err());
}
