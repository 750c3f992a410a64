//! Contents read from a scene file: defaults, terms, and robots of both kinds.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]

use dynamics_core::control::ControlLaw;
use dynamics_core::safety::heat::HeatRules;
use dynamics_core::safety::{JointRules, Rules, SafeAction};
use dynamics_core::trig::Method;
use dynamics_core::{Live, Term};
use nalgebra::Vector3;
use robot_compiler::scene::{FIRST_MOTION, MotionSpec, ScalarChoice, SensorSpec};
use robot_compiler::{Breakaway, FileError, JointFriction, JointHeat, SceneFile, with_dof};
use std::path::Path;

use crate::common::standing;

/// A scene with an arm at rest, with these lines added; paths are relative to `tests/data`.
fn scene(robot: &str, lines: &str) -> Result<SceneFile, FileError> {
    let q = if robot.contains("puma") { "[0.0, 0.5, 0.0, 0.0, 0.0, 0.0]" } else { "[0.0, 0.5]" };
    let motion = format!("[motion]\nkind = \"hold\"\nq = {q}\nduration = 1.5\n");
    let text = format!("name = \"test\"\nrobot = \"{robot}\"\n{lines}\n{motion}");
    SceneFile::from_toml_str(&text, Path::new("tests/data/scene.toml"))
}

#[test]
fn a_scene_that_says_little_gets_the_documented_defaults() {
    let puma = scene("../../../robots/puma560.toml", "").unwrap();
    assert_eq!((puma.duration, puma.seed), (None, 0));
    assert_eq!(puma.motion, MotionSpec::Hold { q: vec![0.0, 0.5, 0.0, 0.0, 0.0, 0.0], duration: 1.5 });
    assert_eq!(puma.model.gravity, Term::Constant(Vector3::new(0.0, 0.0, -9.81)));
    assert_eq!((puma.model.payload, puma.model.tip_wrench), (Term::Absent, Term::Absent));
    assert_eq!((puma.model.rotor, puma.model.coriolis.clone()), (Term::Constant(()), Term::Live));
    assert!(puma.model.friction && puma.plant.friction);
    assert_eq!((puma.control.rate, puma.control.law, puma.control.age_max), (1000.0, ControlLaw::ComputedTorque, 2));
    assert_eq!((puma.control.trig, puma.control.scalar), (Method::Polynomial, ScalarChoice::F32));
    assert_eq!(
        (puma.control.natural_frequency.as_slice(), puma.control.damping.as_slice()),
        (&[30.0; 6][..], &[1.0; 6][..])
    );
    assert_eq!((puma.plant.step, puma.steps_per_tick()), (0.000_25, 4));
    assert_eq!(puma.plant.start, puma.motion.start());
    assert_eq!(puma.sensors, SensorSpec::default());
    // A robot without rotors and friction has no such terms.
    let planar = scene("../../../robots/planar2r.toml", "").unwrap();
    assert_eq!(planar.model.rotor, Term::Absent);
    assert!(!planar.model.friction && !planar.plant.friction);
}

