//! The plant compared with reference data from Pinocchio and with the laws of mechanics.
#![allow(clippy::float_cmp, reason = "a trace claims equality")]

use crate::reference::{Golden, Reference, matrix, relative, wrench};
use dynamics_core::geometry::{about_x, about_z};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Body, Dh, Frame, JointKind, SinCos, Trig, Wrench};
use nalgebra::{Matrix3, SVector, Vector3};
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{Precision, Program, RuleSet};
use robot_compiler::scene::{Push, Ripple};
use sim::plant::actuator::{ActuatorSettings, rippled};
use sim::plant::dynamics::Mechanism;
use sim::plant::friction::Breakaway;
use sim::plant::{Arm, Clock, JointFriction, Plant, State};

fn array<const N: usize>(values: &[f64]) -> [f64; N] {
    values.try_into().unwrap()
}

/// Worst relative difference over all states: of the terms of the equations of motion, and of forward dynamics.
fn worst<const N: usize>(arm: &Arm<N>, states: &[Reference]) -> (f64, f64) {
    let (mut terms_off, mut forward_off) = (0.0_f64, 0.0_f64);
    for state in states {
        let (q, qd) = (array(&state.q), array::<N>(&state.qd));
        let terms = arm.terms(&q, &qd);
        let rows: Vec<f64> = state.mass_matrix.concat();
        // The matrix is symmetric, so nalgebra's column order equals the reference's row order.
        terms_off = terms_off.max(relative(terms.mass_matrix.as_slice(), &rows));
        terms_off = terms_off.max(relative(&terms.gravity, &state.gravity));
        terms_off = terms_off.max(relative(&terms.coriolis, &state.coriolis_qd));
        let inertial = terms.mass_matrix * SVector::<f64, N>::from_column_slice(&state.qdd);
        let tau: [f64; N] = core::array::from_fn(|i| inertial[i] + terms.coriolis[i] + terms.gravity[i]);
        terms_off = terms_off.max(relative(&tau, &state.tau));

        let mut touched = arm.clone();
        touched.tip_wrench = Some(wrench(&state.wrench_tip));
        let tip = touched.terms(&q, &qd).tip;
        let tau_wrench: [f64; N] = core::array::from_fn(|i| tau[i] - tip[i]);
        terms_off = terms_off.max(relative(&tau_wrench, &state.tau_wrench));

        let (rotation, origin) = arm.tip_pose(&q);
        terms_off = terms_off.max((rotation - matrix(&state.tip_rotation)).amax());
        terms_off = terms_off.max(relative(origin.as_slice(), &state.tip_p));
        terms_off = terms_off.max(relative(&[arm.kinetic(&q, &qd)], &[state.kinetic]));
        // Nearly balanced masses have a small potential, so the difference is relative to the energy of one metre of height.
        terms_off = terms_off.max((arm.potential(&q) - state.potential).abs() / 100.0);

        let drive = array(&state.tau_in);
        forward_off = forward_off.max(relative(&arm.acceleration(&q, &qd, &drive).unwrap(), &state.qdd_fd));
        forward_off = forward_off.max(relative(&touched.acceleration(&q, &qd, &drive).unwrap(), &state.qdd_fd_wrench));
    }
    (terms_off, forward_off)
}

#[test]
fn equations_of_motion_agree_with_pinocchio() {
    let (puma, planar) = (Golden::load("puma560"), Golden::load("planar2r"));
    let (scara, random) = (Golden::load("scara"), Golden::load("random6_generic"));
    let found = [
        ("puma560, placements", worst::<6>(&puma.placed(), &puma.states)),
        ("puma560, DH", worst::<6>(&puma.classical(false), &puma.states)),
        ("planar2r, placements", worst::<2>(&planar.placed(), &planar.states)),
        ("planar2r, DH", worst::<2>(&planar.classical(false), &planar.states)),
        ("scara, placements", worst::<4>(&scara.placed(), &scara.states)),
        ("scara, DH", worst::<4>(&scara.classical(false), &scara.states)),
        ("random 6R/P", worst::<6>(&random.placed(), &random.states)),
    ];
    for (robot, (terms, forward)) in found {
        // Measured: terms at most 2.8e-15. Accelerations: 2.6e-14 on the Puma, whose inertia matrix without rotors has a condition number of about
        // 1e5, and below 1e-14 on the others.
        assert!(terms < 1e-14, "{robot}: terms off by {terms:e}");
        assert!(forward < 1e-13, "{robot}: forward dynamics off by {forward:e}");
    }
}

