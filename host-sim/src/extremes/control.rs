//! The closed loop where its model, its actuators or its gains are wrong, and where it is stable.

use super::sampled_loop::{SampledLoop, longest};
use super::{Cell, Outcome, joints, planar, puma, unlimited};
use crate::closed_loop;
use crate::exit::Failure;
use crate::plant::actuator::ActuatorSettings;
use crate::plant::{Arm, Clock, Plant};
use crate::record::{JointLabel, Record};
use crate::simulate;
use crate::target::{Ticked, Torques};
use dynamics_core::control::{Gains, Guard, Law};
use dynamics_core::trig::{Libm, Method};
use dynamics_core::{
    Body, Command, Controller, ControllerConfig, Dynamics, InverseDynamics, JointKind, Limits, Live, Measurement,
    Model, Reference, Scene, Sensed, Term, Trig,
};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::SceneFile;
use robot_compiler::scene::{MotionSpec, ViaPoint};
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

const GROUP: &str = "control";

/// Every cell.
///
/// # Errors
/// A shipped robot cannot be read, or its scene cannot be run.
pub fn cells() -> Result<Vec<Cell>, Failure> {
    let mut cells = tracking_cells()?;
    for law in LAWS {
        for frequency in [20.0, 80.0] {
            let sampled = sampled(law, frequency)?;
            let predicted = sampled.period_max();
            let name = format!("{}, {frequency} rad/s", law.name);
            let done = "planar 2R in a vertical plane at (0.4, 0.9) rad, critically damped: longest stable period";
            let outcome = Outcome::between(predicted, 1e-5, 1.0, "s");
            cells.push(Cell::new(
                GROUP,
                format!("predicted period, {name}"),
                format!("{done}, from the eigenvalues of the linearised sampled loop"),
                outcome,
                "",
            ));
            let ratio = simulated(&sampled, predicted) / predicted;
            let outcome = Outcome::between(ratio, 0.95, 1.05, "");
            let reason = "the simulated arm leaves the linearised loop";
            cells.push(Cell::new(GROUP, format!("simulated over predicted, {name}"), "longest period at which the swings of the simulated arm, from a hundredth of a degree, shrink in 400 ticks", outcome, reason));
        }
    }
    Ok(cells)
}

/// A law whose stable region is shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct StableLaw {
    pub(super) name: &'static str,
    law: Law,
    delay: usize,
}

pub(super) const LAWS: [StableLaw; 3] = [
    StableLaw { name: "computed torque", law: Law::ComputedTorque, delay: 0 },
    StableLaw { name: "computed torque, a tick late", law: Law::ComputedTorque, delay: 1 },
    StableLaw { name: "PD with gravity", law: Law::PdGravity, delay: 0 },
];

/// Longest stable period (s) over natural frequency (rad/s): predicted, and simulated.
pub(super) fn stable_region(law: StableLaw) -> Result<Vec<(f64, f64, f64)>, Failure> {
    let frequencies = (0..9).map(|k| 5.0 * libm::exp2(f64::from(k) * 0.75));
    let point = |frequency| {
        let sampled = sampled(law, frequency)?;
        let predicted = sampled.period_max();
        Ok((frequency, predicted, simulated(&sampled, predicted)))
    };
    frequencies.map(point).collect()
}

/// The longest period, s, at which the simulated arm settles, to half a percent: looked for from a third to three times the
/// predicted one, where an end of that interval would show as a ratio of three.
fn simulated(sampled: &SampledLoop<2>, predicted: f64) -> f64 {
    longest((predicted / 3.0, predicted * 3.0), 9, |h| settles(sampled, h))
}

const POSTURE: [f64; 2] = [0.4, 0.9];

/// The planar arm in a vertical plane under a law, without limits.
fn sampled(law: StableLaw, frequency: f64) -> Result<SampledLoop<2>, Failure> {
    let robot = planar()?;
    let model = robot.model::<2>().map_err(Failure::input)?;
    let scene = Scene { gravity: Term::Constant(Vector3::new(0.0, -9.81, 0.0)), ..Scene::free_space() };
    let mut file = SceneFile::default_for(robot);
    file.motion = MotionSpec::Hold { q: POSTURE.to_vec(), duration: 1.0 };
    file.control.natural_frequency = vec![frequency; 2];
    let gains: [Gains<f64>; 2] = file.controller_config::<2>(&model).gains;
    Ok(SampledLoop { dynamics: Dynamics::new(model, scene), posture: POSTURE, law: law.law, gains, delay: law.delay })
}