#[test]
fn live_terms_are_fed_from_the_plant() {
    let live = scene(
        "../../../robots/puma560.toml",
        "[model]\ngravity = \"live\"\npayload = \"live\"\ntip_wrench = \"live\"\nrotor = \"live\"\n\
         [plant]\ngravity = [0, 0, 9.81]\npayload = { mass = 2, com = [0, 0, 0.1] }\ntip_wrench = { force = [1, 2, 3] }\n",
    )
    .unwrap();
    let model = live.robot.model::<6>().unwrap();
    let (scene, values) = (live.scene(&model), live.live(&model));
    assert_eq!((scene.gravity, scene.payload, scene.tip_wrench), (Term::Live, Term::Live, Term::Live));
    assert_eq!(values.gravity, Vector3::new(0.0, 0.0, 9.81));
    assert_eq!(values.payload.first_moment, Vector3::new(0.0, 0.0, 0.2));
    assert_eq!(values.tip_wrench.force, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(values.rotor[0], 62.6111 * 62.6111 * 2e-4);
    assert_eq!(scene.rotor.value(&values.rotor), Some(&values.rotor));
}

#[test]
fn the_plant_takes_over_what_the_model_holds_unless_it_says_otherwise() {
    let model = "[model]\ngravity = [9.81, 0, 0]\npayload = { mass = 2, com = [0, 0, 0.1] }\n";
    let robot = "../../../robots/planar2r.toml";
    let same = scene(robot, model).unwrap();
    assert_eq!(same.model.payload, Term::Constant(same.plant.payload.unwrap()));
    assert_eq!(same.plant.gravity, Vector3::new(9.81, 0.0, 0.0));
    let other = scene(robot, &format!("{model}[plant]\npayload = \"absent\"\ngravity = \"absent\"\n")).unwrap();
    assert_eq!((other.plant.payload, other.plant.gravity), (None, Vector3::zeros()));
    assert!(matches!(other.model.payload, Term::Constant(_)));
    let live: Live<f64, 2> = other.live(&other.robot.model().unwrap());
    assert_eq!(live.payload.mass, 0.0);
}

#[test]
fn a_scene_can_name_a_urdf_robot_and_its_tip() {
    let two = scene("two.urdf", "").unwrap();
    assert_eq!((two.robot.dof(), two.model.friction), (2, true));
    let named = scene("two.urdf", "tip = \"fore\"").unwrap();
    assert_eq!(named.robot.joints, two.robot.joints);
    let error = scene("two.urdf", "tip = \"for\"").unwrap_err();
    assert_eq!((error.file(), error.field()), ("tests/data/two.urdf", "tip"));
    assert!(error.expected().contains("did you mean `fore`?"), "{}", error.expected());
    let one = scene("two.urdf", "tip = \"upper\"").unwrap_err();
    assert_eq!((one.field(), one.problem()), ("motion.q", "found 2 entries"));
}

#[test]
fn encoder_counts_become_radians_and_metres() {
    let scara = SceneFile::load(&Path::new("../scenes").join("scara_pick.toml")).unwrap();
    let config = scara.controller_config(&scara.robot.model::<4>().unwrap());
    assert_eq!(config.encoder.map(|encoder| encoder.zero), [0; 4]);
    assert_eq!(config.encoder[0].per_count, std::f64::consts::TAU / 65536.0);
    assert_eq!(config.encoder[3].per_count, 1.0 / 200_000.0);
}

#[test]
fn the_plant_can_rub_and_ripple_otherwise_than_the_model_believes() {
    let table = "[plant]\nfriction = { coulomb = [3.0, 1.0], breakaway = 4.5, stribeck_speed = 0.02, breakaway_load = 0.1 }\n\
                 [actuators]\nripple = { share = 0.02, cycles = 6 }\n";
    // The planar arm's file has no friction. The controller has none either, and missing coefficients of the plant are
    // zero.
    let planar = scene("../../../robots/planar2r.toml", table).unwrap();
    assert!(!planar.model.friction && planar.plant.friction);
    let law = planar.plant.friction_law.unwrap();
    let breakaway = Some(Breakaway { torque: 4.5, speed: 0.02, load: 0.1 });
    let joint = |coulomb: f64| JointFriction { coulomb, breakaway, ..JointFriction::default() };
    assert_eq!(law, [joint(3.0), joint(1.0)]);
    let ripple = planar.actuators.ripple.unwrap();
    assert_eq!((ripple.share, ripple.cycles), (0.02, 6.0));
    // For a robot with friction, missing coefficients come from its file.
    let puma = scene("../../../robots/puma560.toml", "[plant]\nfriction = { viscous = 0.0 }\n").unwrap();
    let law = puma.plant.friction_law.unwrap();
    let of_file = puma.robot.joints.iter().map(|joint| JointFriction { viscous: 0.0, ..joint.friction.unwrap() });
    assert_eq!(law, of_file.collect::<Vec<_>>());
}

#[test]
fn limits_of_the_first_motion_and_of_live_inputs_are_taken_over_and_a_motor_s_heat_where_it_is_known() {
    let rules = |lines: &str| {
        let puma = scene("../../../robots/puma560.toml", lines).unwrap();
        puma.safety_rules(&puma.robot.model::<6>().unwrap())
    };
    let lines = "[model]\npayload = \"live\"\n[safety]\nfirst_motion = 0.2\nlive_age_ms = 50.5";
    let Rules { first_motion, live_max, .. } = rules(lines);
    assert_eq!((first_motion, live_max), (Some(0.2), 51));
    assert_eq!(rules("[safety]\nfirst_motion = 1").first_motion, None);
    assert_eq!(rules("[safety]\nfirst_motion = 0.99").first_motion, Some(0.99));

    let mut puma = scene("../../../robots/puma560.toml", "").unwrap();
    puma.robot.joints[1].heat = JointHeat { rated: Some(50.0), peak: None, time_constant: Some(60.0) };
    let heat = puma.safety_rules(&puma.robot.model::<6>().unwrap()).heat.unwrap();
    // One motor is updated in each of the six ticks of 1 ms.
    assert_eq!(heat[1], HeatRules::new(50.0, 60.0, 0.006));
    assert_eq!(heat[0], HeatRules::UNKNOWN);
}

/// An arm with drives is limited unless its scene sets otherwise; one that is only simulated is not.
#[test]
fn the_first_motion_of_an_arm_with_drives_is_limited_by_default() {
    let first = |robot: &str, lines: &str| {
        let scene = standing(robot, lines);
        let share = with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>().unwrap();
            let rules = scene.safety_rules(&model);
            // Lowering must not violate the limits of the first motion.
            let limits = model.links().map(|link| link.limits.velocity);
            let slow = (0..N).all(|i| rules.joints[i].lowering_speed <= rules.first_motion.unwrap_or(1.0) * limits[i]);
            assert!(slow, "{robot}: {rules:?}");
            rules.first_motion
        });
        assert_eq!(share, scene.safety.first_motion);
        share
    };
    for driven in ["yam", "rebot_b601_rs", "examples/mit6", "examples/mit6_fd", "examples/pwm2"] {
        assert_eq!(first(driven, ""), Some(FIRST_MOTION), "{driven}");
        assert_eq!(first(driven, "[safety]\nfirst_motion = 1"), None, "{driven}");
        assert_eq!(first(driven, "[safety]\nfirst_motion = 0.05"), Some(0.05), "{driven}");
    }
    for simulated in ["planar2r", "puma560", "ur5", "scara"] {
        assert_eq!(first(simulated, ""), None, "{simulated}");
        assert_eq!(first(simulated, "[safety]\nfirst_motion = 0.3"), Some(0.3), "{simulated}");
    }
}

