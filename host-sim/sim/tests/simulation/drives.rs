//! Simulated drives: the effect of the frames on measurement and torque, their failures, and their effect on the closed loop.

use actuator_model::mit::Setpoint;
use dynamics_core::Sensed;
use dynamics_core::safety::SafeAction;
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use robot_compiler::drive::JointDrive;
use robot_compiler::scene::{DriveFailure, FailureKind};
use sim::plant::drives::Drives;
use sim::plant::{Clock, State};
use sim::run::closed_loop::World;
use sim::run::scene_world;
use sim::run::simulate::{self, Run, RunOptions};
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn wave() -> SceneFile {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    SceneFile::load(&scenes.join("examples/mit6_wave.toml")).unwrap()
}

fn run_in(world: &mut World<6>, scene: &SceneFile) -> Run {
    let mut controller = simulate::desk::<f32, 6>(scene, &scene.robot.model().unwrap());
    let (stop, progress) = (&AtomicBool::new(false), &ProgressBar::hidden());
    simulate::within(world, &RunOptions { scene, target: "desk", stop, progress }, &mut controller).unwrap()
}

fn run(scene: &SceneFile) -> Run {
    run_in(&mut scene_world::world::<6>(scene).unwrap(), scene)
}

/// Root mean square of the tracking errors of all joints, rad.
fn rms(run: &Run) -> f64 {
    let errors = &run.summary.tracking_rms;
    (errors.iter().map(|x| x * x).sum::<f64>() / errors.len() as f64).sqrt()
}

/// A world whose drives are on.
fn running(scene: &SceneFile) -> World<6> {
    let mut world = scene_world::world::<6>(scene).unwrap();
    world.switch_on();
    world
}

fn sensed(world: &mut World<6>) -> State<6> {
    let Sensed::State { q, qd } = world.sense::<f64>().measurement.sensed else { panic!("drives report a state") };
    State { q, qd }
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
}

#[test]
fn the_first_measurement_is_the_start_cut_off_to_steps_of_the_frames() {
    let mut world = running(&wave());
    let sensing = world.sense::<f64>();
    assert_eq!((sensing.measurement.age_ticks, sensing.drive_fault, world.fault(&sensing)), (0, [false; 6], None));
    let Sensed::State { q, qd } = sensing.measurement.sensed else { panic!("drives report a state") };
    // Base: 12.5 rad above the low end are 32,767.5 steps of 25 / 65,535 rad; half a step is cut off.
    assert_near(q[0], -0.5 * 25.0 / 65_535.0, 1e-6);
    // Shoulder: at -0.6 + 0.35 rad the shaft is 32,112.15 steps up; cutting 0.15 off moves it down, and the joint up.
    assert_near(q[1], 0.6 + 0.15 * 25.0 / 65_535.0, 2e-6);
    // Zero is half a step of 16 / 4095 rad/s above a code. The shoulder's shaft turns in the opposite direction.
    assert_near(qd[0], -0.5 * 16.0 / 4095.0, 1e-6);
    assert_near(qd[1], 0.5 * 16.0 / 4095.0, 1e-6);
}

