//! Extreme numbers as inputs of the real controller: it gives a correct torque or the documented fault.
//!
//! The arm is the shipped Puma, and also the UR5 for the region of small error. It has no limits, guards or friction, so that nothing alters an input
//! before the torque. The exact torque comes from the recursion in double-double arithmetic, at the state before rounding to the controller's scalar,
//! so the rounding of a large angle counts as error.

use super::{Cell, Outcome, ROUNDING_MOST, Random, joints, puma, scalar_name, unlimited, ur5};
use dynamics_core::control::{ControllerOf, Guard};
use dynamics_core::trig::{Libm, Method, Polynomial};
use dynamics_core::{
    Command, Controller, ControllerConfig, Dynamics, Fault, InverseDynamics, Limits, Live, Measurement, Model, Real,
    Reference, Scalar, Scene, Sensed, SinCos, Term, Tool, Trig,
};
use nalgebra::Vector3;
use robot_compiler::precision::DoubleDouble;
use robot_compiler::{Robot, SceneFile};
use sim::failure::Failure;
use std::f64::consts::TAU;

const GROUP: &str = "inputs";

/// Largest allowed error as a share of the torque limit.
const SHARE: f64 = 1e-4;
/// Number of random states in each list of states.
const STATES: usize = 24;

type Loop<S> = ControllerOf<S, 6, Dynamics<S, 6>, Method>;

/// The arm, its exact control law, and its torque limits.
struct Bench {
    model: Model<f64, 6>,
    scene: Scene<f64, 6>,
    config: ControllerConfig<f64, 6>,
    reference: Dynamics<DoubleDouble, 6>,
    torque_max: [f64; 6],
}

/// An input of the controller.
#[derive(Clone, Copy)]
enum Input {
    ReferencePosition,
    ReferenceVelocity,
    ReferenceAcceleration,
    Position,
    Velocity,
}

impl Input {
    const ALL: [Self; 5] =
        [Self::ReferencePosition, Self::ReferenceVelocity, Self::ReferenceAcceleration, Self::Position, Self::Velocity];

    fn name(self) -> &'static str {
        match self {
            Self::ReferencePosition => "reference position",
            Self::ReferenceVelocity => "reference velocity",
            Self::ReferenceAcceleration => "reference acceleration",
            Self::Position => "measured position",
            Self::Velocity => "measured velocity",
        }
    }

    /// Fault raised by a NaN or infinite input.
    fn fault(self, joint: u8) -> Fault {
        match self {
            Self::Position | Self::Velocity => Fault::NonFiniteMeasurement { joint },
            _ => Fault::NonFiniteReference { joint },
        }
    }
}

/// All inputs of a tick, `[reference q, qd, qdd, measured q, qd]`.
type Inputs = [[f64; 6]; 5];

