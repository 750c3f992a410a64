//! Runs that are computed together have the same results as alone.

use core::sync::atomic::AtomicBool;
use indicatif::ProgressBar;
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::{Integrator, Push, Ripple};
use robot_compiler::{Breakaway, JointFriction};
use sim::failure::Failure;
use sim::run::batch::Kernels;
use sim::run::closed_loop::End;
use sim::run::simulate::{self, Run};
use sim::run::simulation;
use std::fs;
use std::path::{Path, PathBuf};

static GO_ON: AtomicBool = AtomicBool::new(false);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn scene(name: &str, duration: f64) -> SceneFile {
    let mut scene = SceneFile::load(&folder().join(name)).unwrap();
    scene.duration = Some(duration);
    scene
}

fn alone(scene: &SceneFile) -> Result<Run, Failure> {
    simulation::run(scene, &GO_ON, &ProgressBar::hidden())
}

fn side_by_side(scenes: &[SceneFile]) -> Vec<Result<Run, Failure>> {
    simulate::on_desk_side_by_side(&Kernels::default(), scenes.iter().cloned().map(Ok).collect(), &GO_ON, |run| run)
}

/// Checks that every record, end and number equals that of a run alone.
fn hold(scenes: &[SceneFile]) {
    let together = side_by_side(scenes);
    assert_eq!(together.len(), scenes.len());
    for (scene, together) in scenes.iter().zip(together) {
        let (alone, together) = (alone(scene).unwrap(), together.unwrap());
        assert!(together.record == alone.record, "{}: another record", scene.name);
        assert_eq!(together.end, alone.end, "{}", scene.name);
        assert_eq!(together.summary.tracking_rms, alone.summary.tracking_rms, "{}", scene.name);
    }
}

#[test]
fn every_shipped_scene_runs_beside_others_as_alone() {
    let mut seen = 0;
    for entry in fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|it| it != "toml") {
            continue;
        }
        let mut scenes = vec![SceneFile::load(&path).unwrap(); 5];
        for (k, scene) in scenes.iter_mut().enumerate() {
            scene.duration = Some(0.04 + 0.003 * k as f64);
            scene.seed += k as u64;
            scene.plant.masses.iter_mut().for_each(|factor| *factor += 0.05 * k as f64);
        }
        hold(&scenes);
        seen += 1;
    }
    assert!(seen > 15, "{seen} scenes");
}

#[test]
fn runs_of_different_integrators_ends_and_effects_share_a_batch() {
    let plain = scene("puma560_pick.toml", 0.06);
    let with = |change: &dyn Fn(&mut SceneFile)| {
        let mut scene = plain.clone();
        change(&mut scene);
        scene
    };
    let fixed =
        |integrator, step| move |scene: &mut SceneFile| (scene.plant.integrator, scene.plant.step) = (integrator, step);
    let joints = plain.robot.dof();
    hold(&[
        plain.clone(),
        with(&fixed(Integrator::RungeKutta, 0.25e-3)),
        with(&fixed(Integrator::SemiImplicitEuler, 0.1e-3)),
        with(&|scene| scene.plant.integrator = Integrator::Adaptive { tolerance: 1e-6 }),
        with(&|scene| scene.duration = Some(0.11)),
        with(&|scene| scene.plant.friction = false),
        with(&|scene| scene.plant.payload = None),
        with(&|scene| scene.plant.gravity = Vector3::new(1.0, 2.0, -3.0)),
        with(&|scene| scene.plant.rotor_coupling = true),
        with(&|scene| (scene.sensors.jitter, scene.actuators.jitter) = (2e-4, 3e-4)),
        with(&|scene| (scene.sensors.delay, scene.actuators.delay) = (2, 1)),
        with(&|scene| (scene.actuators.lag, scene.sensors.position_noise) = (2e-3, 1e-5)),
        with(&|scene| scene.actuators.ripple = Some(Ripple { share: 0.05, cycles: 12.0 })),
        with(&|scene| {
            let breakaway = Some(Breakaway { torque: 3.0, speed: 0.05, load: 0.01 });
            let friction = JointFriction { viscous: 1.0, coulomb: 2.0, breakaway, ..JointFriction::default() };
            fixed(Integrator::RungeKutta, 0.02e-3)(scene);
            scene.plant.friction_law = Some(vec![friction; joints]);
        }),
        with(&|scene| {
            let plain = JointFriction { viscous: 1.0, coulomb: 2.0, ..JointFriction::default() };
            let more = JointFriction { coulomb_load: 0.02, asymmetry: -0.3, offset: 0.2, ..plain };
            let each = |joint: usize| if joint.is_multiple_of(2) { more } else { plain };
            scene.plant.friction_law = Some((0..joints).map(each).collect());
        }),
        with(&|scene| {
            let mut wrench = dynamics_core::Wrench { force: Vector3::zeros(), moment: Vector3::zeros() };
            wrench.force.x = 30.0;
            scene.plant.push = Some(Push { at: 0.02, duration: 0.01, wrench });
        }),
    ]);
}

#[test]
fn a_run_that_diverges_or_faults_leaves_its_neighbours_alone() {
    let good = scene("puma560_pick.toml", 0.2);
    let (mut wild, mut shaken) = (good.clone(), good.clone());
    // With almost no mass, friction is too stiff for this step.
    (wild.plant.integrator, wild.plant.step) = (Integrator::SemiImplicitEuler, 1e-3);
    wild.plant.masses.iter_mut().for_each(|factor| *factor = 1e-9);
    shaken.sensors.position_noise = 0.5;
    let scenes = [good.clone(), wild, good.clone(), shaken, good.clone(), good];
    let ends: Vec<End> = side_by_side(&scenes).into_iter().map(|run| run.unwrap().end).collect();
    assert!(ends.contains(&End::Complete));
    hold(&scenes);
}

#[test]
fn a_scene_that_cannot_be_run_keeps_its_place() {
    let good = scene("planar2r_swing.toml", 0.02);
    let mut bad = good.clone();
    bad.duration = Some(1e-9);
    let runs = side_by_side(&[good.clone(), bad, good.clone(), good.clone(), good]);
    assert_eq!(runs.iter().map(Result::is_ok).collect::<Vec<_>>(), [true, false, true, true, true]);
}
