//! Extreme masses and inertias: inverse dynamics at both kernel levels, and forward dynamics.
//!
//! Errors of inverse dynamics are differences from the recursion in double-double arithmetic on the same inputs. They are evaluated joint by joint,
//! relative to the largest torque of that joint in any of the states, so that a heavy base cannot hide a light tip. Errors of forward dynamics are
//! evaluated on the torques: double-double inverse dynamics gives the torques for the computed accelerations, and the given torques are subtracted.
//! The error of the accelerations is shown as well, because for a nearly singular `D` many accelerations give almost the same torques.

use super::{Cell, Outcome, ROUNDING_MOST, Random, scalar_name};
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::trig::Libm;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Real, Rotor, Scalar, Scene,
    SinCos, Singular, Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::kernel::inputs::input_values;
use robot_compiler::kernel::{Function, Level, Precision, compile};
use robot_compiler::precision::DoubleDouble;
use std::f64::consts::FRAC_PI_2;

const GROUP: &str = "masses";
const STATES: usize = 40;

/// A torque smaller than this share of the arm's largest one counts as zero.
const NOTHING: f64 = 1e-25;

/// An arm with extreme masses.
struct Arm {
    name: &'static str,
    what: &'static str,
    joints: [JointSpec; 6],
    /// Centre of the postures, and the distance around it.
    posture: ([f64; 6], f64),
    /// Joint that forward dynamics must name as singular, counted from 0.
    singular: Option<usize>,
}

/// Six joints in space with these masses and proportional moments of inertia.
fn spatial(masses: [f64; 6]) -> [JointSpec; 6] {
    const A: [f64; 6] = [0.0, 0.45, 0.1, 0.0, 0.05, 0.0];
    const TWIST: [f64; 6] = [FRAC_PI_2, 0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, 0.0];
    const D: [f64; 6] = [0.4, 0.1, 0.05, 0.4, 0.0, 0.1];
    core::array::from_fn(|i| {
        let m = masses[i];
        JointSpec {
            kind: JointKind::Revolute,
            frame: Frame::ClassicalDh(Dh { a: A[i], alpha: TWIST[i], d: D[i], theta: 0.0 }),
            body: Body {
                mass: m,
                com: Vector3::new(-0.1, 0.05, 0.02),
                inertia: Matrix3::from_diagonal(&Vector3::new(0.01 * m, 0.012 * m, 0.015 * m)),
            },
            rotor: Rotor::default(),
            limits: Limits::none(),
        }
    })
}

/// Six joints with parallel horizontal axes and rods of 0.3 m and 1 kg, so that gravity loads every joint.
fn parallel() -> [JointSpec; 6] {
    core::array::from_fn(|i| {
        let row = if i == 0 { Dh { alpha: FRAC_PI_2, ..Dh::default() } } else { Dh { a: 0.3, ..Dh::default() } };
        JointSpec {
            kind: JointKind::Revolute,
            frame: Frame::ModifiedDh(row),
            body: Body {
                mass: 1.0,
                com: Vector3::new(0.15, 0.0, 0.0),
                inertia: Matrix3::from_diagonal(&Vector3::new(0.0, 0.0075, 0.0075)),
            },
            rotor: Rotor::default(),
            limits: Limits::none(),
        }
    })
}

fn with_rotors(joints: [JointSpec; 6]) -> [JointSpec; 6] {
    joints.map(|joint| JointSpec { rotor: Rotor { inertia: 1e-4, gear: 100.0 }, ..joint })
}

fn massless(mut joints: [JointSpec; 6], links: &[usize]) -> [JointSpec; 6] {
    for &i in links {
        joints[i].body = Body::massless();
    }
    joints
}

fn point_masses(mut joints: [JointSpec; 6], tip: Vector3<f64>) -> [JointSpec; 6] {
    for joint in &mut joints {
        joint.body = Body { mass: 1.0, com: Vector3::new(-0.05, 0.1, 0.08), inertia: Matrix3::zeros() };
    }
    joints[5].body.com = tip;
    joints
}

/// Geometric sequence that starts at `first`, with ratio `ratio`.
fn graded(first: f64, ratio: f64) -> [f64; 6] {
    let mut mass = first;
    core::array::from_fn(|_| {
        let now = mass;
        mass *= ratio;
        now
    })
}

