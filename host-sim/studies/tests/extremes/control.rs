//! The closed loop with a wrong model, imperfect actuators or imperfect joints.

use super::{Cell, Outcome, puma};
use dynamics_core::{Body, Command, JointKind, Live, Measurement, Model, Reference, Term};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::scene::{MotionSpec, ViaPoint};
use robot_compiler::{Breakaway, JointFriction, RobotJoint, SceneFile};
use sim::failure::Failure;
use sim::run::closed_loop;
use sim::run::joint_label::JointLabel;
use sim::run::record::Record;
use sim::run::scene_world;
use sim::run::simulate;
use sim::run::target::{Ticked, Torques};
use std::sync::atomic::AtomicBool;

const GROUP: &str = "control";

/// The Puma picking up 2 kg, with encoders, friction and saturation, as in `scenes/puma560_pick.toml`.
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

/// A controller with drives that produce `constant` times the commanded torque.
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

/// Runs a motion and `beyond` seconds after it. Returns the record, or the reason why the run ended early. `told` is the controller's scene, `nature`
/// the simulated one.
fn follow(told: &SceneFile, nature: &SceneFile, constant: f32, beyond: f64) -> Result<Result<Record, String>, Failure> {
    let mut world = scene_world::world::<6>(nature)?;
    let model: Model<f64, 6> = told.robot.model().map_err(Failure::input)?;
    let mut controller = Drives { controller: simulate::desk::<f32, 6>(told, &model), constant };
    let ticks = libm::round((world.motion.duration() + beyond) / world.period) as u64;
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
    Ok(Ok(record))
}

/// Largest tracking error of any joint, rad.
fn largest_error(record: &Record) -> f64 {
    let errors = (0..6).flat_map(|joint| record.joint(joint).map(|sample| sample.error().abs()).collect::<Vec<_>>());
    errors.fold(0.0, f64::max)
}

/// Largest tracking error of any joint, rad, or the reason why the run ended early.
fn track(told: &SceneFile, nature: &SceneFile, constant: f32) -> Result<Result<f64, String>, Failure> {
    Ok(follow(told, nature, constant, 0.0)?.map(|record| largest_error(&record)))
}

/// All cells of this group.
///
/// # Errors
/// A shipped robot cannot be read, or its scene cannot be run.
pub(crate) fn cells() -> Result<Vec<Cell>, Failure> {
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
        "joints have three times the friction",
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
    breakaway_cells(&mut cells, &scene)?;
    Ok(cells)
}

/// Cells of joints with a breakaway torque of three times their sliding Coulomb torque. The controller models only the Coulomb torque.
///
/// There are three motions: the pick, two seconds at rest after it, and every joint creeping at 20 mrad/s.
fn breakaway_cells(cells: &mut Vec<Cell>, pick: &SceneFile) -> Result<(), Failure> {
    const STRIBECK: f64 = 0.05;
    const CREEP: f64 = 0.02;
    const HOLD: f64 = 2.0;
    let sticky = |scene: &SceneFile| {
        let mut sticky = scene.clone();
        let of_joint = |joint: &RobotJoint| {
            let friction = joint.friction.unwrap_or_default();
            let breakaway = Breakaway { torque: 3.0 * friction.coulomb, speed: STRIBECK, load: 0.0 };
            JointFriction { breakaway: Some(breakaway), ..friction }
        };
        sticky.plant.friction_law = Some(scene.robot.joints.iter().map(of_joint).collect());
        // Steep friction near rest requires this small step.
        sticky.plant.step = 6.25e-5;
        sticky
    };
    let mut creep = pick.clone();
    let start = pick.plant.start.clone();
    let speed = [CREEP; 6];
    let duration = 4.0;
    let goal: Vec<f64> = start.iter().zip(speed).map(|(q, speed)| q + speed * (duration - 0.5)).collect();
    creep.motion =
        MotionSpec::Trapezoid { start, goal, acceleration: None, duration: Some(duration), ramp_share: 0.125 };
    let done =
        "breakaway at three times Coulomb's torque, Stribeck velocity 0.05 rad/s, the model knows Coulomb's alone";
    let mut add = |name: &str, what: &str, found: Result<f64, String>, most: f64, unit, reason: &str| {
        let outcome = found
            .map_or_else(|ended| Outcome::words(ended, "the motion to its end"), |x| Outcome::at_most(x, most, unit));
        cells.push(Cell::new(GROUP, format!("breakaway, {name}"), format!("{done}: {what}"), outcome, reason));
    };
    let run = follow(pick, &sticky(pick), 1.0, HOLD)?;
    let found = run.clone().map(|record| largest_error(&record));
    let wrong = "the feedback alone carries what the model has wrong";
    add("pick", "largest tracking error of the Puma fetching 2 kg", found, 0.05, "rad", wrong);
    let last_second = |of: fn(f64, f64, f64) -> f64| {
        run.clone().map(|record| {
            (0..6).fold(0.0_f64, |worst, joint| {
                let errors: Vec<f64> = record.joint(joint).map(|sample| sample.error()).collect();
                let tail = &errors[errors.len().saturating_sub(1000)..];
                let low = tail.iter().copied().fold(f64::INFINITY, f64::min);
                let high = tail.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                worst.max(of(low, high, tail.iter().map(|x| x.abs()).sum::<f64>() / tail.len() as f64))
            })
        })
    };
    let what = "peak to peak of the worst joint in the second second of standing still after it";
    add("hunting at rest", what, last_second(|low, high, _| high - low), 1e-3, "rad", "the arm hunts");
    let what = "mean distance of the worst joint from its goal in that second: where it has stuck";
    add("stuck at rest", what, last_second(|_, _, mean| mean), 0.05, "rad", "the arm sticks far from its goal");
    // The same joints with Coulomb friction alone, for comparison with the stick-slip motion.
    for (name, nature) in [("creeping", sticky(&creep)), ("creeping, Coulomb's friction alone", creep.clone())] {
        let run = follow(&creep, &nature, 1.0, 0.0)?;
        let what = "every joint at 20 mrad/s, fastest speed of any joint over that";
        let fastest = run.clone().map(|record| {
            let peaks = (0..6).map(|joint| record.joint(joint).fold(0.0_f64, |most, sample| most.max(sample.qd.abs())));
            peaks.fold(0.0, f64::max) / CREEP
        });
        add(&format!("peak speed, {name}"), what, fastest, f64::INFINITY, "", "");
        let what = "every joint at 20 mrad/s for 4 s, times that a joint breaks away, its start among them, the most of any joint";
        let slips = run.map(|record| (0..6).map(|joint| slips(&record, joint, CREEP)).fold(0, usize::max) as f64);
        add(&format!("slips, {name}"), what, slips, f64::INFINITY, "", "");
    }
    Ok(())
}

/// Number of times that a joint at rest (below a tenth of `speed`) breaks away and exceeds half of `speed`; the start counts as one.
fn slips(record: &Record, joint: usize, speed: f64) -> usize {
    let (mut moving, mut slips) = (false, 0);
    for sample in record.joint(joint) {
        if moving && sample.qd.abs() < 0.1 * speed {
            moving = false;
        } else if !moving && sample.qd.abs() > 0.5 * speed {
            moving = true;
            slips += 1;
        }
    }
    slips
}
