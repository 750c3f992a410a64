//! Drives of an arm that share buses: numbers that must agree, and replies that one drive would take for another's.

use crate::describe::diagnostics::FileError;
use crate::describe::drive::{JointDrive, MitSpec};
use crate::describe::robot::{Robot, RobotJoint};
use crate::read::table::Table;
use dynamics_core::drive::DriveFacts;
use dynamics_core::drive::bus_time::Identifier;

/// Checks the drives of all joints together: all or none, of one kind, distinct on their buses.
pub(super) fn check(joints: &[RobotJoint], tables: &[Table<'_>]) -> Result<(), FileError> {
    let Some((first, kind)) = joints.iter().find_map(|joint| Some((joint, joint.drive?.kind()))) else { return Ok(()) };
    for (index, (joint, table)) in joints.iter().zip(tables).enumerate() {
        let Some(drive) = joint.drive else {
            let problem = format!("missing, while {:?} has one", first.name);
            return Err(table.error("drive", problem, "a drive for every joint, or for none"));
        };
        if drive.kind() != kind {
            let problem = format!("of the kind {}, while {:?} has one of the kind {kind}", drive.kind(), first.name);
            return Err(table.error("drive", problem, "drives of one kind"));
        }
        let before = joints.iter().take(index).filter_map(|other| Some((&other.name, other.drive?)));
        match drive {
            JointDrive::Mit(spec) => {
                let beside: Vec<_> =
                    before.filter(|(_, other)| matches!(other, JointDrive::Mit(o) if o.bus == spec.bus)).collect();
                if let Some((name, _)) =
                    beside.iter().find(|(_, other)| matches!(other, JointDrive::Mit(o) if o.id == spec.id))
                {
                    let problem = format!("identifier {} on bus {} is that of {name:?}", spec.id, spec.bus);
                    return Err(table.error("drive", problem, "an identifier of its own on the bus"));
                }
                if let Some((name, _)) = beside
                    .iter()
                    .find(|(_, other)| matches!(other, JointDrive::Mit(o) if o.data_rate != spec.data_rate))
                {
                    let problem = format!("another `data_rate` than {name:?}, on bus {}", spec.bus);
                    return Err(table.error("drive", problem, "one `data_rate` on a bus, or classic frames alone"));
                }
                let on_bus = |id: u16| {
                    joints.iter().any(|other| matches!(other.drive, Some(JointDrive::Mit(o)) if o.bus == spec.bus && u16::from(o.id) == id))
                };
                if let Some(other) = mistaken(&spec, &beside) {
                    return Err(other.error(table));
                }
                if on_bus(spec.reply_id) {
                    let (id, bus) = (spec.reply_id, spec.bus);
                    let problem = match spec.protocol.facts().identifier {
                        Identifier::Standard => {
                            format!("replies with identifier {id}, which is a command's on bus {bus}")
                        }
                        // Its frames carry their type, but a request for a parameter and the answer have the same type.
                        Identifier::Extended => format!("host identifier {id} is that of a drive on bus {bus}"),
                    };
                    return Err(table.error("drive", problem, "an identifier for replies that no command has"));
                }
            }
            JointDrive::Pwm(spec) => {
                let mut before = before;
                if let Some((name, _)) =
                    before.find(|(_, other)| matches!(other, JointDrive::Pwm(o) if o.channel == spec.channel))
                {
                    let problem = format!("channel {} is that of {name:?}", spec.channel);
                    return Err(table.error("drive", problem, "a channel of its own"));
                }
            }
        }
    }
    Ok(())
}

/// The first conflict between the CAN drives of an arm if all are on one bus, whatever their bus in the robot file; `None` if there is none.
#[must_use]
pub fn conflict_on_one_bus(robot: &Robot) -> Option<String> {
    let drives: Vec<(&String, MitSpec)> = robot
        .joints
        .iter()
        .filter_map(|joint| Some((&joint.name, MitSpec { bus: 1, ..joint.drive?.mit()? })))
        .collect();
    drives.iter().enumerate().find_map(|(index, (name, spec))| {
        let before: Vec<_> = drives.iter().take(index).map(|(name, spec)| (*name, JointDrive::Mit(*spec))).collect();
        let same = drives.iter().take(index).find(|(_, other)| other.id == spec.id);
        let command = drives.iter().find(|(_, other)| u16::from(other.id) == spec.reply_id);
        if let Some((other, _)) = same {
            return Some(format!("the drives of {other:?} and {name:?} both have identifier {}", spec.id));
        }
        if let Some((other, _)) = command {
            return Some(format!(
                "the drive of {name:?} replies with identifier {}, which is that of commands to {other:?}",
                spec.reply_id
            ));
        }
        mistaken(spec, &before).map(|it| format!("the drive of {name:?} {}", it.problem))
    })
}

/// A conflict: one drive of a bus would accept a frame that is meant for, or sent by, another.
pub(super) struct Mistaken {
    pub(super) problem: String,
    pub(super) expected: String,
}

impl Mistaken {
    pub(super) fn error(self, table: &Table<'_>) -> FileError {
        table.error("drive", self.problem, self.expected)
    }
}

/// The conflict between this drive and an earlier one on the bus, if one of them would accept the other's frames.
///
/// If replies carry the whole identifier of their drive, distinct identifiers are enough.
pub(super) fn mistaken(spec: &MitSpec, beside: &[(&String, JointDrive)]) -> Option<Mistaken> {
    let DriveFacts { name: kind, reply_id_bits, other_modes, settings_id, .. } = spec.protocol.facts();
    if settings_id == Some(spec.reply_id) {
        return Some(Mistaken {
            problem: format!(
                "replies with identifier {}, with which the settings of {kind} drives are written",
                spec.reply_id
            ),
            expected: "another identifier for replies, such as that of the commands + 16".to_owned(),
        });
    }
    beside.iter().filter_map(|(name, other)| Some((name, other.mit()?))).find_map(|(name, other)| {
        let low = |id: u8| u32::from(id) & ((1 << reply_id_bits) - 1);
        if reply_id_bits < u8::BITS && other.reply_id == spec.reply_id && low(other.id) == low(spec.id) {
            let problem = format!(
                "identifiers {} and {} (of {name:?}) on bus {} both end in {}, and both drives reply with identifier {}: a {kind} reply \
                 carries the low {reply_id_bits} bits of the identifier alone",
                spec.id, other.id, spec.bus, low(spec.id), spec.reply_id
            );
            let expected = "a `reply_id` for each drive, such as its identifier + 16, or identifiers that differ in these bits";
            return Some(Mistaken { problem, expected: expected.to_owned() });
        }
        let command = |by: &MitSpec, of: &MitSpec| other_modes.iter().any(|mode| u16::from(of.id) + mode == by.reply_id);
        (command(spec, &other) || command(&other, spec)).then(|| Mistaken {
            problem: format!(
                "replies of one of {} and {} (of {name:?}) on bus {} are commands of another mode for the other: these have its \
                 identifier + 256, + 512 or + 768",
                spec.id, other.id, spec.bus
            ),
            expected: "identifiers for replies below 256, such as those of the commands + 16".to_owned(),
        })
    })
}
