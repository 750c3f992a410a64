//! `motors setup`: a person moves each joint by hand, and the robot file gets its drives.

mod drive_tables;
mod interview;
mod person;

use crate::force::ForceArgs;
use board::can::adapter::Adapter;
use board::can::setup::motors;
use clap::Args;
use drive_tables::{FoundDrive, has_ranges_of, with_drives};
use dynamics_core::JointKind;
use dynamics_core::drive::Protocol;
use interview::Interview;
use robot_compiler::Robot;
use sim::failure::Failure;
use sim::terminal;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io;
use std::path::PathBuf;

/// Options of `motors setup`.
#[derive(Clone, Debug, Args)]
pub struct SetupArgs {
    /// The robot file (TOML), with its joints, base first.
    pub robot: PathBuf,
    /// The file that is written: the robot file with its drives.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// The bus of these motors, 1 to 3.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=3))]
    pub bus: u8,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Walks through the joints, and writes the robot file. Returns the message at the end.
///
/// # Errors
/// A wrong robot file; an adapter that is gone; motors that are silent or on, of two kinds, or used by another program; a file that cannot be written.
pub fn run(
    args: &SetupArgs,
    kind: Option<Protocol>,
    adapter: &mut dyn Adapter,
    failed: impl Fn(io::Error) -> Failure,
) -> Result<String, Failure> {
    let place = args.robot.display();
    let is_urdf = |ending: &OsStr| ["urdf", "xml"].iter().any(|urdf| ending.eq_ignore_ascii_case(urdf));
    if args.robot.extension().is_some_and(is_urdf) {
        return Err(Failure::Input(miette::miette!(
            help = "newtau import ARM.urdf --out ARM.toml",
            "{place}: expected a robot file in TOML"
        )));
    }
    let read_text =
        || std::fs::read_to_string(&args.robot).map_err(|error| Failure::input(miette::miette!("{place}: {error}")));
    // The text is read before the robot, so that the comparison at the end also finds a change between these two readings. If the file cannot be read,
    // the message of `Robot::load` says more.
    let text = read_text();
    let robot = Robot::load(&args.robot).map_err(Failure::input)?;
    let text = text?;
    // An error here is better before the work than after it. It is checked again when the file is written.
    args.force.output().reads(&args.robot).file(&args.out)?;
    let mut output = args.force.output().reads(&args.robot);
    if let Some(joint) =
        robot.joints.iter().find(|joint| joint.spec.kind == JointKind::Prismatic && joint.drive.is_none())
    {
        return Err(Failure::Input(miette::miette!(
            help = "write its drive by hand, with `gear` in shaft rad per m",
            "{place}: joint {} slides; setup finds drives of joints that turn",
            joint.name
        )));
    }
    let of_file = || robot.joints.iter().filter_map(|joint| joint.drive.map(|drive| drive.kind()));
    let kinds = [Protocol::Damiao, Protocol::RobStride].map(|kind| kind.facts().name);
    if let Some(other) = of_file().find(|kind| !kinds.contains(kind)) {
        return Err(Failure::Input(miette::miette!(
            "{place}: found drives of the kind {other}; setup can read the positions of {} motors only",
            kinds.join(" and ")
        )));
    }
    let motors = motors(adapter, kind).map_err(&failed)?;
    let found_kind = motors.first().map(|motor| motor.kind.facts().name);
    if let (Some(found), Some(of_file)) = (found_kind, of_file().find(|kind| Some(*kind) != found_kind)) {
        return Err(Failure::Input(miette::miette!(
            help = "delete the file's [joint.drive] tables; setup writes new ones",
            "{place}: found drives of the kind {of_file} in the file, and {found} motors on the bus"
        )));
    }
    if motors.len() < robot.dof() {
        return Err(Failure::Target(miette::miette!(
            help =
                "newtau motors scan; power, wiring, and an identifier of its own for each motor (newtau motors set-id)",
            "{} motors answer, and {place} has {} joints",
            motors.len(),
            robot.dof()
        )));
    }
    let mut interview = Interview::new(&robot, adapter, &failed);
    let names: Vec<String> = motors.iter().map(|motor| motor.id.to_string()).collect();
    terminal::print(&format!(
        "Motors {}. None has torque, and none gets any here: SUPPORT THE ARM, it hangs free.\n",
        names.join(", ")
    ))?;
    let mut found = interview.joints(&motors)?;
    interview.zeros(&mut found)?;
    interview.ends(&found)?;
    let mut summary = String::new();
    for (joint, FoundDrive { motor, direction, zero, .. }) in robot.joints.iter().zip(&found) {
        let _ = writeln!(summary, "{}: motor {}, direction {direction}, zero {zero:.4} rad", joint.name, motor.id);
    }
    // Before anything can fail: this was found by hand.
    terminal::print(&summary)?;
    if read_text()? != text {
        return Err(Failure::Input(miette::miette!("{place}: it was changed meanwhile: nothing was written")));
    }
    let written = with_drives(&text, &robot, &found, args.bus)
        .map_err(|why| Failure::Input(miette::miette!("{place}: {why}")))?;
    // What the reader would not accept is not written.
    let read = Robot::from_toml_str(&written, &args.out.display().to_string()).map_err(Failure::input)?;
    for (joint, found) in read.joints.iter().zip(&found) {
        if !has_ranges_of(&found.model, joint) {
            return Err(Failure::Input(miette::miette!(
                "joint {}: its ranges would not be those of motor {}: nothing was written",
                joint.name,
                found.motor.id
            )));
        }
    }
    output.write(&args.out, &written)?;
    output.finish()?;
    Ok(format!(
        "files: {}\nNext: newtau check {0}; then compare positions with `newtau drive`, before torque acts\n",
        args.out.display()
    ))
}
