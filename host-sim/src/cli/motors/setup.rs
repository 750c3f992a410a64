//! `motors setup`: a person moves each joint by hand, and the robot file gets its drives.

use crate::cli::force::ForceArgs;
use board::can::adapter::Adapter;
use board::can::setup::{Movement, ShaftMotor, motors, moved, positions, still_positions, zero};
use clap::Args;
use dynamics_core::JointKind;
use robot_compiler::drive::{Actuator, Protocol};
use robot_compiler::{Robot, RobotJoint, actuators};
use sim::failure::Failure;
use sim::terminal;
use std::fmt::Write as _;
use std::io::{self, BufRead as _};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, value};

/// Interval at which the joints are read while a person moves them to their ends.
const LOOK: Duration = Duration::from_millis(20);

/// Damping of a damped stop for a joint without one, N m s/rad at the shaft: light, so that a first stop is no jerk.
const DAMPING: f64 = 1.0;

/// A range that was reached, against the robot file's: a difference below this, rad or m, is not worth a message.
const NEAR: f64 = 0.05;

/// Keys of the ranges of a drive's frames.
const RANGES: [&str; 5] = ["position", "velocity", "torque", "kp", "kd"];

/// Options of `motors setup`.
#[derive(Clone, Debug, Args)]
pub struct SetupArgs {
    /// The robot file (TOML), with its joints, base first.
    pub robot: PathBuf,
    /// The file that is written: the robot file with its drives.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// The bus of these motors, 1 to 3.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=3))]
    pub bus: u8,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Findings about a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    motor: ShaftMotor,
    direction: f64,
    zero: f64,
}

/// Lines of a person.
struct Person(Receiver<String>);

