//! The closed loop on the desk: properties of every run.

use dynamics_core::control::ControlLaw;
use dynamics_core::trig::Method;
use dynamics_core::{Body, Live, Measurement, Reference, Term, Wrench};
use indicatif::ProgressBar;
use nalgebra::{Matrix3, Vector3};
use robot_compiler::names::Named as _;
use robot_compiler::scene::{DampingAt, IntegralSpec, Integrator, MotionSpec, Push, ScalarChoice, Side};
use robot_compiler::{Robot, RobotJoint, SceneFile};
use sim::failure::Failure;
use sim::run::closed_loop::End;
use sim::run::record::Record;
use sim::run::simulate::{self, Run, RunOptions};
use sim::run::simulation;
use sim::run::target::{Ticked, Torques};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures").join(name)
}

fn swing() -> SceneFile {
    SceneFile::load(&fixture("swing.toml")).unwrap()
}

fn run(scene: &SceneFile) -> Run {
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    simulation::run(scene, &stop, &bar).unwrap()
}

fn csv(record: &Record) -> String {
    let mut bytes = Vec::new();
    record.write_csv(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// Tracking error of the scene at another rate, with four plant steps per tick.
fn at_rate(rate: f64) -> f64 {
    let mut scene = swing();
    scene.control.rate = rate;
    scene.plant.step = 0.25 / rate;
    largest(&run(&scene).summary.tracking_max)
}

#[test]
fn with_an_exact_model_only_the_error_of_holding_the_torque_is_left() {
    // The torque is constant over a tick while the arm moves on: an error of first order in the period, whatever the gains. Measured: 1.54e-4 rad at
    // 1 kHz, 3.86e-5 rad at 4 kHz, for a swing of 0.8 rad in half a second.
    let (slow, fast) = (at_rate(1000.0), at_rate(4000.0));
    assert!((1.4e-4..1.7e-4).contains(&slow), "{slow:e} rad");
    assert!((3.8..4.2).contains(&(slow / fast)), "{slow:e} rad at 1 kHz, {fast:e} rad at 4 kHz");
}

#[test]
fn the_scene_chooses_sine_and_cosine_in_either_precision() {
    for scalar in [ScalarChoice::F32, ScalarChoice::F64] {
        let [ours, libms] = [Method::Polynomial, Method::Libm].map(|trig| {
            let mut scene = swing();
            (scene.control.scalar, scene.control.trig) = (scalar, trig);
            run(&scene)
        });
        assert_eq!((ours.summary.setting.trig.as_str(), libms.summary.setting.trig.as_str()), ("polynomial", "libm"));
        // The two runs differ only in their last bits, which proves that two different methods were used.
        let [one, other] = [&ours, &libms].map(|run| largest(&run.summary.tracking_max));
        assert!((one - other).abs() < 1e-3 * one, "{one:e} and {other:e} rad");
        assert_ne!(csv(&ours.record), csv(&libms.record), "{scalar:?}");
    }
}

#[test]
fn a_payload_a_fifth_too_heavy_keeps_the_error_bounded() {
    let body = |mass| Body { mass, com: Vector3::zeros(), inertia: Matrix3::zeros() };
    let mut scene = swing();
    // Slower than the fixture, so that the heavier arm stays within its torque limits.
    if let MotionSpec::Quintic { points, .. } = &mut scene.motion {
        points[1].duration = Some(1.5);
        points[2].duration = Some(1.5);
    }
    scene.model.payload = Term::Constant(body(1.0));
    scene.plant.payload = Some(body(1.0));
    let exact = run(&scene).summary;
    scene.plant.payload = Some(body(1.2));
    let wrong = run(&scene).summary;
    for summary in [&exact, &wrong] {
        assert!(summary.faults.is_empty() && summary.limits.iter().all(|limits| limits.torque == 0));
    }
    // Measured: 1.85e-5 and 2.09e-3 rad.
    let (exact, wrong) = (largest(&exact.tracking_max), largest(&wrong.tracking_max));
    assert!((1e-5..3e-5).contains(&exact), "{exact:e} rad");
    assert!((1.8e-3..2.4e-3).contains(&wrong), "{wrong:e} rad");
}

#[test]
fn single_precision_tracks_as_double_does() {
    let mut scene = swing();
    let double = run(&scene).summary.tracking_max;
    scene.control.scalar = ScalarChoice::F32;
    let single = run(&scene).summary.tracking_max;
    for i in 0..2 {
        // Measured: 1.0e-9 rad.
        assert_ne!(single[i].to_bits(), double[i].to_bits());
        assert!((single[i] - double[i]).abs() < 4e-9, "{} and {} rad", single[i], double[i]);
    }
}

#[test]
fn every_law_drives_every_robot_without_a_fault() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut robots: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    robots.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    assert!(robots.len() >= 6, "{robots:?}");
    for path in robots {
        let robot = Robot::load(&path).unwrap();
        for &(.., law) in ControlLaw::NAMES {
            let mut scene = SceneFile::default_for(robot.clone());
            scene.control.law = law;
            scene.duration = Some(0.25);
            let done = run(&scene);
            let name = format!("{} with {law:?}", path.display());
            assert_eq!((done.end, done.summary.faults), (End::Complete, vec![]), "{name}");
            assert_eq!(done.summary.ticks, 250, "{name}");
            // Measured: at most 7.8e-4 rad (Puma, from the smoothed friction model) with a law that models the motion. At most 0.032 rad without,
            // because an arm sags under its weight by G / (M0 omega^2). Light joints with simulated drives sag further, by 0.069 rad, and their
            // frames round and delay.
            let models_the_motion =
                [ControlLaw::ComputedTorque, ControlLaw::Feedforward, ControlLaw::Impedance, ControlLaw::Split]
                    .contains(&law);
            let behind_frames = robot.joints.iter().all(RobotJoint::has_own_loop);
            let bound = match (models_the_motion, behind_frames) {
                (true, false) => 1e-3,
                (true, true) => 4e-3,
                (false, false) => 0.05,
                (false, true) => 0.1,
            };
            assert!(largest(&done.summary.tracking_max) < bound, "{name}: {:?}", done.summary.tracking_max);
        }
    }
}

#[test]
fn every_shipped_scene_runs_to_its_end_without_a_fault_but_the_one_that_is_hit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    assert!(scenes.len() >= 6, "{scenes:?}");
    std::thread::scope(|scope| {
        for path in &scenes {
            scope.spawn(move || {
                let done = run(&SceneFile::load(path).unwrap());
                let faults: Vec<u8> = done.summary.faults.iter().map(|fault| fault.code).collect();
                let hit = path.ends_with("puma560_collision.toml");
                assert_eq!(
                    (done.end, faults),
                    (End::Complete, if hit { vec![14] } else { vec![] }),
                    "{}",
                    path.display()
                );
                // Measured: at most 20 mrad, in scenes that intentionally start off their reference.
                assert!(largest(&done.summary.tracking_max) < 0.03, "{}", path.display());
            });
        }
    });
}

