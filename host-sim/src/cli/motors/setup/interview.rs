//! Interview of the person who moves the arm by hand: the motor and direction of each joint, its zero, and its ends.

use super::drive_tables::{DriveModel, FoundDrive, is_same, names};
use super::person::Person;
use board::can::adapter::Adapter;
use board::can::setup::{Movement, ShaftMotor, jumped, moved, positions, still_positions, zero};
use dynamics_core::JointKind;
use dynamics_core::drive::Protocol;
use robot_compiler::{Robot, RobotJoint};
use sim::failure::Failure;
use sim::terminal;
use std::f64::consts::TAU;
use std::io;

/// A range that was reached, against the robot file's: a difference below this, rad or m, is not worth a message.
const NEAR: f64 = 0.05;

/// Largest difference of the position range of a RobStride model's frames from that of the others, rad.
const SAME_POSITION: f64 = 0.1;

fn units(joint: &RobotJoint) -> &'static str {
    match joint.spec.kind {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    }
}

/// Shaft rad per joint rad or m.
fn gear(joint: &RobotJoint) -> f64 {
    joint.drive.and_then(|drive| drive.mit()).map_or(1.0, |drive| drive.ratio.abs())
}

/// Asks for the ranges of the frames of a motor that does not say them, unless the robot file has them. What contradicts the motor's torque limit is asked
/// for a second time: with a wrong torque range the motor gives another torque than commanded.
fn model(person: &Person, motor: &ShaftMotor, joint: &RobotJoint) -> Result<DriveModel, Failure> {
    if let Some(said) = DriveModel::said(motor) {
        return Ok(said);
    }
    let (mut given, mut doubted, mut too_weak) = (DriveModel::of_file(joint), None, None);
    loop {
        if let Some(model) = given {
            let [position, velocity, torque, ..] = model.ranges();
            let (limits, gear) = (&joint.spec.limits, gear(joint));
            let is_too_weak = limits.torque > torque * gear || limits.velocity * gear > velocity;
            let agrees = motor.torque_limit.is_some_and(|limit| is_same(limit, torque));
            let text = model.text();
            if (position - motor.position).abs() > SAME_POSITION {
                terminal::print(&format!(
                    "  the position range of {text} is {position} rad; expected {} rad, that of every {} model\n",
                    motor.position,
                    motor.kind.facts().name
                ))?;
            } else if !agrees && doubted != Some(model.ranges()) {
                let limit = motor.torque_limit.map_or("unknown".to_owned(), |limit| format!("{limit} N m"));
                terminal::print(&format!(
                    "  the frames of {text} have {torque} N m, and the torque limit of motor {} is {limit}: is this its model? If so, enter it again\n",
                    motor.id
                ))?;
                doubted = Some(model.ranges());
            } else if is_too_weak {
                // The robot file would be rejected at the end.
                let why = format!(
                    "the limits of {} are {} N m and {} rad/s, and the frames of {text} have {torque} N m and {velocity} rad/s at the shaft, with a gear of \
                     {gear}: wrong model, or wrong limits or gear in the robot file",
                    joint.name, limits.torque, limits.velocity
                );
                if agrees || too_weak == Some(model.ranges()) {
                    let how = if agrees { "its torque limit says so" } else { "it was entered again" };
                    return Err(Failure::Input(miette::miette!(
                        help = "correct the robot file, then begin again",
                        "{why}; motor {} is {text}, because {how}: nothing was written",
                        motor.id
                    )));
                }
                terminal::print(&format!("  {why}. The same model again ends the setup\n"))?;
                too_weak = Some(model.ranges());
            } else {
                return Ok(model);
            }
        }
        person.forget();
        terminal::print(&format!(
            "  model of motor {}, as on its label: {}. For another model, the highest position (rad), velocity (rad/s), torque (N m), kp and kd of \
             its frames: five numbers (docs/reference/drives.md)\n",
            motor.id,
            names(motor.kind)
        ))?;
        given = DriveModel::typed(&person.enter()?, motor.kind);
    }
}