/// Traces the plant's source as a program of sines, cosines, positions, velocities and torques.
fn traced<const N: usize>(mechanism: &Mechanism<N>) -> Program {
    let (outputs, tape) = trace(Arena::new(RuleSet::ALL, Precision::Double), || {
        let joints = |group: usize| -> [Expr; N] { core::array::from_fn(|i| input((group * N + i) as u32)) };
        let (sin, cos) = (joints(0), joints(1));
        let turn = core::array::from_fn(|i| SinCos { sin: sin[i], cos: cos[i] });
        let found = mechanism.cast().solution(&turn, &joints(2), &joints(3), &joints(4));
        found.qdd.into_iter().chain(found.pivot).collect::<Vec<_>>()
    });
    Program::new(tape, &outputs)
}

fn traced_equals_source<const N: usize>(arm: &Arm<N>, states: &[Reference]) {
    let mechanism = arm.mechanism();
    let program = traced(&mechanism);
    for state in states {
        let [q, qd, drive] = [&state.q, &state.qd, &state.tau_in].map(|list| array::<N>(list));
        let turn = Polynomial.sin_cos_all(&q);
        let inputs: Vec<f64> = turn.iter().map(|t| t.sin).chain(turn.iter().map(|t| t.cos)).collect();
        let inputs = [&inputs, &q[..], &qd, &drive].concat();
        let wanted = mechanism.solution(&turn, &q, &qd, &drive);
        let found = program.evaluate(&inputs);
        assert_eq!(found, [wanted.qdd, wanted.pivot].concat());
        assert_eq!(mechanism.acceleration(&q, &qd, &drive), Some(wanted.qdd));
    }
}

#[test]
fn the_source_can_be_traced_and_keeps_its_bits() {
    let (puma, random) = (Golden::load("puma560"), Golden::load("random6_generic"));
    traced_equals_source::<6>(&puma.classical(true), &puma.states);
    let mut touched: Arm<6> = random.placed();
    touched.tip_wrench = Some(wrench(&random.states[0].wrench_tip));
    touched.payload = Some(Body { mass: 2.0, com: Vector3::new(0.02, -0.01, 0.05), inertia: Matrix3::identity() });
    traced_equals_source(&touched, &random.states);
}

#[test]
fn an_arm_that_moves_no_mass_has_no_acceleration() {
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    assert!(arm.acceleration(&[0.3, 0.5], &[0.0; 2], &[1.0; 2]).is_some());
    arm.joints[1].body = Body::massless();
    assert_eq!(arm.acceleration(&[0.3, 0.5], &[0.0; 2], &[1.0; 2]), None);
    // A position beyond the range of the sine has no acceleration.
    let arm: Arm<2> = Golden::load("planar2r").classical(false);
    assert_eq!(arm.acceleration(&[2e6, 0.5], &[0.0; 2], &[1.0; 2]), None);
}

#[test]
fn rotors_add_their_reflected_inertia() {
    let golden = Golden::load("puma560");
    let arm: Arm<6> = golden.classical(true);
    for state in &golden.states {
        let with = state.rotor.as_ref().unwrap();
        let (q, qd) = (array(&state.q), array(&state.qd));
        let terms = arm.terms(&q, &qd);
        assert!(relative(terms.mass_matrix.as_slice(), &with.mass_matrix.concat()) < 1e-14);
        let inertial = terms.mass_matrix * SVector::<f64, 6>::from_column_slice(&state.qdd);
        let tau: [f64; 6] = core::array::from_fn(|i| inertial[i] + terms.coriolis[i] + terms.gravity[i]);
        assert!(relative(&tau, &with.tau) < 1e-14);
        // Rotors reduce the condition number to about 30, and the error with it.
        assert!(relative(&arm.acceleration(&q, &qd, &array(&state.tau_in)).unwrap(), &with.qdd_fd) < 1e-14);
    }
}

