//! The table `[collision]`: collision thresholds, and the reaction to a collision.

use super::values::per_joint;
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{CollisionSpec, ControlSpec};
use crate::read::table::Table;
use dynamics_core::control::CollisionReaction;

pub(super) fn read(table: &Table<'_>, robot: &Robot, control: &ControlSpec) -> Result<CollisionSpec, FileError> {
    const THRESHOLD: &str = "an external torque above zero, N m or N";
    table.only(&["bandwidth", "threshold", "ticks", "release", "reaction"])?;
    // At this bandwidth the residual follows within a tick; a higher one makes it no faster.
    let most = 5.0 * control.rate;
    let expected = format!("a bandwidth in rad/s, above zero and at most {most}, 5 times the rate");
    let bandwidth = table.get("bandwidth").map_or(Ok(50.0), |value| value.positive_up_to(most, &expected))?;
    let reactions = [
        ("stop", CollisionReaction::Stop),
        ("hold", CollisionReaction::Hold),
        ("comply", CollisionReaction::Comply),
        ("report", CollisionReaction::Report),
    ];
    let reaction = table.get("reaction").map_or(Ok(CollisionReaction::Stop), |value| value.choice(&reactions))?;
    if let Some(problem) = control.law.traits().watch_only_reports.filter(|_| reaction != CollisionReaction::Report) {
        let key = if table.get("reaction").is_some() { "reaction" } else { "threshold" };
        return Err(table.error(key, problem, "`reaction = \"report\"` beside this law"));
    }
    let threshold = if reaction == CollisionReaction::Report {
        if let Some(value) = table.get("threshold") {
            return Err(value.error("nothing acts on it", "no `threshold` beside `reaction = \"report\"`"));
        }
        vec![f64::INFINITY; robot.joints.len()]
    } else {
        let threshold = table.require("threshold", THRESHOLD)?;
        per_joint(&threshold, robot, THRESHOLD, |value| value.positive(THRESHOLD))?
    };
    let ticks = table.get("ticks").map_or(Ok(3), |value| value.count(1000, "a whole number of ticks, 1 to 1,000"))?;
    let release = table.get("release").map_or(Ok(0.2), |value| value.positive_up_to(60.0, "a time in s, up to 60"))?;
    Ok(CollisionSpec { bandwidth, threshold, ticks, release, reaction })
}