#[test]
fn a_scene_without_safety_gets_rules_from_the_limits() {
    let puma = scene("../../../robots/puma560.toml", "").unwrap();
    let Rules {
        safe_action,
        heartbeat_max,
        hold_max,
        supply,
        temperature,
        period,
        rate,
        latency,
        arming_max,
        brake_delay,
        live,
        live_max,
        rest,
        first_motion,
        heat,
        payload,
        joints,
    } = puma.safety_rules(&puma.robot.model::<6>().unwrap());
    assert_eq!((arming_max, live, live_max, rest, first_motion, heat), (1000, 0, 0, None, None, None));
    assert_eq!(brake_delay, 100);
    assert_eq!((safe_action, heartbeat_max, hold_max), (SafeAction::Brake, 100, 500));
    assert_eq!((supply.0, supply.1), (f64::NEG_INFINITY, f64::INFINITY));
    assert_eq!(supply, temperature);
    assert_eq!((period, rate, latency), (0.001, 1000.0, 0.002));
    let links = puma.robot.joints.iter().map(|joint| joint.spec.body.mass).sum::<f64>();
    assert!((20.0..60.0).contains(&links));
    assert_eq!((payload.mass, payload.radius), (links, 1.0));
    let waist = JointRules {
        rest_speed: 0.05,
        jump_step: 2.0 * 1.92 * 0.001,
        resolution: 2.0 * std::f64::consts::TAU / 62611.1,
        deceleration: 1.92 / 0.25,
        reach: 0.2,
        reach_speed: 0.1 * 1.92,
        rotor_max: 4.0 * (0.0002 * 62.6111 * 62.6111),
        damping: 97.6 / 1.92,
        lowering_speed: joints[0].lowering_speed,
    };
    assert_eq!(joints[0], waist);
}

#[test]
fn what_a_scene_says_of_safety_is_what_the_rules_hold() {
    let lines = "[control]\nrate = 500\n[safety]\nsafe_action = \"damped-stop\"\nheartbeat_ms = 41\nhold_ms = 0\nlatency_ms = 3\n\
                 payload_mass = 2.5\npayload_radius = 0.3\n\
                 supply = [20, 30]\ntemperature = [-10.5, 80]\njump_factor = 3\ndeceleration = [7, 8]\nresolution = 0\n\
                 rest_speed = 0.02\nreach = [0.1, 0.3]\nreach_speed = 0.4\ndamping = 2.5\n";
    let planar = scene("../../../robots/planar2r.toml", lines).unwrap();
    let model = planar.robot.model::<2>().unwrap();
    let rules = planar.safety_rules(&model);
    // 41 ms are 20.5 ticks; the count is rounded up so that the full 41 ms pass.
    assert_eq!((rules.safe_action, rules.heartbeat_max, rules.hold_max), (SafeAction::DampedStop, 21, 0));
    assert_eq!((rules.supply, rules.temperature, rules.latency), ((20.0, 30.0), (-10.5, 80.0), 0.003));
    assert_eq!((rules.payload.mass, rules.payload.radius), (2.5, 0.3));
    assert_eq!(rules.brake_delay, 0);
    for (i, (deceleration, reach)) in [(7.0, 0.1), (8.0, 0.3)].into_iter().enumerate() {
        let jump_step = 3.0 * model.links()[i].limits.velocity * 0.002;
        let joint = JointRules {
            rest_speed: 0.02,
            jump_step,
            resolution: 0.0,
            deceleration,
            reach,
            reach_speed: 0.4,
            rotor_max: 4.0 * model.links()[i].rotor,
            damping: 2.5,
            // 0.05 m/s at the tip divided by the sum of the reaches, 1.6 and 1 m.
            lowering_speed: 0.05 / 2.6,
        };
        assert_eq!(rules.joints[i], joint);
    }
    // 41 ms are 20.5 ticks, rounded up: torque goes on until the brakes have certainly engaged.
    let braked =
        scene("../../../robots/planar2r.toml", "[control]\nrate = 500\n[safety]\nbrake_delay_ms = 41").unwrap();
    assert_eq!(braked.safety_rules(&braked.robot.model::<2>().unwrap()).brake_delay, 21);
    // A number of the rules affects the tick, so the hash changes.
    let other = scene("../../../robots/planar2r.toml", &lines.replace("hold_ms = 0", "hold_ms = 2")).unwrap();
    assert_ne!(planar.hash(&model), other.hash(&model));
}