#[test]
fn modified_dh_is_the_same_arm_as_its_placements() {
    let golden = Golden::load("puma560");
    let rows = [(0.1, 0.4, 0.3, 0.2), (0.3, -1.2, -0.1, 0.7), (0.0, 1.5, 0.2, -0.4)].map(|(a, alpha, d, theta)| Dh {
        a,
        alpha,
        d,
        theta,
    });
    let puma: Arm<6> = golden.classical(true);
    let tool = puma.tool;
    let base = Arm { joints: [puma.joints[1]; 3], tool, payload: None, gravity: puma.gravity, tip_wrench: None };
    let (mut modified, mut placed) = (base.clone(), base.clone());
    // The link frames of the robot with placements end before Rz(theta) Tz(d): the next placement and the body begin with it.
    let (mut turn, mut shift) = (Matrix3::identity(), Vector3::zeros());
    for (i, row) in rows.iter().enumerate() {
        modified.joints[i].frame = Frame::ModifiedDh(*row);
        let rotation = turn * about_x(row.alpha);
        let translation = shift + turn * Vector3::new(row.a, 0.0, 0.0);
        placed.joints[i].frame = Frame::Placement { rotation, translation, axis: Vector3::z() };
        (turn, shift) = (about_z(row.theta), Vector3::new(0.0, 0.0, row.d));
        let body = base.joints[i].body;
        placed.joints[i].body =
            Body { com: turn * body.com + shift, inertia: turn * body.inertia * turn.transpose(), ..body };
    }
    (placed.tool.rotation, placed.tool.translation) = (turn, shift);
    let (q, qd) = ([0.4, -1.1, 0.9], [1.0, -2.0, 0.5]);
    let (a, b) = (modified.terms(&q, &qd), placed.terms(&q, &qd));
    assert!(relative(a.mass_matrix.as_slice(), b.mass_matrix.as_slice()) < 1e-14);
    assert!(relative(&a.gravity, &b.gravity) < 1e-14);
    assert!(relative(&a.coriolis, &b.coriolis) < 1e-14);
    assert!((modified.tip_pose(&q).1 - placed.tip_pose(&q).1).amax() < 1e-14);
}

#[test]
fn payload_is_one_more_body_at_the_tip() {
    let mut held: Arm<6> = Golden::load("random6_generic").placed();
    let body = Body { mass: 2.0, com: Vector3::new(0.02, -0.01, 0.05), inertia: Matrix3::identity() * 0.003 };
    let mut built_in = held.clone();
    held.payload = Some(body);
    built_in.tool.body = body;
    let (q, qd) = ([0.3, 0.4, -0.2, 1.0, 0.5, -0.7], [1.0, -0.5, 0.2, 2.0, 0.1, -1.0]);
    assert_eq!(held.acceleration(&q, &qd, &[1.0; 6]), built_in.acceleration(&q, &qd, &[1.0; 6]));
    let empty = Golden::load("random6_generic").placed::<6>();
    assert_ne!(held.acceleration(&q, &qd, &[1.0; 6]), empty.acceleration(&q, &qd, &[1.0; 6]));
}

fn plant<const N: usize>(
    arm: &Arm<N>,
    friction: Option<[JointFriction; N]>,
    steps_per_tick: u32,
    start: [f64; N],
) -> Plant<N> {
    let clock = Clock { period: 1e-2, steps_per_tick };
    Plant::new(arm, friction, ActuatorSettings::default(), clock, start)
}

fn energy<const N: usize>(arm: &Arm<N>, state: &State<N>) -> f64 {
    arm.kinetic(&state.q, &state.qd) + arm.potential(&state.q)
}

/// Greatest change of energy, J, while the free arm falls for one second.
fn drift<const N: usize>(arm: &Arm<N>, steps_per_tick: u32, start: [f64; N]) -> f64 {
    let mut plant = plant(arm, None, steps_per_tick, start);
    let before = energy(arm, plant.state());
    let mut worst = 0.0_f64;
    for _ in 0..100 {
        plant.drive(&[0.0; N]).unwrap();
        worst = worst.max((energy(arm, plant.state()) - before).abs());
    }
    worst
}

