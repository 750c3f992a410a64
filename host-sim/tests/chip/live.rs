//! Live terms in the chip: gravity, payload, tip wrench and rotors that are sent over the link instead of being built in.

use board::chip::{Chip, ChipError, build_firmware, hello};
use dynamics_core::{Command, Inertia, Live, Measurement, Reference, Sensed};
use indicatif::ProgressBar;
use link::{Pacing, Refusal};
use robot_compiler::SceneFile;
use sim::run::closed_loop::End;
use sim::run::simulate::{self, Run, RunOptions};
use sim::run::target::{CommandComparison, Parity, Ticked, Torques};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Joints of the arm in [`scene`].
const N: usize = 6;

/// Number of ticks in the run.
const TICKS: u64 = 250;

fn scene() -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/live.toml")).unwrap()
}

fn chip(scene: &SceneFile) -> Chip {
    let model = scene.robot.model::<N>().unwrap();
    let hello = hello(scene, &model, Pacing::LockStep);
    Chip::start(&build_firmware(&scene.path).unwrap(), hello).unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

#[test]
fn a_closed_loop_with_every_term_live_has_identical_bits_and_follows_its_reference() {
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    let run = board::chip::on_chip::run(&scene(), &stop, &bar).unwrap();
    assert_eq!(run.end, End::Complete);
    assert!(run.summary.faults.is_empty());
    assert_eq!(run.summary.parity, Some(Parity { ticks: TICKS, mismatches: 0 }));
    // The remaining error comes from holding the torque for a tick. Measured: 3.27e-5 rad.
    let error = largest(&run.summary.tracking_max);
    assert!((3e-5..3.6e-5).contains(&error), "{error:e} rad");
}

/// A change that falsifies the live inputs.
type Change = fn(&mut Live<f32, N>);

/// A desk that receives different live inputs from those of the chip.
struct Misinformed<C>(C, Change);

impl<C: Torques<f32, N>> Torques<f32, N> for Misinformed<C> {
    fn set_live(&mut self, live: &Live<f32, N>) -> miette::Result<()> {
        let mut other = *live;
        self.1(&mut other);
        self.0.set_live(&other)
    }

    fn tick(&mut self, r: &Reference<f32, N>, m: &Measurement<f32, N>) -> miette::Result<Ticked<f32, N>> {
        self.0.tick(r, m)
    }
}

fn run_with(scene: &SceneFile, target: &str, controller: &mut dyn Torques<f32, N>) -> Run {
    let (stop, progress) = (&AtomicBool::new(false), &ProgressBar::hidden());
    simulate::with(&RunOptions { scene, target, stop, progress }, controller).unwrap()
}

#[test]
fn a_desk_that_is_told_anything_else_differs_in_every_term() {
    let scene = scene();
    let model = scene.robot.model::<N>().unwrap();
    let other: [(&str, Change); 4] = [
        ("gravity", |live| live.gravity.x *= 1.001),
        ("payload", |live| live.payload.mass *= 1.001),
        ("tip wrench", |live| live.tip_wrench.force.y *= 1.001),
        ("rotor", |live| live.rotor[2] *= 1.001),
    ];
    for (term, change) in other {
        let desk = Misinformed(simulate::desk::<f32, N>(&scene, &model), change);
        let mut both = CommandComparison::new(chip(&scene), desk);
        let run = run_with(&scene, "qemu", &mut both);
        let Parity { ticks, mismatches } = both.parity();
        println!("{term}: {mismatches} of {ticks} ticks differ");
        assert_eq!((run.end, ticks), (End::Complete, TICKS));
        assert!(mismatches > TICKS * 9 / 10, "{term}: {mismatches} of {ticks}");
    }
}

#[test]
fn an_arm_whose_controller_misses_a_live_term_is_off_its_reference() {
    let scene = scene();
    let model = scene.robot.model::<N>().unwrap();
    let missing: [(&str, Change, f64); 4] = [
        ("gravity", |live| live.gravity.fill(0.0), 6.974e-3),
        ("payload", |live| live.payload = Inertia::zero(), 3.904e-3),
        ("tip wrench", |live| live.tip_wrench.force.fill(0.0), 4.568e-4),
        ("rotor", |live| live.rotor = [0.0; N], 1.312e-1),
    ];
    for (term, change, measured) in missing {
        let mut desk = Misinformed(simulate::desk::<f32, N>(&scene, &model), change);
        let run = run_with(&scene, "desk", &mut desk);
        let error = largest(&run.summary.tracking_max);
        assert!((0.95..1.05).contains(&(error / measured)), "without {term}: {error:.3e} rad");
    }
}

/// A state without tracking error, so that the torque equals the inverse dynamics.
fn state() -> (Reference<f32, N>, Measurement<f32, N>) {
    let (q, qd) = ([0.2, 0.8, -1.5, 0.1, 0.4, 0.2], [0.3, -0.2, 0.4, 0.1, -0.5, 0.2]);
    let reference = Reference { q, qd, qdd: [1.0, -0.5, 0.8, 2.0, -1.0, 0.5] };
    (reference, Measurement { sensed: Sensed::State { q, qd }, age_ticks: 0 })
}

fn torque(command: &Command<f32, N>) -> Option<[u32; N]> {
    match command {
        Command::Drive { torque, .. } => Some(torque.map(f32::to_bits)),
        Command::Brake(_) => None,
    }
}

#[test]
fn a_payload_that_is_laid_down_and_taken_up_again_between_ticks_gives_the_bits_of_the_desk_and_its_own_back() {
    let scene = scene();
    let model = scene.robot.model::<N>().unwrap();
    let mut chip = chip(&scene);
    let mut desk = simulate::desk::<f32, N>(&scene, &model);
    let (reference, measurement) = state();
    let holding = simulate::live_inputs::<f32, N>(&scene, &model);
    let empty = Live { payload: Inertia::zero(), ..holding };
    // -0 differs from 0: a tick must not reuse the value that was computed for the other.
    let minus = Live { gravity: -empty.gravity * 0.0, ..empty };
    let plus = Live { gravity: empty.gravity * 0.0, ..empty };
    let mut torques = Vec::new();
    for live in [holding, holding, empty, holding, plus, minus] {
        chip.set_live(&live).unwrap();
        *desk.live_mut() = live;
        let reply = chip.tick(&reference, &measurement).unwrap();
        let expected = desk.tick(&reference, &measurement);
        assert_eq!(torque(&reply.command), torque(&expected), "{:?} and {expected:?}", reply.command);
        torques.push(torque(&reply.command).unwrap());
    }
    assert_eq!(torques[0], torques[1]);
    assert_ne!(torques[1], torques[2], "the payload is felt");
    assert_eq!(torques[3], torques[0], "laying it down leaves no trace");
}

#[test]
fn live_inputs_that_are_not_finite_are_refused_by_name_in_the_next_tick() {
    let scene = scene();
    let model = scene.robot.model::<N>().unwrap();
    let mut chip = chip(&scene);
    let (reference, measurement) = state();
    let mut live = simulate::live_inputs::<f32, N>(&scene, &model);
    live.gravity.z = f32::NAN;
    chip.set_live(&live).unwrap();
    let error = chip.tick(&reference, &measurement).unwrap_err();
    assert!(matches!(error, ChipError::Refused(Refusal::NonFiniteLive)), "{error}");
    assert_eq!(error.to_string(), "the chip refused: a live input is not a finite number");
}
