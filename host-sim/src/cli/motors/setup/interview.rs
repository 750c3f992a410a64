//! Interview of the person who moves the arm by hand: the motor and direction of each joint, its zero, and its ends.

use super::drive_tables::FoundDrive;
use board::can::adapter::Adapter;
use board::can::setup::{Movement, ShaftMotor, moved, positions, still_positions, zero};
use dynamics_core::JointKind;
use firmware_image::process::line_channel;
use robot_compiler::{Robot, RobotJoint};
use sim::failure::Failure;
use sim::terminal;
use std::io::{self, BufReader};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// Interval at which the joints are read while a person moves them to their ends.
const LOOK: Duration = Duration::from_millis(20);

/// A range that was reached, against the robot file's: a difference below this, rad or m, is not worth a message.
const NEAR: f64 = 0.05;

/// Lines of a person.
struct Person(Receiver<String>);

impl Person {
    fn new() -> Self {
        Self(line_channel(BufReader::new(io::stdin())))
    }

    /// The next line; meanwhile, `look` is called every 20 ms.
    fn answer(&self, mut look: impl FnMut() -> Result<(), Failure>) -> Result<String, Failure> {
        loop {
            match self.0.recv_timeout(LOOK) {
                Ok(line) => return Ok(line.trim().to_owned()),
                Err(RecvTimeoutError::Timeout) => look()?,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Failure::Input(miette::miette!(
                        "the input ended before the setup was complete: nothing was written"
                    )));
                }
            }
        }
    }

    fn enter(&self) -> Result<String, Failure> {
        self.answer(|| Ok(()))
    }
}

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
                terminal::print(&format!(
                    "joint {number} of {}, {}: move it alone, by hand, in its POSITIVE direction by 0.3 rad (20 degrees) or more, hold it there, then Enter\n",
                    robot.dof(),
                    joint.name
                ))?;
                person.enter()?;
                match moved(&before, &still_positions(*adapter, motors).map_err(*failed)?, &taken) {
                    Movement::One(motor, by) => {
                        terminal::print(&format!("  motor {} turned by {by:.2} rad\n", motors[motor].id))?;
                        taken.push(motor);
                        found.push(FoundDrive { motor: motors[motor], direction: by.signum(), zero: 0.0 });
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
        }
        Ok(())
    }

    /// Asks for the joints' ends, and compares them with the robot file's limits.
    pub(super) fn ends(&mut self, found: &[FoundDrive]) -> Result<(), Failure> {
        let Self { robot, adapter, failed, person } = self;
        terminal::print("Move every joint to both of its ends, then Enter; or Enter at once to leave this out\n")?;
        let motors: Vec<ShaftMotor> = found.iter().map(|found| found.motor).collect();
        let mut reached = vec![(f64::INFINITY, f64::NEG_INFINITY); found.len()];
        person.answer(|| {
            let shafts = positions(*adapter, &motors).map_err(*failed)?;
            for ((((low, high), found), joint), shaft) in reached.iter_mut().zip(found).zip(&robot.joints).zip(shafts) {
                let q = (shaft - found.zero) * found.direction / gear(joint);
                (*low, *high) = (low.min(q), high.max(q));
            }
            Ok(())
        })?;
        for ((low, high), joint) in reached.iter().zip(&robot.joints) {
            let limits = joint.spec.limits.position;
            if high - low < NEAR {
                continue;
            }
            let beyond = *low < limits.0 - NEAR || *high > limits.1 + NEAR;
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
        Ok(())
    }
}
