//! The drives that `motors setup` has found, as tables of the robot file.

use board::can::setup::ShaftMotor;
use robot_compiler::drive::{Actuator, Protocol};
use robot_compiler::{Robot, RobotJoint, actuators};
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, value};

/// Damping of a damped stop for a joint without one, N m s/rad at the shaft: light, so that a first stop is no jerk.
const DAMPING: f64 = 1.0;

/// Keys of the ranges of a drive's frames.
const RANGES: [&str; 5] = ["position", "velocity", "torque", "kp", "kd"];

/// The drive of a joint: its motor, and the direction and zero (rad) of its shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FoundDrive {
    pub(super) motor: ShaftMotor,
    pub(super) direction: f64,
    pub(super) zero: f64,
}

/// True if two ranges are equal but for the rounding of a register.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3 * b
}

/// True if the drive of a joint has the ranges of this motor.
pub(super) fn has_ranges_of(motor: &ShaftMotor, joint: &RobotJoint) -> bool {
    let drive = joint.drive.and_then(|drive| drive.mit());
    let ranges = drive.map(|drive| [drive.position.1, drive.velocity.1, drive.torque.1]);
    ranges.is_some_and(|ranges| ranges.iter().zip(motor.ranges).all(|(a, b)| is_same(*a, b)))
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
pub(super) fn with_drives(text: &str, robot: &Robot, found: &[FoundDrive], bus: u8) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    let joints = document.get_mut("joint").and_then(Item::as_array_of_tables_mut);
    let joints = joints.ok_or("expected its joints as tables, [[joint]]")?;
    for ((table, joint), found) in joints.iter_mut().zip(&robot.joints).zip(found) {
        let drive = table.entry("drive").or_insert_with(|| Item::Table(Table::new()));
        let drive: &mut dyn TableLike =
            drive.as_table_like_mut().ok_or_else(|| format!("joint {}: drive is no table", joint.name))?;
        let FoundDrive { motor, direction, zero } = found;
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
    use super::{FoundDrive, ShaftMotor, with_drives};
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
            .map(|joint| FoundDrive {
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