#[test]
fn a_seed_gives_the_same_log_to_the_byte_and_another_seed_does_not() {
    let mut scene = swing();
    scene.sensors.position_noise = 1e-4;
    scene.sensors.velocity_noise = 1e-3;
    let first = csv(&run(&scene).record);
    assert_eq!(first, csv(&run(&scene).record));
    scene.seed = 2;
    assert_ne!(first, csv(&run(&scene).record));
}

#[test]
fn effects_that_are_not_there_change_no_bit() {
    let plain = run(&swing());
    let log = csv(&plain.record);
    let changed = |change: &dyn Fn(&mut SceneFile)| {
        let mut scene = swing();
        change(&mut scene);
        csv(&run(&scene).record)
    };
    // The torque limits are never reached, so saturation has no effect. A seed without noise has none either.
    assert!(plain.summary.limits.iter().all(|limits| limits.torque == 0));
    assert_eq!(log, changed(&|scene| scene.actuators.saturation = true));
    assert_eq!(log, changed(&|scene| scene.seed = 99));
    assert_eq!(log, changed(&|scene| scene.plant.tip_wrench = Some(dynamics_core::Wrench::zero())));
    // Every effect that is switched on changes the log.
    assert_ne!(log, changed(&|scene| scene.actuators.lag = 1e-3));
    assert_ne!(log, changed(&|scene| scene.actuators.delay = 1));
    assert_ne!(log, changed(&|scene| scene.sensors.delay = 1));
    assert_ne!(log, changed(&|scene| scene.sensors.encoder = true));
    assert_ne!(log, changed(&|scene| scene.sensors.position_noise = 1e-9));
    assert_ne!(log, changed(&|scene| scene.sensors.jitter = 1e-6));
    assert_ne!(log, changed(&|scene| scene.actuators.jitter = 1e-6));
    assert_ne!(log, changed(&|scene| scene.plant.integrator = Integrator::SemiImplicitEuler));
    assert_ne!(log, changed(&|scene| scene.plant.friction = true));
    assert_ne!(log, changed(&|scene| scene.plant.gravity = Vector3::new(0.0, -9.8, 0.0)));
}