fn arms() -> Vec<Arm> {
    /// Ratio of six masses that span the whole range, `1e12^(1/5)`.
    const STEP: f64 = 251.188_643_150_958;
    let anywhere = ([0.0; 6], 3.0);
    let arm = |name, what, joints| Arm { name, what, joints, posture: anywhere, singular: None };
    let ones = spatial([1.0; 6]);
    let mut far = ones;
    for joint in &mut far {
        joint.body.com = Vector3::new(5.0, -3.0, 8.0);
    }
    let mut farther = ones;
    for joint in &mut farther {
        joint.body.com = Vector3::new(500.0, -300.0, 800.0);
    }
    let mut light_tip = ones;
    light_tip[5].body = Body { mass: 1e-9, com: Vector3::new(0.0, 0.01, 0.02), inertia: Matrix3::zeros() };
    let mut inertias = ones;
    for (joint, j) in inertias.iter_mut().zip([1e-6, 1e6, 1e-3, 1e3, 1e-6, 1e6]) {
        joint.body.inertia = Matrix3::from_diagonal_element(j);
    }
    vec![
        arm("heavy base to light tip", "masses 1e6 to 1e-6 kg, ratio 1e12", spatial(graded(1e6, 1.0 / STEP))),
        arm("light base to heavy tip", "masses 1e-6 to 1e6 kg, ratio 1e12", spatial(graded(1e-6, STEP))),
        arm(
            "heavy and light in turn",
            "masses 1e6 and 1e-6 kg alternating",
            spatial([1e6, 1e-6, 1e6, 1e-6, 1e6, 1e-6]),
        ),
        arm("inertias in turn", "1 kg links, moments of inertia 1e-6 to 1e6 kg m^2", inertias),
        arm("massless links with rotors", "links 2, 4 and 6 without mass", with_rotors(massless(ones, &[1, 3, 5]))),
        arm("massless link in the middle", "link 3 without mass or rotor", massless(ones, &[2])),
        Arm { singular: Some(5), ..arm("massless last link", "link 6 without mass or rotor", massless(ones, &[5])) },
        Arm {
            singular: Some(5),
            ..arm("no mass at all", "every link without mass or rotor", massless(ones, &[0, 1, 2, 3, 4, 5]))
        },
        arm("point masses", "1 kg in a point on every link", point_masses(ones, Vector3::new(-0.05, 0.1, 0.08))),
        Arm {
            singular: Some(5),
            ..arm(
                "point mass on the last axis",
                "1 kg on axis 6 itself",
                point_masses(ones, Vector3::new(0.0, 0.0, 0.08)),
            )
        },
        Arm {
            posture: ([0.0; 6], 1e-3),
            ..arm("straight planar 6R", "six rods in one line, to a milliradian", parallel())
        },
        Arm {
            posture: ([0.3, 0.7, -0.4, 0.5, 0.0, 0.2], 1e-4),
            ..arm("wrist at its singularity", "axes 4 and 6 in line, to 0.1 mrad", ones)
        },
        arm("tip mass 1e-9", "the last link a point of 1e-9 kg, 1 cm off its axis", light_tip),
        arm("centre of mass 10 m away", "every link's, from its frame", far),
        arm("centre of mass 1 km away", "every link's, from its frame", farther),
    ]
}

/// All cells of this group.
#[must_use]
pub(crate) fn cells() -> Vec<Cell> {
    let mut cells = Vec::new();
    for arm in arms() {
        add::<f32>(&mut cells, &arm, 0);
        add::<f64>(&mut cells, &arm, 1);
    }
    cells
}

fn add<S: Real>(cells: &mut Vec<Cell>, arm: &Arm, precision: usize) {
    let scalar = scalar_name::<S>();
    let Ok(model) = Model::new(&arm.joints, &Tool::default()) else {
        let outcome = Outcome::words("refused", "an arm");
        cells.push(Cell::new(GROUP, arm.name, arm.what, outcome, "the model is refused"));
        return;
    };
    let scene = Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model);
    let errors = inverse_errors::<S>(&model, &scene, &arm.posture);
    for (level, error) in Level::ALL.iter().zip(errors) {
        let name = format!("{}, {scalar}, {}", arm.name, level.name());
        let done = format!("{}: inverse dynamics in {STATES} states, error over each joint's largest torque", arm.what);
        cells.push(Cell::new(
            GROUP,
            name,
            done,
            Outcome::at_most(error, ROUNDING_MOST[precision], ""),
            "the torque of some joint drowns in rounding",
        ));
    }
    let forward = forward_errors::<S>(&model, &scene, &arm.posture);
    let name = |what: &str| format!("{}, {scalar}, {what}", arm.name);
    let done = |what: &str| format!("{}: forward dynamics in {STATES} states, {what}", arm.what);
    let (Ok([undone, accelerations]), None) = (forward, arm.singular) else {
        let words = |singular: Option<usize>| match singular {
            Some(joint) => format!("singular at joint {}", joint + 1),
            None => "accelerations".to_owned(),
        };
        let outcome = Outcome::words(words(forward.err().map(|singular| singular.joint)), words(arm.singular));
        cells.push(Cell::new(
            GROUP,
            name("forward"),
            done("which is singular or not"),
            outcome,
            "the wrong joint is named, or none",
        ));
        return;
    };
    cells.push(Cell::new(
        GROUP,
        name("forward, undone"),
        done("undone by inverse dynamics, error over each joint's largest torque"),
        Outcome::at_most(undone, ROUNDING_MOST[precision], ""),
        "the accelerations do not give the torques back",
    ));
    cells.push(Cell::new(
        GROUP,
        name("forward, accelerations"),
        done("error over the largest acceleration"),
        Outcome::record(accelerations, ""),
        "D is so near to singular that the last place of a torque moves the accelerations by this much: the torques come back (the \
         cell before), the accelerations do not",
    ));
}

/// A state that single precision represents exactly, so that only the error of the arithmetic is measured.
struct State {
    q: [f64; 6],
    qd: [f64; 6],
    qdd: [f64; 6],
}

