//! `info`: what a robot file holds.

use crate::cli::InfoArgs;
use crate::failure::{self, Failure};
use crate::run::record::JointLabel;
use comfy_table::{CellAlignment, Table, presets};
use dynamics_core::JointKind;
use robot_compiler::Robot;

/// Print the robot as a table.
///
/// # Errors
/// A robot file that is wrong.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let robot = Robot::load(&args.robot).map_err(Failure::input)?;
    failure::print(&format!("{}\n", describe(&robot)))
}

/// Name, source, and a row per joint.
#[must_use]
pub fn describe(robot: &Robot) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(["joint", "type", "mass", "rotor", "friction", "position", "velocity", "torque"]);
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for joint in &robot.joints {
        let spec = &joint.spec;
        let label = JointLabel { name: joint.name.clone(), kind: spec.kind };
        let (kind, inertia) = match spec.kind {
            JointKind::Revolute => ("revolute", "kg m\u{b2}"),
            JointKind::Prismatic => ("prismatic", "kg"),
        };
        let (lo, hi) = spec.limits.position;
        table.add_row([
            label.name.clone(),
            kind.to_owned(),
            format!("{} kg", spec.body.mass),
            format!("{:.3} {inertia}", spec.rotor.reflected()),
            joint.friction.map_or("-".to_owned(), |f| {
                format!(
                    "{:.3} {} + {:.3} {}/({})",
                    f.coulomb,
                    label.torque_unit(),
                    f.viscous,
                    label.torque_unit(),
                    label.velocity_unit()
                )
            }),
            format!("{lo:.3} to {hi:.3} {}", label.position_unit()),
            format!("{:.3} {}", spec.limits.velocity, label.velocity_unit()),
            format!("{:.1} {}", spec.limits.torque, label.torque_unit()),
        ]);
    }
    let mut text = format!("{}\nsource: {}\n", robot.name, robot.source);
    if let Some(reason) = &robot.allow_unphysical {
        text += &format!("unphysical bodies are allowed: {reason}\n");
    }
    text + &table.to_string()
}