#[test]
fn encoders_friction_lag_delay_and_noise_together_are_followed() {
    let mut scene = swing();
    scene.sensors.encoder = true;
    scene.sensors.position_noise = 2e-5;
    scene.sensors.delay = 1;
    scene.actuators.lag = 5e-4;
    scene.actuators.delay = 1;
    scene.actuators.saturation = true;
    scene.plant.friction = true;
    scene.model.friction = true;
    let done = run(&scene);
    // Measured: 3.6e-3 rad.
    assert_eq!((done.end, done.summary.faults), (End::Complete, vec![]));
    assert!((1e-3..1e-2).contains(&largest(&done.summary.tracking_max)), "{:?}", done.summary.tracking_max);
}

/// Tracking error of the swing with an integrator, and the largest distance of any position from Runge-Kutta's.
fn integrated(integrator: Integrator) -> (f64, f64) {
    let positions = |scene: &SceneFile| -> (f64, Vec<f64>) {
        let done = run(scene);
        let q = (0..2).flat_map(|joint| done.record.joint(joint).map(|sample| sample.q).collect::<Vec<_>>()).collect();
        (largest(&done.summary.tracking_max), q)
    };
    let mut scene = swing();
    let (_, exact) = positions(&scene);
    scene.plant.integrator = integrator;
    let (error, found) = positions(&scene);
    (error, exact.iter().zip(&found).fold(0.0, |worst, (a, b)| f64::max(worst, (a - b).abs())))
}

#[test]
fn every_integrator_makes_the_same_loop_to_its_own_accuracy() {
    let euler = integrated(Integrator::SemiImplicitEuler);
    let [fine, coarse] = [1e-9, 1e-4].map(|tolerance| integrated(Integrator::Adaptive { tolerance }));
    // Measured: 1.84e-4 rad of tracking error, of which 1.43e-4 are the integrator's own, in four steps a tick.
    assert!((1.75e-4..1.95e-4).contains(&euler.0) && (1.35e-4..1.5e-4).contains(&euler.1), "{euler:?}");
    // A tick of the adaptive pair is a single step at either tolerance: 9.1e-15 rad from Runge-Kutta's four steps.
    for (error, off) in [fine, coarse] {
        assert!((1.5e-4..1.6e-4).contains(&error) && (1e-16..1e-13).contains(&off), "{error:e} rad, {off:e} rad");
    }
}

#[test]
fn springs_play_and_jitter_are_felt_and_followed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/puma560_elastic.toml");
    let scene = SceneFile::load(&path).unwrap();
    let worst = |change: &dyn Fn(&mut SceneFile)| {
        let mut scene = scene.clone();
        change(&mut scene);
        let done = run(&scene);
        assert_eq!(done.end, End::Complete);
        (largest(&done.summary.tracking_max), done.summary.faults.first().map(|fault| (fault.tick, fault.code)))
    };
    let all = worst(&|_| ());
    let rigid = worst(&|scene| scene.plant.elasticity = None);
    let still = worst(&|scene| (scene.sensors.jitter, scene.actuators.jitter) = (0.0, 0.0));
    let tight = worst(&|scene| {
        if let Some(springs) = &mut scene.plant.elasticity {
            springs.backlash = None;
        }
    });
    let link = worst(&|scene| scene.sensors.side = Side::Link);
    let near = |found: (f64, Option<_>), before: f64| {
        assert!((found.0 / before - 1.0).abs() < 0.05 && found.1.is_none(), "{found:?}, {before:e} rad before");
    };
    near(all, 2.415e-3);
    near(rigid, 7.65e-4);
    near(still, 2.408e-3);
    near(tight, 2.319e-3);
    assert!(all.0 - still.0 > 4e-6 && all.0 - tight.0 > 5e-5, "{all:?} {still:?} {tight:?}");
    // With link measurements, the same gains excite the springs until the second joint is too fast.
    assert!(matches!(link.1, Some((710..870, 5))), "{link:?}");
}