/// Whether the swings of the simulated arm about its posture shrink at this period (s).
fn settles(sampled: &SampledLoop<2>, h: f64) -> bool {
    const TICKS: usize = 400;
    /// A hundredth of a degree.
    const OFF: f64 = 1.75e-4;
    let Ok(robot) = planar() else { return false };
    let Ok(specs) = joints::<2>(&robot) else { return false };
    let arm = Arm {
        joints: unlimited(specs),
        tool: robot.tool,
        payload: None,
        gravity: Vector3::new(0.0, -9.81, 0.0),
        tip_wrench: None,
    };
    let file = SceneFile::default_for(robot);
    let config = ControllerConfig {
        law: sampled.law,
        gains: sampled.gains,
        friction: None,
        limits: [Limits::none(); 2],
        torque_step: [f64::INFINITY; 2],
        guard: [Guard { position_margin: 0.0, velocity_max: f64::INFINITY }; 2],
        ..file.controller_config::<2>(sampled.dynamics.model())
    };
    let mut controller = Controller::new(config, sampled.dynamics, Method::Libm);
    // The delay is in the loop here, not in the actuators: those would let the arm fall until the first command has come.
    let mut waiting = VecDeque::from(vec![torque_at_rest(sampled); sampled.delay]);
    let start = [POSTURE[0] + OFF, POSTURE[1] - OFF];
    let clock = Clock { period: h, steps_per_tick: 8 };
    let mut plant = Plant::new(&arm, None, ActuatorSettings::default(), clock, start);
    let reference = Reference { q: POSTURE, qd: [0.0; 2], qdd: [0.0; 2] };
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    for tick in 0..TICKS {
        let state = *plant.state();
        let off = (0..2).fold(0.0_f64, |off, i| off.max((state.q[i] - POSTURE[i]).abs()));
        // Far out the arm is another one, and swings that have grown there may shrink again.
        if off > 100.0 * OFF {
            return false;
        }
        if tick < TICKS / 4 {
            early = early.max(off);
        } else if tick >= TICKS - TICKS / 4 {
            late = late.max(off);
        }
        let measured = Measurement { sensed: Sensed::State { q: state.q, qd: state.qd }, age_ticks: 0 };
        let Command::Drive { torque, .. } = controller.tick(&reference, &measured) else { return false };
        waiting.push_back(torque);
        let Some(torque) = waiting.pop_front() else { return false };
        if plant.drive(&torque).is_err() {
            return false;
        }
    }
    late < early
}

/// What holds the arm in its posture.
fn torque_at_rest(sampled: &SampledLoop<2>) -> [f64; 2] {
    let turn = Libm.sin_cos_all(&POSTURE);
    sampled.dynamics.inverse_dynamics(&turn, &POSTURE, &[0.0; 2], &[0.0; 2], &Live::zero())
}

/// The Puma fetching 2 kg, with encoders, friction and saturation, as `scenes/puma560_pick.toml` has it.
fn pick() -> Result<SceneFile, Failure> {
    let mut scene = SceneFile::default_for(puma()?);
    let steel = Body {
        mass: 2.0,
        com: Vector3::new(0.0, 0.0, 0.05),
        inertia: Matrix3::from_diagonal(&Vector3::new(0.00144, 0.00144, 0.0012)),
    };
    let point = |q: [f64; 6], duration| ViaPoint { q: q.to_vec(), duration, dwell: 0.0 };
    let start = [0.0, 0.9, -1.6, 0.0, 0.5, 0.0];
    scene.name = "pick".to_owned();
    scene.model.payload = Term::Constant(steel);
    scene.control.natural_frequency = vec![40.0; 6];
    scene.control.observer_bandwidth = 600.0;
    scene.motion = MotionSpec::Quintic {
        points: vec![
            point(start, None),
            point([0.35, 0.7, -1.3, 0.2, 0.4, 0.3], Some(0.6)),
            point([0.6, 0.45, -1.1, 0.3, 0.6, 0.6], Some(0.5)),
            point(start, Some(0.9)),
        ],
        acceleration: None,
        repeat: false,
    };
    scene.plant.payload = Some(steel);
    scene.plant.start = start.to_vec();
    scene.sensors.encoder = true;
    scene.actuators.saturation = true;
    Ok(scene)
}

/// A controller whose drives give `constant` times the torque that it asks for.
struct Drives<C> {
    controller: C,
    constant: f32,
}

impl<C: Torques<f32, 6>> Torques<f32, 6> for Drives<C> {
    fn set_live(&mut self, live: &Live<f32, 6>) -> miette::Result<()> {
        self.controller.set_live(live)
    }

