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
    let can: Vec<_> = joints.iter().filter_map(|joint| Some((&joint.name, joint.drive?.mit()?))).collect();
    for (index, (joint, table)) in joints.iter().zip(tables).enumerate() {
        let Some(drive) = joint.drive else {
            let problem = format!("missing, while {:?} has one", first.name);
            return Err(table.error("drive", problem, "a drive for every joint, or for none"));
        };
        if drive.kind() != kind {
            let problem = format!("of the kind {}, while {:?} has one of the kind {kind}", drive.kind(), first.name);
            return Err(table.error("drive", problem, "drives of one kind"));
        }
        match drive {
            // All joints before this one have a drive on CAN, too, so that its index is the same.
            JointDrive::Mit(spec) => {
                if let Some(Conflict { problem, expected }) = conflict(&can, index, &format!("bus {}", spec.bus)) {
                    return Err(table.error("drive", problem, expected));
                }
            }
            JointDrive::Pwm(spec) => {
                let mut before = joints.iter().take(index);
                let same = |other: &JointDrive| matches!(other, JointDrive::Pwm(o) if o.channel == spec.channel);
                if let Some(other) = before.find(|other| other.drive.as_ref().is_some_and(same)) {
                    let problem = format!("channel {} is that of {:?}", spec.channel, other.name);
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
    let on_one_bus = |joint: &RobotJoint| Some(MitSpec { bus: 1, ..joint.drive?.mit()? });
    let drives: Vec<_> = robot.joints.iter().filter_map(|joint| Some((&joint.name, on_one_bus(joint)?))).collect();
    drives.iter().enumerate().find_map(|(index, (name, _))| {
        conflict(&drives, index, "one bus").map(|Conflict { problem, .. }| format!("the drive of {name:?}: {problem}"))
    })
}

/// A conflict: one drive of a bus would accept a frame that is meant for, or sent by, another.
struct Conflict {
    problem: String,
    expected: &'static str,
}

/// The conflict of a drive, by its index, with others on its bus, which the message calls `place`.
fn conflict(drives: &[(&String, MitSpec)], index: usize, place: &str) -> Option<Conflict> {
    let (_, spec) = drives.get(index)?;
    let on_bus = |(_, other): &&(&String, MitSpec)| other.bus == spec.bus;
    let before: Vec<_> = drives.iter().take(index).filter(on_bus).copied().collect();
    if let Some((name, _)) = before.iter().find(|(_, other)| other.id == spec.id) {
        let problem = format!("identifier {} on {place} is that of {name:?}", spec.id);
        return Some(Conflict { problem, expected: "an identifier of its own on the bus" });
    }
    if let Some((name, _)) = before.iter().find(|(_, other)| other.data_rate != spec.data_rate) {
        let problem = format!("another `data_rate` than {name:?}, on {place}");
        return Some(Conflict { problem, expected: "one `data_rate` on a bus, or classic frames alone" });
    }
    if let Some(conflict) = mistaken(spec, &before, place) {
        return Some(conflict);
    }
    drives.iter().filter(on_bus).find(|(_, other)| u16::from(other.id) == spec.reply_id)?;
    let id = spec.reply_id;
    let problem = match spec.protocol.facts().identifier {
        Identifier::Standard => format!("replies with identifier {id}, which is a command's on {place}"),
        // Its frames carry their type, but a request for a parameter and the answer have the same type.
        Identifier::Extended => format!("host identifier {id} is that of a drive on {place}"),
    };
    Some(Conflict { problem, expected: "an identifier for replies that no command has" })
}

/// The conflict between this drive and an earlier one on the bus, if one of them would accept the other's frames.
///
/// If replies carry the whole identifier of their drive, distinct identifiers are enough.
fn mistaken(spec: &MitSpec, before: &[(&String, MitSpec)], place: &str) -> Option<Conflict> {
    let DriveFacts { name: kind, reply_id_bits, other_modes, settings_id, .. } = spec.protocol.facts();
    if settings_id == Some(spec.reply_id) {
        return Some(Conflict {
            problem: format!(
                "replies with identifier {}, with which the settings of {kind} drives are written",
                spec.reply_id
            ),
            expected: "another identifier for replies, such as that of the commands + 16",
        });
    }
    before.iter().find_map(|(name, other)| {
        let low = |id: u8| u32::from(id) & ((1 << reply_id_bits) - 1);
        if reply_id_bits < u8::BITS && other.reply_id == spec.reply_id && low(other.id) == low(spec.id) {
            let problem = format!(
                "identifiers {} and {} (of {name:?}) on {place} both end in {}, and both drives reply with identifier {}: a {kind} reply \
                 carries the low {reply_id_bits} bits of the identifier alone",
                spec.id, other.id, low(spec.id), spec.reply_id
            );
            let expected = "a `reply_id` for each drive, such as its identifier + 16, or identifiers that differ in these bits";
            return Some(Conflict { problem, expected });
        }
        let command = |by: &MitSpec, of: &MitSpec| other_modes.iter().any(|mode| u16::from(of.id) + mode == by.reply_id);
        (command(spec, other) || command(other, spec)).then(|| Conflict {
            problem: format!(
                "replies of one of {} and {} (of {name:?}) on {place} are commands of another mode for the other: these have its \
                 identifier + 256, + 512 or + 768",
                spec.id, other.id
            ),
            expected: "identifiers for replies below 256, such as those of the commands + 16",
        })
    })
}