#[test]
fn a_stale_measurement_brakes_the_arm_and_the_run_goes_on() {
    let mut scene = swing();
    scene.sensors.delay = 5;
    let done = run(&scene);
    assert_eq!(done.end, End::Complete);
    assert_eq!(done.summary.ticks, 1000);
    let faults: Vec<_> = done.summary.faults.iter().map(|fault| (fault.tick, fault.code, fault.joint)).collect();
    // Age 3 is the first beyond the allowed two ticks.
    assert_eq!(faults, [(3, 3, None)]);
    let last = done.record.joint(0).last().unwrap();
    assert_eq!((last.torque, last.qd), (0.0, 0.0));
    assert!(done.summary.table().contains("the brakes held from then on"));
}

/// A controller that simulates Ctrl-C after a number of ticks.
struct Interrupting<'a, C> {
    controller: C,
    left: u32,
    stop: &'a AtomicBool,
}

impl<C: Torques<f64, 2>> Torques<f64, 2> for Interrupting<'_, C> {
    fn set_live(&mut self, live: &Live<f64, 2>) -> miette::Result<()> {
        self.controller.set_live(live)
    }

    fn tick(&mut self, r: &Reference<f64, 2>, m: &Measurement<f64, 2>) -> miette::Result<Ticked<f64, 2>> {
        self.left -= 1;
        if self.left == 0 {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.controller.tick(r, m)
    }
}

fn run_with(scene: &SceneFile, target: &str, stop: &AtomicBool, controller: &mut dyn Torques<f64, 2>) -> Run {
    simulate::with(&RunOptions { scene, target, stop, progress: &ProgressBar::hidden() }, controller).unwrap()
}

#[test]
fn an_interrupted_run_keeps_what_was_recorded() {
    let scene = swing();
    let model = scene.robot.model::<2>().unwrap();
    let stop = AtomicBool::new(false);
    let mut controller = Interrupting { controller: simulate::desk::<f64, 2>(&scene, &model), left: 50, stop: &stop };
    let done = run_with(&scene, "desk", &stop, &mut controller);
    assert_eq!((done.end, done.summary.ticks), (End::Interrupted, 50));
    assert_eq!(done.summary.stopped.as_deref(), Some("interrupted"));
    let whole = csv(&run(&scene).record);
    let part = csv(&done.record);
    assert!(whole.starts_with(&part), "the first 50 ticks are those of the whole run");
}

/// A target that answers a number of ticks and then fails.
struct Dying(u32);

impl Torques<f64, 2> for Dying {
    fn set_live(&mut self, _: &Live<f64, 2>) -> miette::Result<()> {
        Ok(())
    }

    fn tick(&mut self, _: &Reference<f64, 2>, _: &Measurement<f64, 2>) -> miette::Result<Ticked<f64, 2>> {
        self.0 = self.0.checked_sub(1).ok_or_else(|| miette::miette!("no answer"))?;
        let command = dynamics_core::Command::Drive { torque: [0.0; 2], limits: [Default::default(); 2] };
        Ok(Ticked { command, instructions: None })
    }
}

#[test]
fn a_target_that_dies_leaves_the_record_up_to_there() {
    let stop = AtomicBool::new(false);
    let done = run_with(&swing(), "qemu", &stop, &mut Dying(20));
    assert_eq!((done.end, done.record.ticks()), (End::TargetFailed, 20));
    assert_eq!(done.failure.unwrap().to_string(), "no answer");
}

#[test]
fn a_duration_that_no_log_can_hold_is_refused() {
    let mut scene = swing();
    for duration in [1e-5, 1e9, f64::NAN] {
        scene.duration = Some(duration);
        let refused = simulation::run(&scene, &AtomicBool::new(false), &ProgressBar::hidden());
        assert!(matches!(refused, Err(Failure::Input(_))), "{duration}");
    }
}

#[test]
fn integral_action_brings_the_puma_to_rest_within_a_count_whatever_it_holds_and_does_not_hunt() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    for name in ["puma560_pick.toml", "puma560_wrong_payload.toml"] {
        let mut scene = SceneFile::load(&scenes.join(name)).unwrap();
        let MotionSpec::Quintic { points, .. } = &mut scene.motion else { panic!("a quintic") };
        points.last_mut().unwrap().dwell = 4.0;
        let per_turn: Vec<f64> =
            scene.robot.joints.iter().map(|joint| joint.encoder.unwrap().counts_per_turn).collect();
        let count = |joint: usize| TAU / per_turn[joint];
        let counts = |run: &Run| -> Vec<f64> {
            let last_second = run.record.ticks() - 1000;
            let errors = |joint: usize| run.record.joint(joint).skip(last_second).map(|sample| sample.error().abs());
            (0..6).map(|joint| errors(joint).fold(0.0, f64::max) / count(joint)).collect()
        };
        let without = counts(&run(&scene));
        let torque = vec![30.0, 40.0, 20.0, 1.5, 1.5, 1.0];
        let dead_band = (0..6).map(count).collect();
        scene.control.integral = Some(IntegralSpec { time: 0.15, torque, dead_band });
        let with = counts(&run(&scene));
        assert!(largest(&with) < 1.5, "{name}: {with:?} counts");
        assert!(largest(&without) > 2.0, "{name}: {without:?} counts without it");
    }
}