impl Bench {
    fn new(robot: Robot) -> Result<Self, Failure> {
        let file = SceneFile::default_for(robot);
        let specs = joints::<6>(&file.robot)?;
        let torque_max = specs.map(|joint| joint.limits.torque);
        let refused = |error| Failure::Input(miette::miette!("{}: {error}", file.robot.name));
        let model = Model::new_unphysical(&unlimited(specs), &Tool::default()).map_err(refused)?;
        let scene = Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model);
        let config = ControllerConfig {
            friction: None,
            limits: [Limits::none(); 6],
            torque_step: [f64::INFINITY; 6],
            guard: [Guard { position_margin: 0.0, velocity_max: f64::INFINITY }; 6],
            ..file.controller_config(&model)
        };
        let reference = Dynamics::new(model.cast(), scene.cast());
        Ok(Self { model, scene, config, reference, torque_max })
    }

    fn controller<S: Real>(&self, trig: Method) -> Loop<S>
    where
        Method: Trig<S>,
    {
        Controller::new(self.config.cast(), Dynamics::new(self.model.cast(), self.scene.cast()), trig)
    }

    fn tick<S: Real>(controller: &mut Loop<S>, inputs: &Inputs) -> Result<[f64; 6], Fault>
    where
        Method: Trig<S>,
    {
        let [reference_q, reference_qd, qdd, q, qd] = inputs.map(|x| x.map(S::literal));
        let reference = Reference { q: reference_q, qd: reference_qd, qdd };
        match controller.tick(&reference, &Measurement { sensed: Sensed::State { q, qd }, age_ticks: 0 }) {
            Command::Drive { torque, .. } => Ok(torque.map(|x| x.to_f64())),
            Command::Brake(fault) => Err(fault),
        }
    }

    /// Torques of the control law in double-double arithmetic.
    fn wanted(&self, inputs: &Inputs) -> [DoubleDouble; 6] {
        let [reference_q, reference_qd, reference_qdd, q, qd] = inputs.map(|x| x.map(DoubleDouble::literal));
        let turn =
            Libm.sin_cos_all(&inputs[3]).map(|t| SinCos { sin: Scalar::literal(t.sin), cos: Scalar::literal(t.cos) });
        let qdd = core::array::from_fn(|i| {
            let gains = &self.config.gains[i];
            reference_qdd[i]
                + DoubleDouble::literal(gains.velocity) * (reference_qd[i] - qd[i])
                + DoubleDouble::literal(gains.position) * (reference_q[i] - q[i])
        });
        self.reference.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero())
    }

    /// Largest error relative to the joint's `scale`, over all states in which the controller drives; a fault ends the search.
    fn error<S: Real>(&self, trig: Method, states: &[Inputs], scale: Scale) -> Result<f64, Fault>
    where
        Method: Trig<S>,
    {
        let mut controller = self.controller::<S>(trig);
        let mut worst = 0.0_f64;
        for inputs in states {
            let wanted = self.wanted(inputs);
            let found = Self::tick(&mut controller, inputs)?;
            let most = wanted.iter().fold(0.0_f64, |most, x| most.max(x.to_f64().abs()));
            for i in 0..6 {
                let size = match scale {
                    Scale::Limit => self.torque_max[i],
                    Scale::State => most,
                };
                let error = wanted[i].minus(found[i]).abs() / size;
                worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
            }
        }
        Ok(worst)
    }
}

/// Reference to which an error is relative.
#[derive(Clone, Copy)]
enum Scale {
    /// The joint's torque limit.
    Limit,
    /// The largest torque of the state.
    State,
}

/// States with angles from half of `angle` to `angle` and speeds up to `rate`; the reference equals the arm's state.
fn states(angle: f64, rate: f64, acceleration: f64) -> Vec<Inputs> {
    let mut random = Random(11);
    let mut state = || {
        let q = core::array::from_fn(|_| {
            let x = random.next();
            angle * (0.75 + 0.25 * random.next()) * if x < 0.0 { -1.0 } else { 1.0 }
        });
        let qd = random.joints(rate);
        [q, qd, random.joints(acceleration), q, qd]
    };
    (0..STATES).map(|_| state()).collect()
}

/// All cells of this group.
///
/// # Errors
/// The shipped robot cannot be read.
pub(crate) fn cells() -> Result<Vec<Cell>, Failure> {
    let bench = Bench::new(puma()?)?;
    let mut cells = Vec::new();
    scalar_cells::<f32>(&bench, &mut cells);
    scalar_cells::<f64>(&bench, &mut cells);
    angle_cells(&bench, &mut cells);
    for arm in region_arms()? {
        for angle in REGION_F32 {
            region_cell::<f32>(&arm, &mut cells, angle);
        }
        for angle in REGION_F64 {
            region_cell::<f64>(&arm, &mut cells, angle);
        }
    }
    Ok(cells)
}

/// Angles of the region in the table, turns.
const REGION_F32: [f64; 5] = [1.0, 10.0, 100.0, 500.0, 1300.0];
const REGION_F64: [f64; 5] = [1.0, 100.0, 1e4, 1e5, 1.6e5];