#[test]
fn a_measurement_is_the_state_of_one_tick_before() {
    let mut world = running(&wave());
    let mut before = *world.plant.state();
    for tick in 0..100 {
        let read = sensed(&mut world);
        for i in 0..6 {
            // The error is at most one step, 25 / 65,535 rad, and the rounding of single precision.
            assert_near(read.q[i], before.q[i], 3.9e-4);
        }
        if tick > 60 {
            let now = world.plant.state().q[0];
            assert!((now - before.q[0]).abs() > 6e-4, "the arm moves too slowly to tell the ticks apart: {now}");
        }
        before = *world.plant.state();
        world.drive(&[10.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    }
}

#[test]
fn a_torque_arrives_as_the_nearest_code_from_the_first_tick_on() {
    let mut world = running(&wave());
    sensed(&mut world);
    world.drive(&[0.1; 6]).unwrap();
    let drives = world.drives.as_mut().unwrap();
    let mut torque = |joint| drives.electronics(joint).unwrap().torque();
    // 60.1 N m above the low end are 2050.91 steps of 120 / 4095 N m: the nearest is 2051. Direction -1: 2044.09, so 2044.
    assert_near(torque(0), 2051.0 * 120.0 / 4095.0 - 60.0, 1e-9);
    assert_near(torque(1), 2044.0 * 120.0 / 4095.0 - 60.0, 1e-9);
    assert!(!drives.brakes_hold());
}

#[test]
fn frames_and_their_tick_of_delay_are_most_of_the_error() {
    let mut scene = wave();
    let with = rms(&run(&scene));
    scene.actuators.ideal = true;
    let without = rms(&run(&scene));
    assert!((1.3e-3..1.6e-3).contains(&with), "{with:e} rad");
    assert!((1.2e-5..1.5e-5).contains(&without), "{without:e} rad");
}

#[test]
fn ideal_drives_give_the_bits_that_they_gave_before_drives_were_simulated() {
    let mut scene = wave();
    scene.actuators.ideal = true;
    let mut csv = Vec::new();
    run(&scene).record.write_csv(&mut csv).unwrap();
    // FNV-1a of the log.
    let hash = csv
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    assert_eq!(hash, 0x46f4_75ca_7794_498d);
}

/// A scene whose drives report temperature and errors. The shoulder's drive fails at half a second.
fn failing(kind: FailureKind) -> SceneFile {
    let mut scene = wave();
    for joint in &mut scene.robot.joints {
        let Some(JointDrive::Mit(spec)) = &mut joint.drive else { panic!("an actuator") };
        (spec.reply_bytes, spec.temperature_offset) = (8, Some(-40.0));
    }
    scene.safety.temperature = (0.0, 80.0);
    scene.actuators.failure = Some(DriveFailure { joint: 1, at: 0.5, kind });
    scene
}

#[test]
fn a_drive_that_fails_ends_in_the_fault_that_the_firmware_gives() {
    for (kind, code, joint, tick) in [
        (FailureKind::Error, 11, Some(2), 501),
        (FailureKind::Hot, 13, None, 501),
        // The drive detects it in the tick, and reports it in the next reply.
        (FailureKind::UnderVoltage, 11, Some(2), 502),
        // A measurement that is three ticks old exceeds `age_max`.
        (FailureKind::Unplugged, 3, None, 503),
    ] {
        let run = run(&failing(kind));
        let found: Vec<_> = run.summary.faults.iter().map(|fault| (fault.code, fault.joint, fault.tick)).collect();
        assert_eq!(found, [(code, joint, tick)], "{kind:?}");
    }
}

#[test]
fn a_drive_whose_replies_carry_no_error_is_found_by_the_torque_that_it_withholds() {
    let mut scene = wave();
    scene.actuators.failure = Some(DriveFailure { joint: 1, at: 0.5, kind: FailureKind::Error });
    let run = run(&scene);
    let found: Vec<_> = run.summary.faults.iter().map(|fault| (fault.code, fault.joint, fault.tick)).collect();
    assert_eq!(found, [(11, Some(2), 506)]);
}

#[test]
fn a_drive_that_hears_nothing_gives_its_last_torque_until_its_timeout() {
    let mut world = running(&wave());
    for _ in 0..5 {
        sensed(&mut world);
        world.drive(&[1.0; 6]).unwrap();
    }
    for bus in 0..2 {
        world.drives.as_mut().unwrap().bus(bus).stuck = true;
    }
    let mut last = 0;
    for tick in 1..=150 {
        let age = world.sense::<f64>().measurement.age_ticks;
        // The reply to the last command that arrived is still the latest.
        assert_eq!(age, tick - 1);
        world.drive(&[1.0; 6]).unwrap();
        if world.drives.as_mut().unwrap().electronics(0).unwrap().torque() != 0.0 {
            last = tick;
        }
    }
    // A tenth of a second after the last frame, which was sent a tick before the first of these ticks.
    assert!((98..=100).contains(&last), "{last}");
}

#[test]
fn a_damped_stop_is_the_actuators_own_and_a_finer_loop_damps_more_truly() {
    let stop = |loop_rate: f64| {
        let mut scene = wave();
        scene.actuators.loop_rate = loop_rate;
        let mut world = running(&scene);
        for _ in 0..50 {
            sensed(&mut world);
            world.drive(&[3.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
        }
        sensed(&mut world);
        let speed = world.plant.state().qd[0];
        world.stop().unwrap();
        let electronics = world.drives.as_mut().unwrap().electronics(0).unwrap();
        (speed, electronics.told(), electronics.torque(), world)
    };
    let (speed, told, torque, mut once) = stop(1000.0);
    // Zero is not a code: velocity and torque are half a step off. A damping of 4 in the range 0 to 5 is exactly code 3276.
    let expected =
        Setpoint { position: 12.5 / 65_535.0, velocity: 8.0 / 4095.0, kp: 0.0, kd: 4.0, torque: 60.0 / 4095.0 };
    for (found, expected) in [
        (told.position, expected.position),
        (told.velocity, expected.velocity),
        (told.kp, expected.kp),
        (told.kd, expected.kd),
        (told.torque, expected.torque),
    ] {
        assert_near(found, expected, 1e-9);
    }
    assert_near(torque, 4.0 * (expected.velocity - speed) + expected.torque, 1e-9);
    assert!(speed > 0.1 && torque < 0.0, "{speed} rad/s, {torque} N m");
    let (.., mut ten) = stop(10_000.0);
    let (.., mut many) = stop(100_000.0);
    let [coarse, fine, finest] = [&mut once, &mut ten, &mut many].map(|world| {
        for _ in 0..20 {
            sensed(world);
            world.stop().unwrap();
        }
        world.plant.state().qd[0]
    });
    assert!((coarse - finest).abs() > 5.0 * (fine - finest).abs(), "{coarse}, {fine}, {finest} rad/s");
}

#[test]
fn brakes_hold_the_arm_where_the_safe_action_says_so() {
    let mut scene = failing(FailureKind::Error);
    scene.safety.safe_action = SafeAction::Brake;
    let braked = run(&scene);
    let at = |run: &Run, tick| run.record.joint(1).nth(tick).unwrap().q;
    assert!((at(&braked, 700) - at(&braked, 2900)).abs() < 1e-12);
    scene.safety.safe_action = SafeAction::DampedStop;
    let damped = run(&scene);
    assert!((at(&damped, 700) - at(&damped, 2900)).abs() > 0.1, "a damper holds no weight");
}

#[test]
fn an_actuator_that_turns_against_the_robot_file_does_not_go_unseen() {
    let scene = wave();
    let clock = Clock { period: scene.period(), steps_per_tick: scene.steps_per_tick() };
    for (joint, mutant) in (0..6).map(|joint| (joint, true)).chain([(0, false)]) {
        let (mut specs, wires) = scene.simulated_drives::<6>().unwrap();
        if mutant {
            specs[joint].ratio = -specs[joint].ratio;
        }
        let mut world = scene_world::world::<6>(&scene).unwrap();
        world.drives = Some(Drives::new(&specs, wires, clock, scene.actuators.loop_rate));
        let run = run_in(&mut world, &scene);
        let lost = !run.summary.faults.is_empty() || run.summary.tracking_max[joint] > 0.1;
        assert_eq!(lost, mutant, "joint {}: {:?}", joint + 1, run.summary.faults);
    }
}

#[test]
fn six_drives_on_one_fd_bus_move_the_arm_as_on_two_classic_ones() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let fd = run(&SceneFile::load(&scenes.join("examples/mit6_fd_wave.toml")).unwrap());
    let classic = run(&wave());
    assert!(fd.summary.faults.is_empty(), "{:?}", fd.summary.faults);
    let moved = |run: &Run| -> Vec<Vec<f64>> {
        (0..6).map(|joint| run.record.joint(joint).map(|sample| sample.q).collect()).collect()
    };
    assert_eq!(moved(&fd), moved(&classic));
    // Two joints on each of three buses.
    let mut three = wave();
    for (index, joint) in three.robot.joints.iter_mut().enumerate() {
        let Some(JointDrive::Mit(spec)) = &mut joint.drive else { panic!("an MIT actuator") };
        spec.bus = index as u8 / 2 + 1;
    }
    assert_eq!(moved(&run(&three)), moved(&classic));
}

#[test]
fn every_kind_of_drive_has_a_simulated_drive_of_its_own() {
    for protocol in robot_compiler::drive::Protocol::ALL {
        let name = protocol.facts().name;
        assert!(actuator_model::mit::Language::named(name).is_some(), "{name} would be simulated as another kind");
    }
}

/// The scene with drives of the kind `myactuator`.
fn my_actuators() -> SceneFile {
    let mut scene = wave();
    for joint in &mut scene.robot.joints {
        let Some(JointDrive::Mit(spec)) = &mut joint.drive else { panic!("an actuator") };
        spec.protocol = robot_compiler::drive::Protocol::MyActuator;
        (spec.reply_id, spec.reply_bytes) = (0x500 + u16::from(spec.id), 8);
    }
    scene
}

#[test]
fn drives_with_the_packing_of_the_mini_cheetah_and_other_identifiers_move_the_arm_as_it_does() {
    let (theirs, mini_cheetahs) = (run(&my_actuators()), run(&wave()));
    assert!(theirs.summary.faults.is_empty(), "{:?}", theirs.summary.faults);
    assert_near(rms(&theirs), rms(&mini_cheetahs), 1e-5);
    // Its replies carry no error: the torque is missing, as with a mini-cheetah whose replies have six bytes.
    for (kind, code, joint, tick) in [(FailureKind::Error, 11, Some(2), 506), (FailureKind::Unplugged, 3, None, 503)] {
        let mut scene = my_actuators();
        scene.actuators.failure = Some(DriveFailure { joint: 1, at: 0.5, kind });
        let found: Vec<_> = run(&scene).summary.faults.iter().map(|it| (it.code, it.joint, it.tick)).collect();
        assert_eq!(found, [(code, joint, tick)], "{kind:?}");
    }
}
