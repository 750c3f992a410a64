//! Continuous and peak torque of a joint's motor: the table `[joint.heat]`, or the named actuator's.

use super::actuators;
use crate::describe::diagnostics::FileError;
use crate::describe::drive::JointDrive;
use crate::describe::robot::JointHeat;
use crate::read::table::Table;

/// Plausible time constants of motors, s: a winding alone needs seconds, a large housing an hour or two.
const TIME: (f64, f64) = (1.0, 10_000.0);

/// Reads the table `heat` of a joint. A number in the file takes precedence over that of the drive's actuator; without either it is unknown.
pub(super) fn read(joint: &Table<'_>, drive: Option<&JointDrive>) -> Result<JointHeat, FileError> {
    let of_actuator = of_actuator(joint, drive)?;
    let Some(table) = joint.table("heat")? else { return Ok(of_actuator) };
    table.only(&["rated", "peak", "time_constant"])?;
    let torque = |key, expected| table.get(key).map(|value| value.positive(expected)).transpose();
    let rated = torque("rated", "the torque that the joint's motor can give for ever, N m or N, above zero")?;
    let peak = torque("peak", "the torque that the joint's motor can give for a short time, N m or N, above zero")?;
    const EXPECTED: &str = "the time constant of the winding's heat, s, 1 to 10,000";
    let time_constant = table.get("time_constant").map(|value| value.within(TIME.0, TIME.1, EXPECTED)).transpose()?;
    let heat = JointHeat {
        rated: rated.or(of_actuator.rated),
        peak: peak.or(of_actuator.peak),
        time_constant: time_constant.or(of_actuator.time_constant),
    };
    if let (Some(rated), Some(peak)) = (heat.rated, heat.peak)
        && peak < rated
    {
        let key = if table.get("peak").is_some() { "peak" } else { "rated" };
        let problem = format!("the motor would give {peak} for a short time and {rated} for ever; exchanged?");
        return Err(table.error(key, problem, "`peak` no less than `rated`"));
    }
    Ok(heat)
}

/// The numbers of the named actuator, converted through the gear.
fn of_actuator(joint: &Table<'_>, drive: Option<&JointDrive>) -> Result<JointHeat, FileError> {
    let (Some(table), Some(spec)) = (joint.table("drive")?, drive.and_then(JointDrive::mit)) else {
        return Ok(JointHeat::default());
    };
    let Some(name) = table.get("actuator") else { return Ok(JointHeat::default()) };
    let name = name.string("an actuator's name")?;
    let found = actuators::all().iter().find(|actuator| actuator.name == name && actuator.protocol == spec.protocol);
    Ok(found.map_or(JointHeat::default(), |actuator| JointHeat {
        rated: actuator.rated.map(|torque| torque * spec.ratio.abs()),
        peak: actuator.peak.map(|torque| torque * spec.ratio.abs()),
        time_constant: actuator.time_constant,
    }))
}