fn scalar_cells<S: Real>(bench: &Bench, cells: &mut Vec<Cell>)
where
    Method: Trig<S>,
{
    let scalar = scalar_name::<S>();
    let home = states(1.0, 1.0, 1.0)[0];
    for (index, input) in Input::ALL.into_iter().enumerate() {
        let right = (0..6_u8).flat_map(|joint| [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|bad| (joint, bad)));
        let right = right.filter(|&(joint, bad)| {
            let mut inputs = home;
            inputs[index][usize::from(joint)] = bad;
            Bench::tick(&mut bench.controller::<S>(Method::Polynomial), &inputs) == Err(input.fault(joint))
        });
        let code = input.fault(0).code();
        cells.push(Cell::new(
            GROUP,
            format!("{} not finite, {scalar}", input.name()),
            "NaN and both infinities on each joint",
            Outcome::words(
                format!("fault {code} on its joint in {} of 18", right.count()),
                format!("fault {code} on its joint in 18 of 18"),
            ),
            "another fault, another joint, or a torque",
        ));
        let mut inputs = home;
        inputs[index][1] = S::MAX.to_f64();
        let found = describe(&Bench::tick(&mut bench.controller::<S>(Method::Polynomial), &inputs));
        cells.push(Cell::new(
            GROUP,
            format!("{} the last number, {scalar}", input.name()),
            "joint 2 at the last number before overflow, no limits and no guards",
            Outcome::words(found, "fault 7"),
            "a torque in silence",
        ));
    }
    live_cells::<S>(bench, cells, &home);
    let mut controller = bench.controller::<S>(Method::Polynomial);
    let [reference_q, reference_qd, qdd, q, qd] = home.map(|x| x.map(S::literal));
    let stale = Measurement { sensed: Sensed::State { q, qd }, age_ticks: u32::MAX };
    let command = controller.tick(&Reference { q: reference_q, qd: reference_qd, qdd }, &stale);
    let found = match command {
        Command::Drive { .. } => "a torque".to_owned(),
        Command::Brake(fault) => format!("fault {}", fault.code()),
    };
    cells.push(Cell::new(
        GROUP,
        format!("the oldest measurement, {scalar}"),
        "an age of 2^32 - 1 ticks",
        Outcome::words(found, "fault 3"),
        "a stale measurement is believed",
    ));
    guard_cells::<S>(bench, cells, &home);
    size_cells::<S>(bench, cells);
}

/// Access to one number of the live inputs.
type LiveNumber<S> = fn(&mut Live<S, 6>, usize) -> &mut S;

/// Live inputs that are NaN, infinite or too large.
fn live_cells<S: Real>(bench: &Bench, cells: &mut Vec<Cell>, home: &Inputs)
where
    Method: Trig<S>,
{
    // The six independent entries of the payload's inertia tensor.
    const TENSOR: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let inputs: [(&str, usize, LiveNumber<S>); 7] = [
        ("gravity", 3, |live, i| &mut live.gravity[i]),
        ("payload mass", 1, |live, _| &mut live.payload.mass),
        ("payload first moment", 3, |live, i| &mut live.payload.first_moment[i]),
        ("payload inertia", 6, |live, i| &mut live.payload.about_origin[TENSOR[i]]),
        ("tip force", 3, |live, i| &mut live.tip_wrench.force[i]),
        ("tip moment", 3, |live, i| &mut live.tip_wrench.moment[i]),
        ("rotor inertia", 6, |live, i| &mut live.rotor[i]),
    ];
    let scene = Scene {
        gravity: Term::Live,
        payload: Term::Live,
        tip_wrench: Term::Live,
        rotor: Term::Live,
        ..bench.scene.cast()
    };
    let tick = |number: LiveNumber<S>, i: usize, bad: S| {
        let mut controller = bench.controller::<S>(Method::Polynomial);
        *controller.dynamics_mut() = Dynamics::new(bench.model.cast(), scene);
        *number(controller.live_mut(), i) = bad;
        Bench::tick(&mut controller, home)
    };
    for (name, count, number) in inputs {
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(S::literal);
        let tried = (0..count).flat_map(|i| bad.map(|bad| (i, bad)));
        let right = tried.filter(|&(i, bad)| tick(number, i, bad).is_err_and(|fault| fault.code() == 7)).count();
        let all = 3 * count;
        cells.push(Cell::new(
            GROUP,
            format!("live {name} not finite, {}", scalar_name::<S>()),
            "NaN and both infinities in each number, set between ticks, past the link that would refuse them",
            Outcome::words(format!("fault 7 in {right} of {all}"), format!("fault 7 in {all} of {all}")),
            "a torque in silence",
        ));
    }
    let right = (0..3).filter(|&i| tick(inputs[0].2, i, S::MAX).is_err_and(|fault| fault.code() == 7)).count();
    cells.push(Cell::new(
        GROUP,
        format!("live gravity the last number, {}", scalar_name::<S>()),
        "the last number before overflow along each axis, no limits and no guards",
        Outcome::words(format!("fault 7 in {right} of 3"), "fault 7 in 3 of 3"),
        "a torque in silence",
    ));
}