#[test]
fn a_free_arm_keeps_its_energy_to_fourth_order_in_the_step() {
    let planar = Golden::load("planar2r").classical(false);
    let puma: Arm<6> = Golden::load("puma560").classical(true);
    // Measured with steps of 2.5 and 1.25 ms: 2.7e-7 and 1.8e-8 J (order 3.93); 4.8e-9 and 3.0e-10 J (order 3.99).
    let found = [
        (drift(&planar, 4, [0.3, 0.5]), drift(&planar, 8, [0.3, 0.5])),
        (drift(&puma, 4, [0.1, 0.4, -0.3, 0.2, 0.5, 0.1]), drift(&puma, 8, [0.1, 0.4, -0.3, 0.2, 0.5, 0.1])),
    ];
    for (coarse, fine) in found {
        let order = (coarse / fine).log2();
        assert!((3.8..4.2).contains(&order), "order {order}: from {coarse:e} J to {fine:e} J");
        assert!((1e-9..1e-6).contains(&coarse), "{coarse:e} J");
    }
}

#[test]
fn work_done_by_torques_less_friction_is_the_energy_gained() {
    let arm: Arm<6> = Golden::load("puma560").classical(true);
    let start = [0.1, 0.4, -0.3, 0.2, 0.5, 0.1];
    let torque = [20.0, 45.0, 12.0, 2.0, -3.0, 1.5];
    let friction = [JointFriction::new(1.5, 3.0); 6];
    let mut plant = plant(&arm, Some(friction), 100, start);
    let before = energy(&arm, plant.state());
    let power = |s: &State<6>| (0..6).map(|i| (torque[i] - friction[i].torque(s.qd[i])) * s.qd[i]).sum::<f64>();
    // Simpson's rule over pairs of ticks.
    let (mut work, mut spent) = (0.0, 0.0);
    let mut last = power(plant.state());
    for _ in 0..50 {
        plant.drive(&torque).unwrap();
        let middle = power(plant.state());
        plant.drive(&torque).unwrap();
        let end = power(plant.state());
        work += (last + 4.0 * middle + end) * 1e-2 / 3.0;
        spent += middle.abs() * 2e-2;
        last = end;
    }
    let gained = energy(&arm, plant.state()) - before;
    assert!(spent > 10.0, "the arm should have moved: {spent} J");
    // Measured: 5.4e-5 J of 103 J, the error of Simpson's rule when friction starts to act.
    assert!((gained - work).abs() < 2e-6 * spent, "gained {gained} J for {work} J of work");
}

#[test]
fn coulomb_friction_holds_what_it_can_and_opposes_motion() {
    let arm: Arm<2> = Golden::load("planar2r").classical(false);
    // The arm almost hangs: gravity needs 1.6 N m of the 5 N m of friction in the first joint.
    let start = [-1.52, 0.0];
    let friction = [JointFriction::new(0.0, 5.0), JointFriction::new(0.0, 0.5)];
    let mut held = plant(&arm, Some(friction), 40, start);
    let mut free = plant(&arm, None, 40, start);
    for _ in 0..1000 {
        held.drive(&[0.0; 2]).unwrap();
    }
    (0..20).for_each(|_| free.drive(&[0.0; 2]).unwrap());
    // Ten seconds without any motion, to the last bit.
    assert_eq!((held.state().q[0], held.state().qd[0]), (start[0], 0.0));
    assert!((free.state().q[0] - start[0]).abs() > 1e-3);
    assert_eq!((friction[0].torque(1e-9), friction[0].torque(-1e-9), friction[0].torque(0.0)), (5.0, -5.0, 0.0));
}

/// Friction of the planar arm's first joint: 4 N m when sliding, 12 N m at breakaway.
fn sticky(load: f64) -> [JointFriction; 2] {
    let breakaway = Some(Breakaway { torque: 12.0, speed: 0.05, load });
    let first = JointFriction { breakaway, ..JointFriction::new(0.2, 4.0) };
    [first, JointFriction::new(0.0, 0.5)]
}