/// Warning about a RobStride motor that may show the joint a whole turn away after power-up; `None` if it cannot.
fn power_up_warning(joint: &RobotJoint, found: &FoundDrive) -> Option<String> {
    let FoundDrive { motor, direction, zero, .. } = *found;
    if motor.kind != Protocol::RobStride {
        return None;
    }
    let (id, name) = (motor.id, &joint.name);
    let Some(lowest) = motor.power_up_lowest else {
        return Some(format!(
            "  {name}: motor {id} does not say which turn it shows after power-up (parameter 0x7029). With an encoder on the motor alone (RS01), the joint may \
             then be wrong by a part of a turn. Compare its position with the arm after each power-up\n"
        ));
    };
    let ends = <[f64; 2]>::from(joint.spec.limits.position).map(|q| zero + direction * gear(joint) * q);
    let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let is_within = lowest + NEAR <= low && high <= lowest + TAU - NEAR;
    (!is_within).then(|| {
        format!(
            "  {name}: motor {id} is at {low:.2} to {high:.2} rad between the joint's limits, and after power-up it shows {lowest:.2} to {:.2} rad \
             (parameter 0x7029): the joint may then be read a whole turn away. Compare its position with the arm after each power-up\n",
            lowest + TAU
        )
    })
}

/// The interview about an arm whose motors are on this adapter.
pub(super) struct Interview<'a> {
    robot: &'a Robot,
    adapter: &'a mut dyn Adapter,
    /// The failure for an error of the adapter.
    failed: &'a dyn Fn(io::Error) -> Failure,
    person: Person,
}

impl<'a> Interview<'a> {
    /// Begins to read the person's lines.
    pub(super) fn new(
        robot: &'a Robot,
        adapter: &'a mut dyn Adapter,
        failed: &'a dyn Fn(io::Error) -> Failure,
    ) -> Self {
        Self { robot, adapter, failed, person: Person::new() }
    }

    /// Asks for each joint's movement.
    pub(super) fn joints(&mut self, motors: &[ShaftMotor]) -> Result<Vec<FoundDrive>, Failure> {
        let Self { robot, adapter, failed, person } = self;
        let (mut found, mut taken) = (Vec::new(), Vec::new());
        for (number, joint) in (1..).zip(&robot.joints) {
            loop {
                let before = still_positions(*adapter, motors).map_err(*failed)?;
                person.forget();
                terminal::print(&format!(
                    "joint {number} of {}, {}: move it alone, by hand, in its POSITIVE direction by 0.3 rad (20 degrees) or more, hold it there, then Enter\n",
                    robot.dof(),
                    joint.name
                ))?;
                let (mut last, mut jump) = (before.clone(), None);
                person.answer(|| {
                    let now = positions(*adapter, motors).map_err(*failed)?;
                    jump = jump.or(jumped(&last, &now));
                    last = now;
                    Ok(())
                })?;
                let held = positions(*adapter, motors).map_err(*failed)?;
                let after = still_positions(*adapter, motors).map_err(*failed)?;
                if let Some(motor) = jump.or(jumped(&last, &held)).or(jumped(&held, &after)) {
                    terminal::print(&format!(
                        "  the position of motor {} jumped by more than half a turn: the end of its range, or its power was off; again\n",
                        motors[motor].id
                    ))?;
                    continue;
                }
                // An arm that is let go after Enter sinks, perhaps to the other side.
                let by_hand = moved(&before, &held, &taken);
                match moved(&before, &after, &taken) {
                    Movement::One(motor, by) if !matches!(by_hand, Movement::One(same, turned) if same == motor && turned * by > 0.0) =>
                    {
                        terminal::print("  the arm moved after Enter: hold it until the next line; again\n")?;
                    }
                    Movement::One(motor, by) => {
                        let mut its = motors[motor];
                        terminal::print(&format!("  motor {} turned by {by:.2} rad\n", its.id))?;
                        let model = model(person, &its, joint)?;
                        [its.position, ..] = model.ranges();
                        taken.push(motor);
                        found.push(FoundDrive { motor: its, model, direction: by.signum(), zero: 0.0 });
                        break;
                    }
                    Movement::None => terminal::print("  no motor moved; again\n")?,
                    Movement::Several(all) => {
                        let ids: Vec<String> = all.iter().map(|motor| motors[*motor].id.to_string()).collect();
                        terminal::print(&format!(
                            "  moved: motors {}; expected one that has no joint yet. Hold the other joints, and again\n",
                            ids.join(", ")
                        ))?;
                    }
                }
            }
        }
        Ok(found)
    }