impl Person {
    fn new() -> Self {
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            io::stdin().lock().lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Self(lines)
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

/// Walks through the joints, and writes the robot file. Returns the message at the end.
///
/// # Errors
/// A wrong robot file; an adapter that is gone; motors that are silent or on; a file that cannot be written.
pub fn run(
    args: &SetupArgs,
    adapter: &mut dyn Adapter,
    failed: impl Fn(io::Error) -> Failure,
) -> Result<String, Failure> {
    let place = args.robot.display();
    if args.robot.extension().is_some_and(|extension| extension == "urdf") {
        return Err(Failure::Input(miette::miette!(
            help = "newtau import ARM.urdf --out ARM.toml",
            "{place}: expected a robot file in TOML"
        )));
    }
    let robot = Robot::load(&args.robot).map_err(Failure::input)?;
    // An error here is better before the work than after it. It is checked again when the file is written.
    args.force.output().reads(&args.robot).file(&args.out)?;
    let mut output = args.force.output().reads(&args.robot);
    if let Some(joint) =
        robot.joints.iter().find(|joint| joint.spec.kind == JointKind::Prismatic && joint.drive.is_none())
    {
        return Err(Failure::Input(miette::miette!(
            help = "write its drive by hand, with `gear` in shaft rad per m",
            "{place}: joint {} slides; setup finds drives of joints that turn",
            joint.name
        )));
    }
    if let Some(other) = robot.joints.iter().find_map(|joint| joint.drive.filter(|drive| drive.kind() != "damiao")) {
        return Err(Failure::Input(miette::miette!(
            "{place}: found drives of the kind {}; setup can read the positions of damiao motors only",
            other.kind()
        )));
    }
    let motors = motors(adapter).map_err(&failed)?;
    if motors.len() < robot.dof() {
        return Err(Failure::Target(miette::miette!(
            help =
                "newtau motors scan; power, wiring, and an identifier of its own for each motor (newtau motors set-id)",
            "{} motors answer, and {place} has {} joints",
            motors.len(),
            robot.dof()
        )));
    }
    let person = Person::new();
    let names: Vec<String> = motors.iter().map(|motor| motor.id.to_string()).collect();
    terminal::print(&format!(
        "Motors {}. None has torque, and none gets any here: SUPPORT THE ARM, it hangs free.\n",
        names.join(", ")
    ))?;
    let mut found = joints(&robot, adapter, &motors, &person, &failed)?;
    zeros(&robot, adapter, &mut found, &person, &failed)?;
    ends(&robot, adapter, &found, &person, &failed)?;
    let text =
        std::fs::read_to_string(&args.robot).map_err(|error| Failure::input(miette::miette!("{place}: {error}")))?;
    let written = with_drives(&text, &robot, &found, args.bus)
        .map_err(|why| Failure::Input(miette::miette!("{place}: {why}")))?;
    let mut summary = String::new();
    for (joint, Found { motor, direction, zero }) in robot.joints.iter().zip(&found) {
        let _ = writeln!(summary, "{}: motor {}, direction {direction}, zero {zero:.4} rad", joint.name, motor.id);
    }
    // Before anything can fail: this was found by hand.
    terminal::print(&summary)?;
    // What the reader would not accept is not written.
    let read = Robot::from_toml_str(&written, &args.out.display().to_string()).map_err(Failure::input)?;
    for (joint, found) in read.joints.iter().zip(&found) {
        let ranges =
            joint.drive.and_then(|drive| drive.mit()).map(|drive| [drive.position.1, drive.velocity.1, drive.torque.1]);
        if !ranges.is_some_and(|ranges| ranges.iter().zip(found.motor.ranges).all(|(a, b)| is_same(*a, b))) {
            return Err(Failure::Input(miette::miette!(
                "joint {}: its ranges would not be those of motor {}: nothing was written",
                joint.name,
                found.motor.id
            )));
        }
    }
    output.write(&args.out, &written)?;
    output.finish()?;
    Ok(format!(
        "files: {}\nNext: newtau check {0}; then compare positions with `newtau drive`, before torque acts\n",
        args.out.display()
    ))
}

/// Asks for each joint's movement.
fn joints(
    robot: &Robot,
    adapter: &mut dyn Adapter,
    motors: &[ShaftMotor],
    person: &Person,
    failed: &impl Fn(io::Error) -> Failure,
) -> Result<Vec<Found>, Failure> {
    let (mut found, mut taken) = (Vec::new(), Vec::new());
    for (number, joint) in (1..).zip(&robot.joints) {
        loop {
            let before = still_positions(adapter, motors).map_err(failed)?;
            terminal::print(&format!(
                "joint {number} of {}, {}: move it alone, by hand, in its POSITIVE direction by 0.3 rad (20 degrees) or more, hold it there, then Enter\n",
                robot.dof(),
                joint.name
            ))?;
            person.enter()?;
            match moved(&before, &still_positions(adapter, motors).map_err(failed)?, &taken) {
                Movement::One(motor, by) => {
                    terminal::print(&format!("  motor {} turned by {by:.2} rad\n", motors[motor].id))?;
                    taken.push(motor);
                    found.push(Found { motor: motors[motor], direction: by.signum(), zero: 0.0 });
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
fn zeros(
    robot: &Robot,
    adapter: &mut dyn Adapter,
    found: &mut [Found],
    person: &Person,
    failed: &impl Fn(io::Error) -> Failure,
) -> Result<(), Failure> {
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
    let shafts = still_positions(adapter, &motors).map_err(failed)?;
    for (((found, joint), shaft), q) in found.iter_mut().zip(&robot.joints).zip(shafts).zip(pose) {
        // Four digits are finer than a pose by hand.
        found.zero = (1e4 * zero(shaft, found.direction, gear(joint), q)).round() / 1e4;
    }
    Ok(())
}

/// Asks for the joints' ends, and compares them with the robot file's limits.
fn ends(
    robot: &Robot,
    adapter: &mut dyn Adapter,
    found: &[Found],
    person: &Person,
    failed: &impl Fn(io::Error) -> Failure,
) -> Result<(), Failure> {
    terminal::print("Move every joint to both of its ends, then Enter; or Enter at once to leave this out\n")?;
    let motors: Vec<ShaftMotor> = found.iter().map(|found| found.motor).collect();
    let mut reached = vec![(f64::INFINITY, f64::NEG_INFINITY); found.len()];
    person.answer(|| {
        let shafts = positions(adapter, &motors).map_err(failed)?;
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

/// True if two ranges are equal but for the rounding of a register.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3 * b
}

/// The actuator with these ranges, if exactly one has them.
fn actuator(motor: &ShaftMotor) -> Option<&'static Actuator> {
    let mut all = actuators().iter().filter(|actuator| {
        let [position, velocity, torque] = motor.ranges;
        actuator.protocol == Protocol::Damiao
            && is_same(position, actuator.position)
            && is_same(velocity, actuator.velocity)
            && is_same(torque, actuator.torque)
    });
    match (all.next(), all.next()) {
        (Some(one), None) => Some(one),
        _ => None,
    }
}

/// The text of a robot file with these drives. Other keys and comments stay.
fn with_drives(text: &str, robot: &Robot, found: &[Found], bus: u8) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    let joints = document.get_mut("joint").and_then(Item::as_array_of_tables_mut);
    let joints = joints.ok_or("expected its joints as tables, [[joint]]")?;
    for ((table, joint), found) in joints.iter_mut().zip(&robot.joints).zip(found) {
        let drive = table.entry("drive").or_insert_with(|| Item::Table(Table::new()));
        let drive: &mut dyn TableLike =
            drive.as_table_like_mut().ok_or_else(|| format!("joint {}: drive is no table", joint.name))?;
        let Found { motor, direction, zero } = found;
        drive.insert("kind", value("damiao"));
        match actuator(motor) {
            Some(actuator) => {
                // Ranges of the file would be used instead of the actuator's.
                for key in RANGES {
                    drive.remove(key);
                }
                drive.insert("actuator", value(actuator.name.clone()));
            }
            // The ranges that the motor itself reports. Those of stiffness and damping are in no register: all Damiao motors have these.
            None => {
                drive.remove("actuator");
                let both = |most: f64| value(Array::from_iter([-most, most]));
                for (key, most) in ["position", "velocity", "torque"].into_iter().zip(motor.ranges) {
                    drive.insert(key, both(most));
                }
                drive.insert("kp", value(Array::from_iter([0.0, 500.0])));
                drive.insert("kd", value(Array::from_iter([0.0, 5.0])));
            }
        }
        drive.insert("bus", value(i64::from(bus)));
        drive.insert("id", value(i64::from(motor.id)));
        drive.insert("reply_id", value(i64::from(motor.reply_id)));
        drive.insert("direction", value(*direction as i64));
        drive.insert("zero", value(*zero));
        if drive.get("damping").is_none() {
            drive.insert("damping", value(DAMPING));
        }
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{Found, ShaftMotor, with_drives};
    use robot_compiler::Robot;
    use std::path::Path;

    #[test]
    fn drives_are_added_or_changed_and_everything_else_stays() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/yam.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        let robot = Robot::load(&path).unwrap();
        let ranges = [
            [12.5, 10.0, 28.0],
            [12.5, 10.0, 28.0],
            [12.5, 10.0, 28.0],
            [12.5, 30.0, 10.0],
            [12.5, 30.0, 10.0],
            [12.5, 33.0, 11.0],
        ];
        let found: Vec<_> = (0..6_u8)
            .map(|joint| Found {
                motor: ShaftMotor {
                    id: 6 - joint,
                    reply_id: 22 - u32::from(joint),
                    ranges: ranges[usize::from(joint)],
                },
                direction: if joint == 2 { -1.0 } else { 1.0 },
                zero: 0.1 * f64::from(joint),
            })
            .collect();
        let written = with_drives(&text, &robot, &found, 1).unwrap();
        let read = Robot::from_toml_str(&written, "written.toml").unwrap();
        for (joint, (before, after)) in robot.joints.iter().zip(&read.joints).enumerate() {
            assert_eq!((&before.name, &before.spec), (&after.name, &after.spec));
            let (before, after) = (before.drive.unwrap().mit().unwrap(), after.drive.unwrap().mit().unwrap());
            assert_eq!((usize::from(after.id), usize::from(after.reply_id)), (6 - joint, 22 - joint));
            assert_eq!(after.damping.to_bits(), before.damping.to_bits(), "what setup does not know stays");
            assert!((after.zero - 0.1 * joint as f64).abs() < 1e-12);
        }
        // Ranges of no known motor are written themselves.
        assert!(written.contains("torque = [-11.0, 11.0]") && written.contains("actuator = \"DM4310\""), "{written}");
        let comments = |text: &str| text.lines().filter(|line| line.starts_with('#')).count();
        assert_eq!(comments(&written), comments(&text));
        assert!(with_drives("joint = 3", &robot, &found, 1).unwrap_err().contains("[[joint]]"));
    }
}