#[test]
fn friction_falls_from_breakaway_to_coulomb_as_stribeck_has_it() {
    let [friction, _] = sticky(0.0);
    let curve = |qd: f64| friction.torque(qd) - 0.2 * qd;
    // The full breakaway level applies at almost zero velocity.
    assert!((curve(1e-9) - 12.0).abs() < 1e-12 && friction.level(0.0, 0.0) == 12.0);
    // At the Stribeck velocity the excess has fallen to 1/e; far above it only Coulomb friction remains.
    assert!((curve(0.05) - (4.0 + 8.0 / 1.0_f64.exp())).abs() < 1e-6, "{}", curve(0.05));
    assert!((curve(0.5) - 4.0).abs() < 1e-12 && (curve(-0.5) + 4.0).abs() < 1e-12);
    // A load raises breakaway friction but not sliding friction.
    let [loaded, _] = sticky(0.1);
    let rise = |drive: f64| loaded.torque_under(drive, 0.05) - loaded.torque_under(0.0, 0.05);
    assert!((rise(20.0) - 2.0 / 1.0_f64.exp()).abs() < 1e-6 && (rise(-20.0) - rise(20.0)).abs() < 1e-12);
    assert!((loaded.torque_under(20.0, 0.5) - loaded.torque_under(0.0, 0.5)).abs() < 1e-12);
}

#[test]
fn a_joint_breaks_away_above_its_level_and_then_slides_on_less() {
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    arm.gravity = Vector3::zeros();
    let moved = |torque: f64, load: f64| {
        let mut plant = plant(&arm, Some(sticky(load)), 40, [0.0; 2]);
        (0..30).for_each(|_| plant.drive(&[torque, 0.0]).unwrap());
        plant.state().q[0]
    };
    // Up to and including the level, the joint is held exactly; above it, it breaks loose.
    assert_eq!((moved(10.0, 0.0), moved(12.0, 0.0)), (0.0, 0.0));
    // At first, only the excess over the level accelerates it.
    let [barely, back, torn] = [12.01, -12.01, 13.0].map(|torque| moved(torque, 0.0));
    assert!(barely > 1e-5 && back < -1e-5 && torn > 0.1, "{barely} {back} {torn}");
    // If half of the load is added to breakaway friction, the joint also holds 13 N m.
    assert_eq!(moved(13.0, 0.5), 0.0);
}

#[test]
fn torque_ripple_swings_about_the_command_as_the_joint_turns() {
    let ripple = Ripple { share: 0.1, cycles: 6.0 };
    let kinds = [JointKind::Revolute, JointKind::Prismatic];
    // A quarter of a ripple period: pi / 12 of an angle, 1/24 m.
    let quarter = [core::f64::consts::PI / 12.0, 1.0 / 24.0];
    let acting = rippled(ripple, &kinds, &[10.0, -20.0], &quarter);
    assert!((acting[0] - 11.0).abs() < 1e-12 && (acting[1] + 22.0).abs() < 1e-12, "{acting:?}");
    assert_eq!(rippled(ripple, &kinds, &[10.0, -20.0], &[0.0; 2]), [10.0, -20.0]);
    // In the loop, the ripple does the work stated in the ledger. Over whole turns it does no net work, because the integral of the sine is zero.
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    arm.gravity = Vector3::zeros();
    let clock = Clock { period: 0.01, steps_per_tick: 40 };
    let settings = ActuatorSettings { ripple: Some(ripple), ..ActuatorSettings::default() };
    let mut plant = Plant::new(&arm, None, settings, clock, [0.0; 2]);
    plant.start_ledger();
    (0..60).for_each(|_| plant.drive(&[5.0, 0.5]).unwrap());
    let gained = energy(&arm, plant.state()) - energy(&arm, &State { q: [0.0; 2], qd: [0.0; 2] });
    let given: f64 = plant.ledger().unwrap().actuators.total().iter().sum();
    assert!(gained > 0.5 && (given - gained).abs() < 1e-5 * gained, "{given} J given, {gained} J gained");
    let commanded = 5.0 * plant.state().q[0] + 0.5 * plant.state().q[1];
    assert!((given - commanded).abs() > 1e-4 * gained, "{given} J as without ripple");
}