/// Error of the elbow, rad, twelve seconds after the arm has reached a position under a constant wrench, in tip axes, that no model includes.
fn elbow_pushed(law: ControlLaw, place: [f64; 2], stiffness: Option<f64>) -> f64 {
    let mut scene = swing();
    let MotionSpec::Quintic { points, .. } = &mut scene.motion else { panic!("a quintic") };
    points.truncate(2);
    points[1].q = place.to_vec();
    points[1].dwell = 12.0;
    (scene.control.law, scene.control.stiffness) = (law, stiffness.map(|stiffness| vec![stiffness; 2]));
    let wrench = Wrench { force: Vector3::new(3.0, PUSH, 0.0), moment: Vector3::zeros() };
    scene.plant.push = Some(Push { at: 0.0, duration: 20.0, wrench });
    let done = run(&scene);
    assert_eq!((done.end, done.summary.faults), (End::Complete, vec![]));
    done.record.joint(1).nth(done.record.ticks() - 1).unwrap().error()
}

/// Force across the last link, N.
const PUSH: f64 = 2.0;

/// Overshoot of the shoulder past its reference when a push on the stretched arm ends, relative to the deflection by the push. The gains are chosen
/// for the start of the motion, where the arm is folded.
fn swing_back(damping_at: DampingAt) -> f64 {
    let mut scene = swing();
    let MotionSpec::Quintic { points, .. } = &mut scene.motion else { panic!("a quintic") };
    points.truncate(2);
    (points[0].q, points[1].q, points[1].dwell) = (vec![0.4, 2.8], vec![0.4, 0.1], 6.0);
    points[1].duration = Some(1.5);
    scene.plant.start = vec![0.4, 2.8];
    (scene.control.law, scene.control.stiffness) = (ControlLaw::Impedance, Some(vec![60.0; 2]));
    (scene.control.damping, scene.control.damping_at) = (vec![1.0; 2], damping_at);
    let wrench = Wrench { force: Vector3::new(0.0, 2.0, 0.0), moment: Vector3::zeros() };
    scene.plant.push = Some(Push { at: 3.0, duration: 2.0, wrench });
    let done = run(&scene);
    assert_eq!((done.end, done.summary.faults), (End::Complete, vec![]));
    let errors: Vec<f64> = done.record.joint(0).skip(3000).map(|sample| sample.error()).collect();
    let (low, high) = errors.iter().fold((0.0, 0.0), |(low, high): (f64, f64), e| (low.min(*e), high.max(*e)));
    // The arm is pushed to one side and swings to the other.
    low.abs().min(high.abs()) / low.abs().max(high.abs())
}

#[test]
fn damping_by_the_posture_keeps_a_stretched_arm_from_swinging() {
    let (start, posture) = (swing_back(DampingAt::Start), swing_back(DampingAt::Posture));
    assert!(start > 0.02 && posture < 0.2 * start, "{start} and {posture}");
}

#[test]
fn an_impedance_gives_way_by_the_torque_over_its_stiffness_in_every_posture_and_computed_torque_does_not() {
    let lever = 0.8;
    let places = [[0.8, 1.0], [0.8, 0.1], [-0.5, 2.0]];
    for stiffness in [20.0, 60.0] {
        for place in places {
            let error = elbow_pushed(ControlLaw::Impedance, place, Some(stiffness));
            let expected = -PUSH * lever / stiffness;
            assert!((error - expected).abs() < 1e-4 * expected.abs(), "{place:?}: {error}, by hand {expected}");
        }
    }
    // A spring in acceleration has a stiffness proportional to the inertia that it moves.
    let [one, _, other] = places.map(|place| elbow_pushed(ControlLaw::ComputedTorque, place, None));
    assert!((one / other - 1.0).abs() > 0.1, "{one} and {other}");
}
