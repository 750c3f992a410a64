//! The drives that `motors setup` has found, as tables of the robot file.

use board::can::setup::ShaftMotor;
use robot_compiler::drive::{Actuator, MitSpec, Protocol};
use robot_compiler::{Robot, RobotJoint, actuators};
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, value};

/// Damping of a damped stop for a joint without one, N m s/rad at the shaft: light, so that a first stop is no jerk.
const DAMPING: f64 = 1.0;

/// Keys of the ranges of a drive's frames.
const RANGES: [&str; 5] = ["position", "velocity", "torque", "kp", "kd"];

/// Highest stiffness (N m/rad) and damping (N m s/rad) of the frames of Damiao motors: all have these, and no register says them.
const DAMIAO_GAINS: [f64; 2] = [500.0, 5.0];

/// Ranges of the frames of a drive: the highest position (rad), velocity (rad/s), torque (N m), stiffness (N m/rad) and damping (N m s/rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DriveModel {
    /// Those of an actuator of the table.
    Actuator(&'static Actuator),
    /// Those that the motor or the person says.
    Ranges([f64; 5]),
    /// Those that the robot file has already.
    OfFile([f64; 5]),
}

impl DriveModel {
    /// The model of a motor that says its ranges.
    pub(super) fn said(motor: &ShaftMotor) -> Option<Self> {
        let ([velocity, torque], [kp, kd]) = (motor.ranges?, DAMIAO_GAINS);
        let ranges = [motor.position, velocity, torque, kp, kd];
        let mut all = of_kind(motor.kind).filter(|actuator| is_same_model(&Self::Actuator(actuator).ranges(), &ranges));
        Some(match (all.next(), all.next()) {
            (Some(one), None) => Self::Actuator(one),
            _ => Self::Ranges(ranges),
        })
    }

    /// The model that the robot file has for a joint. `None` if a range is not symmetric: a motor that does not say its ranges has symmetric ones.
    pub(super) fn of_file(joint: &RobotJoint) -> Option<Self> {
        let drive = joint.drive?.mit()?;
        let is_symmetric =
            [drive.position, drive.velocity, drive.torque].iter().all(|(low, high)| is_same(-low, *high));
        is_symmetric.then(|| Self::OfFile(highest(&drive)))
    }

    /// The model that a person typed: the name of an actuator of this kind, or five numbers.
    pub(super) fn typed(text: &str, kind: Protocol) -> Option<Self> {
        if let Some(actuator) = of_kind(kind).find(|actuator| actuator.name.eq_ignore_ascii_case(text)) {
            return Some(Self::Actuator(actuator));
        }
        let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
        let ranges = <[f64; 5]>::try_from(numbers).ok()?;
        ranges.iter().all(|range| range.is_finite() && *range > 0.0).then_some(Self::Ranges(ranges))
    }

    /// Text for the person.
    pub(super) fn text(&self) -> &str {
        match self {
            Self::Actuator(it) => &it.name,
            Self::Ranges(_) => "this model",
            Self::OfFile(_) => "the robot file",
        }
    }

    /// The ranges, in the order of the keys.
    pub(super) fn ranges(&self) -> [f64; 5] {
        match self {
            Self::Actuator(it) => [it.position, it.velocity, it.torque, it.kp, it.kd],
            Self::Ranges(ranges) | Self::OfFile(ranges) => *ranges,
        }
    }
}

/// Actuators of the table with the frames of this kind.
fn of_kind(kind: Protocol) -> impl Iterator<Item = &'static Actuator> {
    actuators().iter().filter(move |actuator| actuator.protocol == kind)
}

/// Names of the actuators of this kind.
pub(super) fn names(kind: Protocol) -> String {
    of_kind(kind).map(|actuator| actuator.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// The drive of a joint: its motor, the ranges of its frames, and the direction and zero (rad) of its shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FoundDrive {
    pub(super) motor: ShaftMotor,
    pub(super) model: DriveModel,
    pub(super) direction: f64,
    pub(super) zero: f64,
}

/// True if two numbers are equal but for the rounding of a register.
pub(super) fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3 * b
}

fn is_same_model(a: &[f64; 5], b: &[f64; 5]) -> bool {
    a.iter().zip(b).all(|(a, b)| is_same(*a, *b))
}