#[test]
fn brakes_that_were_released_engage_where_the_arm_is_then_and_nothing_is_left_of_old_commands() {
    let mut arm: Arm<2> = Golden::load("planar2r").classical(false);
    arm.gravity = Vector3::zeros();
    let clock = Clock { period: 0.01, steps_per_tick: 10 };
    let settings = ActuatorSettings { delay: 2, ..ActuatorSettings::default() };
    let mut plant = Plant::new(&arm, None, settings, clock, [0.3, 0.5]);
    (0..3).for_each(|_| plant.brake());
    assert_eq!(*plant.state(), State { q: [0.3, 0.5], qd: [0.0; 2] });
    (0..20).for_each(|_| plant.drive(&[5.0, 0.0]).unwrap());
    let moving = *plant.state();
    assert!(moving.qd[0] > 0.1 && moving.q[0] > 0.31, "{moving:?}");
    plant.brake();
    let braked = *plant.state();
    // After a tenth of the braking time: nine tenths of the speed, and the distance at the mean speed.
    assert!((braked.qd[0] - 0.9 * moving.qd[0]).abs() < 1e-12, "{moving:?}, {braked:?}");
    assert!((braked.q[0] - moving.q[0] - 0.0095 * moving.qd[0]).abs() < 1e-12, "{moving:?}, {braked:?}");
    (0..10).for_each(|_| plant.brake());
    let rests = *plant.state();
    (0..2).for_each(|_| plant.drive(&[0.0; 2]).unwrap());
    assert_eq!(*plant.state(), rests);
}

#[test]
fn the_clock_of_a_push_runs_while_the_brakes_hold() {
    let arm: Arm<2> = Golden::load("planar2r").classical(false);
    let push = Push {
        at: 0.05,
        duration: 0.02,
        wrench: Wrench { force: Vector3::new(0.0, 30.0, 0.0), moment: Vector3::zeros() },
    };
    let clock = Clock { period: 0.01, steps_per_tick: 10 };
    // Held for this many ticks, then driven: the push begins at 0.05 s of the same clock.
    for held in [0, 3, 5, 6, 7] {
        let start = |push| Plant::new(&arm, None, ActuatorSettings::default(), clock, [0.3, 0.5]).with_push(push);
        let mut plants = [start(None), start(Some(push))];
        let mut first = None;
        for tick in 0..10 {
            for plant in &mut plants {
                if tick < held { plant.brake() } else { plant.drive(&[0.0; 2]).unwrap() }
            }
            if plants[0].state() != plants[1].state() {
                first = first.or(Some(tick));
            }
        }
        let expected = if held < 7 { Some(held.max(5)) } else { None };
        assert_eq!(first, expected, "held for {held} ticks");
    }
}

#[test]
fn brakes_bring_the_arm_to_rest_and_hold_it() {
    let arm: Arm<2> = Golden::load("planar2r").classical(false);
    let mut plant = plant(&arm, None, 10, [0.3, 0.5]);
    for _ in 0..20 {
        plant.drive(&[0.0; 2]).unwrap();
    }
    let at = *plant.state();
    for _ in 0..10 {
        plant.brake();
    }
    let stopped = *plant.state();
    assert!(stopped.qd.iter().all(|v| v.abs() < 1e-12));
    // Constant deceleration over a tenth of a second: the distance is half the speed times the time.
    assert!((stopped.q[0] - (at.q[0] + at.qd[0] * 0.05)).abs() < 1e-12);
    plant.brake();
    assert_eq!(plant.state().q.map(f64::to_bits), stopped.q.map(f64::to_bits));
    // A brake that is released and engaged again starts from the arm's state at that instant.
    for _ in 0..20 {
        plant.drive(&[1.0, 0.0]).unwrap();
    }
    let at = *plant.state();
    for _ in 0..10 {
        plant.brake();
    }
    assert!((plant.state().q[0] - (at.q[0] + at.qd[0] * 0.05)).abs() < 1e-12);
    assert!(plant.state().qd.iter().all(|v| v.abs() < 1e-12));
}