/// Cells with active limits and guards.
fn guard_cells<S: Real>(bench: &Bench, cells: &mut Vec<Cell>, home: &Inputs)
where
    Method: Trig<S>,
{
    let limits = Limits { position: (-3.0, 3.0), velocity: 2.0, torque: 100.0, torque_rate: f64::INFINITY };
    let config = ControllerConfig {
        limits: [limits; 6],
        guard: [Guard { position_margin: 0.05, velocity_max: 3.0 }; 6],
        ..bench.config
    };
    for (index, quantity, code) in [(3, "position", 4), (4, "velocity", 5)] {
        let mut right = 0;
        for joint in 0..6 {
            for sign in [1.0, -1.0] {
                let dynamics = Dynamics::new(bench.model.cast(), bench.scene.cast());
                let mut controller: Loop<S> = Controller::new(config.cast(), dynamics, Method::Polynomial);
                let mut inputs = *home;
                inputs[index][joint] = sign * S::MAX.to_f64();
                let found = Bench::tick(&mut controller, &inputs);
                right +=
                    usize::from(found.is_err_and(|fault| fault.code() == code && fault.joint() == Some(joint as u8)));
            }
        }
        cells.push(Cell::new(
            GROUP,
            format!("measured {quantity} the last number, guarded, {}", scalar_name::<S>()),
            "either sign, each joint, limits and guards in force",
            Outcome::words(
                format!("fault {code} on its joint in {right} of 12"),
                format!("fault {code} on its joint in 12 of 12"),
            ),
            "another fault, another joint, or a torque",
        ));
    }
}

/// Numbers that are very small, very large, or zero of either sign.
fn size_cells<S: Real>(bench: &Bench, cells: &mut Vec<Cell>)
where
    Method: Trig<S>,
{
    let scalar = scalar_name::<S>();
    let single = size_of::<S>() == size_of::<f32>();
    let relative = ROUNDING_MOST[usize::from(!single)];
    let smallest = if single { f64::from(f32::from_bits(1)) } else { f64::from_bits(1) };
    let mut push = |name: &str, done: &str, found: Result<f64, Fault>, most: f64| {
        let outcome = match found {
            Ok(error) => Outcome::at_most(error, most, ""),
            Err(fault) => Outcome::words(format!("fault {}", fault.code()), "a torque"),
        };
        cells.push(Cell::new(GROUP, format!("{name}, {scalar}"), done, outcome, "a wrong torque in silence"));
    };
    push(
        "subnormal",
        "every input the smallest number above zero; error over the joint's torque limit",
        bench.error::<S>(Method::Polynomial, &[[[smallest; 6]; 5]], Scale::Limit),
        SHARE,
    );
    for rate in [10.0, 1e2, 1e3, 1e4] {
        let found = bench.error::<S>(Method::Polynomial, &states(3.0, rate, 5.0), Scale::State);
        push(&format!("rates to {rate} rad/s"), "error over the state's largest torque", found, relative);
    }
    for acceleration in [1e3, 1e6] {
        let found = bench.error::<S>(Method::Polynomial, &states(3.0, 2.0, acceleration), Scale::State);
        push(
            &format!("accelerations to {acceleration:e} rad/s^2"),
            "error over the state's largest torque",
            found,
            relative,
        );
    }
    let bits = |x: f64| {
        Bench::tick(&mut bench.controller::<S>(Method::Polynomial), &[[x; 6]; 5]).map(|torque| torque.map(f64::to_bits))
    };
    let found = if bits(-0.0) == bits(0.0) && bits(0.0).is_ok() { "the same bits" } else { "other bits" };
    cells.push(Cell::new(
        GROUP,
        format!("signed zeros, {scalar}"),
        "every input -0, against +0",
        Outcome::words(found, "the same bits"),
        "a command depends on the sign of a zero",
    ));
}

/// Describes a command.
fn describe(found: &Result<[f64; 6], Fault>) -> String {
    match found {
        Ok(torque) => {
            let most = torque.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            format!("a torque of {most:.2e} N m")
        }
        Err(fault) => format!("fault {}", fault.code()),
    }
}