fn states(posture: &([f64; 6], f64)) -> Vec<State> {
    let mut random = Random(7);
    let single = |all: [f64; 6]| all.map(|x| f64::from(x as f32));
    let state = |random: &mut Random| {
        let around: [f64; 6] = random.joints(posture.1);
        let q = single(core::array::from_fn(|i| posture.0[i] + around[i]));
        State { q, qd: single(random.joints(2.0)), qdd: single(random.joints(5.0)) }
    };
    (0..STATES).map(|_| state(&mut random)).collect()
}

fn turns<S: Real>(q: &[f64; 6]) -> ([SinCos<S>; 6], [SinCos<DoubleDouble>; 6]) {
    let turn = Libm.sin_cos_all(q).map(|t| SinCos { sin: S::literal(t.sin), cos: S::literal(t.cos) });
    let exact = turn.map(|t| SinCos { sin: Scalar::literal(t.sin.to_f64()), cos: Scalar::literal(t.cos.to_f64()) });
    (turn, exact)
}

/// Largest error and largest torque of every joint, and their worst ratio.
struct Worst {
    torque: [f64; 6],
    error: [f64; 6],
}

impl Worst {
    fn new() -> Self {
        Self { torque: [0.0; 6], error: [0.0; 6] }
    }

    fn add(&mut self, i: usize, torque: f64, error: f64) {
        self.torque[i] = self.torque[i].max(torque.abs());
        // NaN counts as an infinite error.
        self.error[i] = if error.is_nan() { f64::INFINITY } else { self.error[i].max(error.abs()) };
    }

    fn relative(&self) -> f64 {
        let most = self.torque.iter().fold(0.0, |most: f64, &x| most.max(x));
        let one = |i: usize| {
            let own = if self.torque[i] > NOTHING * most { self.torque[i] } else { most };
            if self.error[i] > 0.0 { self.error[i] / own } else { 0.0 }
        };
        (0..6).map(one).fold(0.0, f64::max)
    }
}

fn reference(model: &Model<f64, 6>, scene: &Scene<f64, 6>) -> Dynamics<DoubleDouble, 6> {
    Dynamics::new(model.cast(), scene.cast())
}

fn literal(x: &[f64; 6]) -> [DoubleDouble; 6] {
    x.map(DoubleDouble::literal)
}

/// Errors of inverse dynamics at each kernel level.
fn inverse_errors<S: Real>(model: &Model<f64, 6>, scene: &Scene<f64, 6>, posture: &([f64; 6], f64)) -> [f64; 2] {
    let reference = reference(model, scene);
    let kernel = |level| compile(Function::InverseDynamics, model, scene, level, Precision::of::<S>());
    let kernels = Level::ALL.map(kernel);
    let mut worst = [Worst::new(), Worst::new()];
    for State { q, qd, qdd } in states(posture) {
        let (turn, exact) = turns::<S>(&q);
        let wanted = reference.inverse_dynamics(&exact, &literal(&q), &literal(&qd), &literal(&qdd), &Live::zero());
        let [q, qd, qdd] = [q, qd, qdd].map(|x| x.map(S::literal));
        let inputs = input_values(&turn, &q, &qd, &qdd, &Live::zero());
        for (kernel, worst) in kernels.iter().zip(&mut worst) {
            for (i, (found, wanted)) in kernel.evaluate(&inputs).into_iter().zip(wanted).enumerate() {
                worst.add(i, wanted.to_f64(), wanted.minus(found.to_f64()));
            }
        }
    }
    worst.map(|worst| worst.relative())
}

/// Errors of the torques for the computed accelerations, and errors of the accelerations.
fn forward_errors<S: Real>(
    model: &Model<f64, 6>,
    scene: &Scene<f64, 6>,
    posture: &([f64; 6], f64),
) -> Result<[f64; 2], Singular> {
    let reference = reference(model, scene);
    let dynamics: Dynamics<S, 6> = Dynamics::new(model.cast(), scene.cast());
    let mut worst = Worst::new();
    let (mut most, mut off) = (0.0_f64, 0.0_f64);
    for State { q, qd, qdd } in states(posture) {
        let (turn, exact) = turns::<S>(&q);
        let needed = |qdd: &[f64; 6]| {
            reference.inverse_dynamics(&exact, &literal(&q), &literal(&qd), &literal(qdd), &Live::zero())
        };
        let tau = needed(&qdd).map(|tau| S::literal(tau.to_f64()));
        let (q, qd) = (q.map(S::literal), qd.map(S::literal));
        let found = forward_dynamics(&dynamics, &turn, &q, &qd, &tau, &Live::zero())?.map(|x| x.to_f64());
        for (i, needed) in needed(&found).into_iter().enumerate() {
            worst.add(i, tau[i].to_f64(), needed.minus(tau[i].to_f64()));
            most = most.max(qdd[i].abs());
            // NaN counts as an infinite error.
            off = if found[i].is_nan() { f64::INFINITY } else { off.max((found[i] - qdd[i]).abs()) };
        }
    }
    Ok([worst.relative(), off / most])
}
