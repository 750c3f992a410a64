//! Ticks of the black box, as a table.

use comfy_table::Table;
use link::{Actuation, Joints, Sensed, StateCode, Status};
use std::io;
use std::path::Path;

/// Columns of a tick; the columns of each joint follow.
const HEAD: [&str; 8] = ["tick", "state", "cause", "joint", "emergency_stop", "overrun", "supply", "temperature"];

/// Writes all ticks as CSV: positions in the board's units (rad or m, or counts), torques in N m or N, limits as bits. A
/// field is empty if a tick has no value for it.
///
/// # Errors
/// The file cannot be written.
pub fn write_csv(past: &[Status], joints: usize, path: &Path) -> io::Result<()> {
    let mut out = csv::Writer::from_path(path)?;
    let columns = ["sensed", "velocity", "age", "reference", "torque", "limits", "drive_fault"];
    let of_joints = columns.iter().flat_map(|column| (1..=joints).map(move |joint| format!("{column}_{joint}")));
    out.write_record(HEAD.map(str::to_owned).into_iter().chain(of_joints))?;
    for status in past {
        out.write_record(row(status, joints))?;
    }
    out.flush()
}

fn row(status: &Status, joints: usize) -> Vec<String> {
    let lines = status.sensed.as_ref().map(|sensed| sensed.lines);
    let of = |number: Option<String>| number.unwrap_or_default();
    let mut row = vec![
        status.tick.to_string(),
        status.state.to_string(),
        status.cause.to_string(),
        of(status.joint.map(|joint| (joint + 1).to_string())),
        of(lines.map(|lines| lines.emergency_stop.to_string())),
        of(lines.map(|lines| lines.overrun.to_string())),
        of(lines.and_then(|lines| lines.supply).map(|x| x.to_string())),
        of(lines.and_then(|lines| lines.temperature).map(|x| x.to_string())),
    ];
    let sensed = status.sensed.as_ref();
    let (place, speed) = match sensed.map(|sensed| &sensed.sensed) {
        Some(Sensed::State { q, qd }) => (texts(q), texts(qd)),
        Some(Sensed::Counts(counts)) => (texts(counts), Vec::new()),
        None => (Vec::new(), Vec::new()),
    };
    let (torque, limits) = match &status.actuation {
        Some(Actuation::Drive { torque, limits }) => (texts(torque), texts(limits)),
        _ => (Vec::new(), Vec::new()),
    };
    let age = sensed.map_or(Vec::new(), |sensed| texts(&sensed.age_ticks));
    let reference = status.reference().map_or(Vec::new(), |reference| texts(&reference.q));
    let faults =
        lines.map_or(Vec::new(), |lines| (0..joints).map(|i| (lines.drive_fault >> i & 1).to_string()).collect());
    for column in [place, speed, age, reference, torque, limits, faults] {
        row.extend((0..joints).map(|i| column.get(i).cloned().unwrap_or_default()));
    }
    row
}

fn texts<T: ToString>(values: &Joints<T>) -> Vec<String> {
    values.iter().map(ToString::to_string).collect()
}

/// The part of the table that a user sees: state, positions and torques.
#[must_use]
pub fn table(past: &[Status], names: &[String]) -> Table {
    let torques =
        names.iter().map(|name| format!("{name} sensed")).chain(names.iter().map(|name| format!("{name} torque")));
    let mut table = sim::table::table(["tick".to_owned(), "state".to_owned()].into_iter().chain(torques), 0);
    for status in past {
        let joints = names.len();
        let all = row(status, joints);
        let state =
            if status.state == StateCode::Fault { format!("fault {}", status.cause) } else { status.state.to_string() };
        let part = |column: usize| all.iter().skip(HEAD.len() + column * joints).take(joints).cloned();
        table.add_row([status.tick.to_string(), state].into_iter().chain(part(0)).chain(part(4)));
    }
    table
}