/// Cells with angles of many turns.
fn angle_cells(bench: &Bench, cells: &mut Vec<Cell>) {
    for turns in [1.0, 10.0, 100.0, 1e3, 1e6] {
        let found = bench.error::<f32>(Method::Polynomial, &states(turns * TAU, 1.0, 1.0), Scale::Limit);
        let beyond = turns * TAU > f64::from(Polynomial::LIMIT_F32);
        angle_cell(cells, turns, "f32, polynomial", found, beyond);
        if turns > 100.0 {
            let found = bench.error::<f32>(Method::Libm, &states(turns * TAU, 1.0, 1.0), Scale::Limit);
            angle_cell(cells, turns, "f32, libm", found, beyond);
        }
    }
    for turns in [1.0, 1e3, 1e5, 1e6] {
        let found = bench.error::<f64>(Method::Polynomial, &states(turns * TAU, 1.0, 1.0), Scale::Limit);
        angle_cell(cells, turns, "f64, polynomial", found, turns * TAU > Polynomial::LIMIT_F64);
        if turns > 1e5 {
            let found = bench.error::<f64>(Method::Libm, &states(turns * TAU, 1.0, 1.0), Scale::Limit);
            angle_cell(cells, turns, "f64, libm", found, false);
        }
    }
}

fn angle_cell(cells: &mut Vec<Cell>, turns: f64, who: &str, found: Result<f64, Fault>, beyond: bool) {
    let outcome = match found {
        Ok(error) if !beyond => Outcome::at_most(error, SHARE, ""),
        Ok(error) => Outcome::words(format!("a torque, wrong by {error:.1e}"), "fault 7"),
        Err(fault) => Outcome::words(format!("fault {}", fault.code()), if beyond { "fault 7" } else { "a torque" }),
    };
    cells.push(Cell::new(
        GROUP,
        format!("angles of {}, {who}", turns_name(turns)),
        "half to all of it on each joint; error over the joint's torque limit",
        outcome,
        "the angle itself is rounded to one part in 2^24 before the controller sees it",
    ));
}

fn turns_name(turns: f64) -> String {
    if turns <= 1.0 {
        "1 turn".to_owned()
    } else if turns < 1e4 {
        format!("{turns} turns")
    } else {
        format!("{turns:e} turns")
    }
}

/// Largest rate, rad/s, at which the error stays under [`SHARE`] of the torque limit; zero if there is none.
fn rate_max<S: Real>(bench: &Bench, angle: f64) -> f64
where
    Method: Trig<S>,
{
    let inside = |rate: f64| {
        bench.error::<S>(Method::Polynomial, &states(angle, rate, 0.0), Scale::Limit).is_ok_and(|error| error <= SHARE)
    };
    let (mut low, mut high) = (-6.0_f64, 30.0_f64);
    if !inside(libm::exp2(low)) {
        return 0.0;
    }
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        if inside(libm::exp2(middle)) {
            low = middle;
        } else {
            high = middle;
        }
    }
    libm::exp2(low)
}

/// An arm for the region of small error.
struct RegionArm {
    name: &'static str,
    bench: Bench,
    /// Speed of its fastest joint, rad/s; the region must include it.
    own_rate: f64,
}

fn region_arms() -> Result<[RegionArm; 2], Failure> {
    let arm = |name, robot: Robot| {
        let own_rate = robot.joints.iter().fold(0.0, |most: f64, joint| most.max(joint.spec.limits.velocity));
        Ok(RegionArm { name, bench: Bench::new(robot)?, own_rate })
    };
    Ok([arm("Puma 560", puma()?)?, arm("UR5", ur5()?)?])
}

fn region_cell<S: Real>(arm: &RegionArm, cells: &mut Vec<Cell>, turns: f64)
where
    Method: Trig<S>,
{
    let rate = rate_max::<S>(&arm.bench, turns * TAU);
    // Within one turn the arm's own speed range is required; beyond one turn nothing is.
    let outcome = if turns <= 1.0 {
        Outcome::between(rate, arm.own_rate, f64::INFINITY, "rad/s")
    } else {
        Outcome::record(rate, "rad/s")
    };
    cells.push(Cell::new(
        GROUP,
        format!("region at {}, {}, {}", turns_name(turns), arm.name, scalar_name::<S>()),
        "largest joint rate at which every joint's error stays under 1e-4 of its torque limit",
        outcome,
        "the arm's own range is outside the region",
    ));
}