    /// Asks for a pose that is known, and computes the zeros.
    pub(super) fn zeros(&mut self, found: &mut [FoundDrive]) -> Result<(), Failure> {
        let Self { robot, adapter, failed, person } = self;
        let rest = robot.rest.as_deref();
        let pose = loop {
            let or_rest = if rest.is_some() { ", or its rest pose: r" } else { "" };
            person.forget();
            terminal::print(&format!("Put the arm into a pose that is known. Every joint at 0: z{or_rest}\n"))?;
            match (person.enter()?.as_str(), rest) {
                ("z", _) => break vec![0.0; robot.dof()],
                ("r", Some(rest)) => break rest.to_vec(),
                _ => {}
            }
        };
        let motors: Vec<ShaftMotor> = found.iter().map(|found| found.motor).collect();
        let shafts = still_positions(*adapter, &motors).map_err(*failed)?;
        for (((found, joint), shaft), q) in found.iter_mut().zip(&robot.joints).zip(shafts).zip(pose) {
            // Four digits are finer than a pose by hand.
            found.zero = (1e4 * zero(shaft, found.direction, gear(joint), q)).round() / 1e4;
            if let Some(warning) = power_up_warning(joint, found) {
                terminal::print(&warning)?;
            }
        }
        Ok(())
    }

    /// Asks for the joints' ends, and compares them with the robot file's limits. A contradiction must be confirmed.
    pub(super) fn ends(&mut self, found: &[FoundDrive]) -> Result<(), Failure> {
        let Self { robot, adapter, failed, person } = self;
        person.forget();
        terminal::print("Move every joint to both of its ends, then Enter; or Enter at once to leave this out\n")?;
        let motors: Vec<ShaftMotor> = found.iter().map(|found| found.motor).collect();
        let mut reached = vec![(f64::INFINITY, f64::NEG_INFINITY); found.len()];
        let mut last = positions(*adapter, &motors).map_err(*failed)?;
        person.answer(|| {
            let shafts = positions(*adapter, &motors).map_err(*failed)?;
            if let Some(motor) = jumped(&last, &shafts) {
                return Err(Failure::Target(miette::miette!(
                    help = "its zero may be a turn off now; begin again, with the power on until the end",
                    "motor {}: its position jumped by more than half a turn: the end of its range, or its power was off: nothing was written",
                    motors[motor].id
                )));
            }
            last.clone_from(&shafts);
            for ((((low, high), found), joint), shaft) in reached.iter_mut().zip(found).zip(&robot.joints).zip(shafts) {
                let q = (shaft - found.zero) * found.direction / gear(joint);
                (*low, *high) = (low.min(q), high.max(q));
            }
            Ok(())
        })?;
        let mut is_beyond = false;
        for ((low, high), joint) in reached.iter().zip(&robot.joints) {
            let limits = joint.spec.limits.position;
            if high - low < NEAR {
                continue;
            }
            let beyond = *low < limits.0 - NEAR || *high > limits.1 + NEAR;
            is_beyond |= beyond;
            let comment = if beyond {
                "BEYOND the robot file's limits: wrong zero, direction or limits?"
            } else {
                "within the robot file's limits"
            };
            let unit = units(joint);
            terminal::print(&format!(
                "  {}: from {low:.2} to {high:.2} {unit}; limits {:.2} to {:.2} {unit}: {comment}\n",
                joint.name, limits.0, limits.1
            ))?;
        }
        if is_beyond {
            person.forget();
            terminal::print("Write the file all the same? yes, or Enter to end without it\n")?;
            if person.enter()? != "yes" {
                return Err(Failure::Target(miette::miette!(
                    help = "correct the limits in the robot file, or begin again",
                    "a joint was beyond its limits: nothing was written"
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{Person, Protocol, ShaftMotor, model};
    use robot_compiler::Robot;
    use std::path::Path;
    use std::sync::mpsc::channel;

    /// Else two lines typed at once would confirm a model before its warning can be read.
    #[test]
    fn a_line_typed_before_the_question_for_a_model_is_no_answer() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/rebot_b601_rs.toml");
        let joint = Robot::load(&path).unwrap().joints[0].clone();
        let (kind, ranges) = (Protocol::RobStride, None);
        let (position, torque_limit, power_up_lowest) = (12.57, None, None);
        let motor = ShaftMotor { kind, id: 1, reply_id: 1, position, ranges, torque_limit, power_up_lowest };
        let (typed, lines) = channel();
        ["12.57 50 36 5000 100"; 2].into_iter().for_each(|line| typed.send(line.to_owned()).unwrap());
        drop(typed);
        let ended = model(&Person::of(lines), &motor, &joint).unwrap_err().report().to_string();
        assert!(ended.contains("the input ended"), "{ended}");
    }
}
