//! `model info`: prints the contents of a robot file.

use crate::cli::chain::ChainArgs;
use clap::Args;
use dynamics_core::JointKind;
use robot_compiler::Robot;
use sim::failure::Failure;
use sim::run::joint_label::JointLabel;
use sim::table::table;
use sim::terminal::{print, say_mounting};
use std::path::PathBuf;

/// Options of `info`.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Example:\n  newtau model info robots/ur5.toml")]
pub struct InfoArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
}

/// Prints the robot as a table.
///
/// # Errors
/// A wrong robot file.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let robot = Robot::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    say_mounting(&robot);
    print(&format!("{}\n", describe(&robot)))
}

/// Name, source, and a row per joint.
#[must_use]
pub fn describe(robot: &Robot) -> String {
    let mut table = table(["joint", "type", "mass", "rotor", "friction", "position", "velocity", "torque"], 2);
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
