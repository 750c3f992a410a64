//! Friction of joints: one in a robot file, or all of them in a simulated world.

use super::scene::values::per_joint;
use super::table::{Table, Value};
use crate::describe::diagnostics::FileError;
use crate::describe::friction::{Breakaway, JointFriction};
use crate::describe::robot::Robot;

const KEYS: [&str; 8] =
    ["viscous", "coulomb", "coulomb_load", "breakaway", "stribeck_speed", "breakaway_load", "asymmetry", "offset"];

/// Friction of one joint; a missing key means an absent term.
pub(super) fn of_joint(table: &Table<'_>) -> Result<JointFriction, FileError> {
    let read = |value: &Value<'_>, one: &dyn Fn(&Value<'_>) -> Result<f64, FileError>, _: &str| Ok(vec![one(value)?]);
    let mut friction = [JointFriction::default()];
    change(table, &mut friction, &read, &|_| String::new())?;
    let [friction] = friction;
    Ok(friction)
}

/// Friction of every simulated joint, as one number or one per joint; for a missing key the robot file's value is used.
pub(super) fn of_joints(table: &Table<'_>, robot: &Robot) -> Result<Vec<JointFriction>, FileError> {
    let mut friction: Vec<JointFriction> =
        robot.joints.iter().map(|joint| joint.friction.unwrap_or_default()).collect();
    let read = |value: &Value<'_>, one: &dyn Fn(&Value<'_>) -> Result<f64, FileError>, what: &str| {
        per_joint(value, robot, what, one)
    };
    let label = |index: usize| format!(" of {}", Robot::joint_label(index, &robot.joints[index].name));
    change(table, &mut friction, &read, &label)?;
    Ok(friction)
}

type One<'a> = &'a dyn Fn(&Value<'_>) -> Result<f64, FileError>;
/// Reads a value as one number or one per joint.
type FrictionValue<'a> = &'a dyn Fn(&Value<'_>, One<'_>, &str) -> Result<Vec<f64>, FileError>;

/// Changes the friction by the values in the table, and checks the result.
fn change(
    table: &Table<'_>,
    friction: &mut [JointFriction],
    read: FrictionValue<'_>,
    label: &dyn Fn(usize) -> String,
) -> Result<(), FileError> {
    const VISCOUS: &str = "a viscous coefficient of zero or more, N m s/rad or N s/m";
    const LEVEL: &str = "a torque (N m) or force (N) of zero or more";
    const SIGNED: &str = "a finite torque (N m) or force (N)";
    const SPEED: &str = "a Stribeck velocity in rad/s or m/s, 5e-3 or more";
    const LOAD: &str = "a share of the actuator's torque, 0 to 0.5";
    table.only(&KEYS)?;
    let list = |key: &str, what: &str, one: One<'_>| table.get(key).map(|value| read(&value, one, what)).transpose();
    let not_negative = |what: &'static str| move |value: &Value<'_>| value.not_negative(what);
    let share = |value: &Value<'_>| value.within(0.0, 0.5, LOAD);
    let signed = |value: &Value<'_>| value.finite(SIGNED);
    let viscous = list("viscous", VISCOUS, &not_negative(VISCOUS))?;
    let coulomb = list("coulomb", LEVEL, &not_negative(LEVEL))?;
    let coulomb_load = list("coulomb_load", LOAD, &share)?;
    let breakaway = list("breakaway", LEVEL, &not_negative(LEVEL))?;
    let speed = list("stribeck_speed", SPEED, &|value| value.at_least(5e-3, SPEED))?;
    let breakaway_load = list("breakaway_load", LOAD, &share)?;
    let asymmetry = list("asymmetry", SIGNED, &signed)?;
    let offset = list("offset", SIGNED, &signed)?;
    for (index, friction) in friction.iter_mut().enumerate() {
        let at = |list: &Option<Vec<f64>>| list.as_ref().and_then(|list| list.get(index)).copied();
        friction.viscous = at(&viscous).unwrap_or(friction.viscous);
        friction.coulomb = at(&coulomb).unwrap_or(friction.coulomb);
        friction.coulomb_load = at(&coulomb_load).unwrap_or(friction.coulomb_load);
        friction.asymmetry = at(&asymmetry).unwrap_or(friction.asymmetry);
        friction.offset = at(&offset).unwrap_or(friction.offset);
        let before = friction.breakaway;
        friction.breakaway = match at(&breakaway).or(before.map(|it| it.torque)) {
            None => None,
            Some(torque) => {
                let Some(speed) = at(&speed).or(before.map(|it| it.speed)) else {
                    return Err(table.error("stribeck_speed", "missing beside `breakaway`", SPEED));
                };
                // A load raises both levels equally unless the file gives otherwise.
                let load = at(&breakaway_load).or(before.map(|it| it.load)).unwrap_or(friction.coulomb_load);
                Some(Breakaway { torque, speed, load })
            }
        };
        check(table, friction, &label(index))?;
    }
    Ok(())
}

/// Rejects impossible levels: a breakaway below Coulomb's, or parts that would drive a joint.
fn check(table: &Table<'_>, friction: &JointFriction, label: &str) -> Result<(), FileError> {
    let JointFriction { coulomb, asymmetry, offset, .. } = *friction;
    match friction.breakaway {
        None => {
            if let Some(key) = ["stribeck_speed", "breakaway_load"].into_iter().find(|key| table.get(key).is_some()) {
                let expected = "`breakaway`, the friction that a motion starts against";
                return Err(table.error(key, "given without `breakaway`", expected));
            }
        }
        Some(Breakaway { torque, .. }) if torque < coulomb => {
            let problem = format!("{torque} is below the Coulomb friction{label}");
            return Err(table.error("breakaway", problem, format!("{coulomb} or more")));
        }
        Some(_) => {}
    }
    for (key, part) in [("asymmetry", asymmetry), ("offset", offset)] {
        if part.abs() > coulomb {
            let problem = format!("{part} exceeds the Coulomb friction{label}: it would drive the joint");
            return Err(table.error(key, problem, format!("{} to {coulomb}", -coulomb)));
        }
    }
    Ok(())
}