    fn tick(
        &mut self,
        reference: &Reference<f32, 6>,
        measurement: &Measurement<f32, 6>,
    ) -> miette::Result<Ticked<f32, 6>> {
        let ticked = self.controller.tick(reference, measurement)?;
        let command = match ticked.command {
            Command::Drive { torque, limits } => Command::Drive { torque: torque.map(|x| x * self.constant), limits },
            brake @ Command::Brake(_) => brake,
        };
        Ok(Ticked { command, ..ticked })
    }
}

/// Largest tracking error of any joint, rad, or what ended the run.
fn track(told: &SceneFile, nature: &SceneFile, constant: f32) -> Result<Result<f64, String>, Failure> {
    let mut world = simulate::world::<6>(nature)?;
    let model: Model<f64, 6> = told.robot.model().map_err(Failure::input)?;
    let mut controller = Drives { controller: simulate::desk::<f32, 6>(told, &model), constant };
    let ticks = libm::round(world.motion.duration() / world.period) as u64;
    let labels =
        told.robot.joints.iter().map(|j| JointLabel { name: j.name.clone(), kind: JointKind::Revolute }).collect();
    let mut record = Record::new(labels, ticks as usize);
    let closed = closed_loop::run(&mut world, &mut controller, ticks, &AtomicBool::new(false), &mut record, |_| ());
    if let Some(fault) = record.faults().iter().flatten().next() {
        return Ok(Err(fault.to_string()));
    }
    if closed.end != closed_loop::End::Complete {
        return Ok(Err(format!("{:?}", closed.end)));
    }
    let errors = (0..6).flat_map(|joint| record.joint(joint).map(|sample| sample.error().abs()).collect::<Vec<_>>());
    Ok(Ok(errors.fold(0.0, f64::max)))
}

fn tracking_cells() -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::new();
    let scene = pick()?;
    let mut add = |name: &str, done: &str, found: Result<f64, String>, most: f64, reason: &str| {
        let outcome = match found {
            Ok(error) => Outcome::at_most(error, most, "rad"),
            Err(ended) => Outcome::words(ended, "the motion to its end"),
        };
        cells.push(Cell::new(
            GROUP,
            name,
            format!("Puma fetching 2 kg, {done}: largest tracking error"),
            outcome,
            reason,
        ));
    };
    add("as modelled", "encoders, friction", track(&scene, &scene, 1.0)?, 1e-3, "the loop itself is wrong");
    let payload = |mass: f64| {
        let mut nature = scene.clone();
        nature.plant.payload =
            scene.plant.payload.map(|body| Body { mass, inertia: body.inertia * (mass / body.mass), ..body });
        nature
    };
    let wrong = "the feedback alone carries what the model has wrong";
    add("payload twice the model's", "it holds 4 kg", track(&scene, &payload(4.0), 1.0)?, 0.05, wrong);
    let mut empty = scene.clone();
    empty.plant.payload = None;
    add("payload that is not there", "it holds nothing", track(&scene, &empty, 1.0)?, 0.05, wrong);
    add("torque constant 1.3", "drives give 1.3 of the torque", track(&scene, &scene, 1.3)?, 0.05, wrong);
    add("torque constant 1 / 1.3", "drives give 0.77 of the torque", track(&scene, &scene, 1.0 / 1.3)?, 0.05, wrong);
    let mut rough = scene.clone();
    for joint in &mut rough.robot.joints {
        if let Some(friction) = &mut joint.friction {
            friction.coulomb *= 3.0;
        }
    }
    let reason = "78 N m of friction leave the waist's drive of 97.6 N m too little for this motion: with stronger drives the error is that of \
                  the next cell";
    add(
        "Coulomb friction three times the model's",
        "joints rub thrice as much",
        track(&scene, &rough, 1.0)?,
        0.05,
        reason,
    );
    let (mut told, mut strong) = (scene.clone(), rough.clone());
    for joint in told.robot.joints.iter_mut().chain(&mut strong.robot.joints) {
        joint.spec.limits.torque *= 10.0;
    }
    let name = "Coulomb friction three times the model's, strong drives";
    add(name, "the same with torque limits ten times as high", track(&told, &strong, 1.0)?, 0.05, wrong);
    for share in [0.5, 0.25] {
        let mut weak = scene.clone();
        for joint in &mut weak.robot.joints {
            joint.spec.limits.torque *= share;
        }
        let reason =
            "a quarter of its torque does not carry the arm along this motion: it lags behind, and comes to no fault";
        add(&format!("torque limits times {share}"), "saturated drives", track(&weak, &weak, 1.0)?, 0.1, reason);
    }
    Ok(cells)
}