fn highest(drive: &MitSpec) -> [f64; 5] {
    [drive.position, drive.velocity, drive.torque, drive.kp, drive.kd].map(|(_, highest)| highest)
}

/// True if the drive of a joint has the ranges of this model.
pub(super) fn has_ranges_of(model: &DriveModel, joint: &RobotJoint) -> bool {
    let drive = joint.drive.and_then(|drive| drive.mit());
    drive.is_some_and(|drive| is_same_model(&highest(&drive), &model.ranges()))
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
        let FoundDrive { motor, model, direction, zero } = found;
        drive.insert("kind", value(motor.kind.facts().name));
        match model {
            DriveModel::OfFile(_) => {}
            DriveModel::Actuator(actuator) => {
                // Ranges of the file would be used instead of the actuator's.
                for key in RANGES {
                    drive.remove(key);
                }
                drive.insert("actuator", value(actuator.name.clone()));
            }
            DriveModel::Ranges(ranges) => {
                drive.remove("actuator");
                for (key, most) in RANGES.into_iter().zip(ranges) {
                    let least = if ["kp", "kd"].contains(&key) { 0.0 } else { -most };
                    drive.insert(key, value(Array::from_iter([least, *most])));
                }
            }
        }
        drive.insert("bus", value(i64::from(bus)));
        drive.insert("id", value(i64::from(motor.id)));
        // A RobStride motor replies to the host that asks: `host_id`, which has a default.
        if motor.kind == Protocol::Damiao {
            drive.insert("reply_id", value(i64::from(motor.reply_id)));
        }
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
    use super::{DriveModel, FoundDrive, ShaftMotor, has_ranges_of, with_drives};
    use robot_compiler::Robot;
    use robot_compiler::drive::Protocol;
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
            .map(|joint| {
                let [position, velocity, torque] = ranges[usize::from(joint)];
                let motor = ShaftMotor {
                    kind: Protocol::Damiao,
                    id: 6 - joint,
                    reply_id: 22 - u32::from(joint),
                    position,
                    ranges: Some([velocity, torque]),
                    torque_limit: None,
                    power_up_lowest: None,
                };
                FoundDrive {
                    motor,
                    model: DriveModel::said(&motor).unwrap(),
                    direction: if joint == 2 { -1.0 } else { 1.0 },
                    zero: 0.1 * f64::from(joint),
                }
            })
            .collect();
        let written = with_drives(&text, &robot, &found, 1).unwrap();
        let read = Robot::from_toml_str(&written, "written.toml").unwrap();
        for (joint, (before, after)) in robot.joints.iter().zip(&read.joints).enumerate() {
            assert!(has_ranges_of(&found[joint].model, after), "{}", after.name);
            let other = DriveModel::Ranges([12.5, 10.0, 27.0, 500.0, 5.0]);
            assert!(!has_ranges_of(&other, after), "{}", after.name);
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

    #[test]
    fn ranges_of_the_robot_file_are_kept_if_they_are_symmetric() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/rebot_b601_rs.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        let of_first = |text: &str| DriveModel::of_file(&Robot::from_toml_str(text, "arm.toml").unwrap().joints[0]);
        assert_eq!(of_first(&text), Some(DriveModel::OfFile([12.57, 50.0, 36.0, 5000.0, 100.0])));
        for changed_range in ["position = [-6.0, 12.57]", "velocity = [-40.0, 50.0]", "torque = [-36.0, 60.0]"] {
            let changed = text.replacen("\nid = 1\n", &format!("\nid = 1\n{changed_range}\n"), 1);
            assert_eq!(of_first(&changed), None, "{changed_range}");
        }
    }

    #[test]
    fn a_model_is_the_name_of_an_actuator_of_its_kind_or_five_ranges() {
        let typed = |text| DriveModel::typed(text, Protocol::RobStride);
        assert_eq!(typed("rs06").unwrap().text(), "RS06");
        assert_eq!(typed(" 12.57 20  60 5000 100 "), Some(DriveModel::Ranges([12.57, 20.0, 60.0, 5000.0, 100.0])));
        for wrong in ["", "RS03", "DM4310", "12.57 20 60 5000", "12.57 20 0 5000 100", "12.57 20 inf 5000 100"] {
            assert_eq!(typed(wrong), None, "{wrong}");
        }
    }
}
