//! The coupling of rotors with their links as a term of the plant, compared with the core's own formula and with energy.

use dynamics_core::chapter::posture::Chain;
use dynamics_core::chapter::rotor_coupling::{Carried, Rotors};
use dynamics_core::trig::{Libm, Trig};
use dynamics_core::{Inertia, JointSpec};
use indicatif::ProgressBar;
use nalgebra::{SVector, Vector3};
use robot_compiler::SceneFile;
use sim::plant::actuator::ActuatorSettings;
use sim::plant::{Arm, Clock, Plant};
use sim::run::scene_world;
use sim::run::simulation;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

const N: usize = 6;

fn puma() -> SceneFile {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/puma560_ideal.toml");
    SceneFile::load(&path).unwrap()
}

fn arm() -> Arm<N> {
    Arm { payload: None, tip_wrench: None, ..scene_world::arm::<N>(&puma()).unwrap() }
}

fn rotors(joints: &[JointSpec; N]) -> Rotors<f64, N> {
    Rotors { inertia: joints.map(|joint| joint.rotor.inertia), gear: joints.map(|joint| joint.rotor.gear) }
}

/// The core's formula computes the torques for the coupled plant's accelerations: they equal the torques that drove the plant.
#[test]
fn the_coupled_plant_obeys_lagranges_equation_of_the_completed_energy() {
    let arm = arm();
    let model = puma().robot.model::<N>().unwrap();
    let (mut worst, mut without) = (0.0_f64, 0.0_f64);
    for k in 0..50 {
        let wave = |n: usize, size: f64| size * (0.7 * k as f64 + 1.3 * n as f64).sin();
        let q = std::array::from_fn(|i| wave(i, 1.5));
        let qd = std::array::from_fn(|i| wave(i + 7, 2.0));
        let drive = std::array::from_fn(|i| wave(i + 13, 20.0));
        let coupled = arm.mechanism().with_rotor_coupling(&arm.joints).acceleration(&q, &qd, &drive).unwrap();
        let usual = arm.acceleration(&q, &qd, &drive).unwrap();
        let posture = Chain::new(&model, &Inertia::zero()).posture(&Libm.sin_cos_all(&q), &q);
        let terms = arm.terms(&q, &qd);
        let taken = |qdd: &[f64; N]| -> f64 {
            let extra = rotors(&arm.joints).extra_torque(&posture, Carried::ByLink, &qd, qdd);
            let inertial = terms.mass_matrix * SVector::from(*qdd);
            let off = |i: usize| inertial[i] + terms.coriolis[i] + terms.gravity[i] + extra[i] - drive[i];
            (0..N).map(|i| off(i).abs()).fold(0.0, f64::max)
        };
        worst = worst.max(taken(&coupled));
        without = without.max(taken(&usual));
    }
    assert!(worst < 1e-10 && without > 1e-2, "{worst:e} N m, without the coupling {without:e} N m");
}

/// Without gravity, torque and friction, the completed energy is constant; the usual energy is not.
#[test]
fn a_free_arm_keeps_the_completed_energy() {
    let arm = Arm { gravity: Vector3::zeros(), ..arm() };
    let model = puma().robot.model::<N>().unwrap();
    let clock = Clock { period: 1e-3, steps_per_tick: 4 };
    let mut plant = Plant::new(&arm, None, ActuatorSettings::default(), clock, [0.3, 0.4, -1.2, 0.2, 0.5, 0.1])
        .with_rotor_coupling(&arm.joints);
    // Torques for a while, then none.
    for _ in 0..100 {
        plant.drive(&[20.0, 15.0, -10.0, 1.0, -1.0, 1.0]).unwrap();
    }
    let energies = |plant: &Plant<N>| {
        let state = plant.state();
        let posture = Chain::new(&model, &Inertia::zero()).posture(&Libm.sin_cos_all(&state.q), &state.q);
        let usual = arm.kinetic(&state.q, &state.qd);
        let rotors = rotors(&arm.joints);
        // The completed energy, minus the part that the link's tensor already includes.
        let carried = Rotors { gear: [0.0; N], ..rotors }.complete_energy(&posture, &state.qd);
        let coupling = rotors.complete_energy(&posture, &state.qd) - rotors.reflected_energy(&state.qd) - carried;
        [usual + coupling, usual]
    };
    let start = energies(&plant);
    let mut drift = [0.0_f64; 2];
    for _ in 0..400 {
        plant.drive(&[0.0; N]).unwrap();
        let now = energies(&plant);
        drift = std::array::from_fn(|k| drift[k].max((now[k] / start[k] - 1.0).abs()));
    }
    assert!(drift[0] < 1e-9 && drift[1] > 1e-5, "{drift:?}");
}

/// The scene's key switches the coupling on. Without the key, the run is unchanged.
#[test]
fn the_key_of_the_scene_couples_the_rotors() {
    let run = |coupled: bool| {
        let mut scene = puma();
        scene.plant.rotor_coupling = coupled;
        simulation::run(&scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap().summary.tracking_max
    };
    let (usual, coupled) = (run(false), run(true));
    assert!(usual != coupled, "{usual:?}");
    assert!(coupled.iter().zip(&usual).any(|(c, u)| *c > 1.5 * u), "{coupled:?} {usual:?}");
}
