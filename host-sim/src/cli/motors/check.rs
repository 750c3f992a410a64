//! `motors check`: compares the settings in motors with a robot file.

use board::can::adapter::Adapter;
use board::can::adapter_name::AdapterName;
use board::can::settings::{advice, check};
use clap::Args;
use dynamics_core::drive::MitDrive;
use robot_compiler::{SceneFile, conflict_on_one_bus};
use serde_json::json;
use sim::failure::{self, Failure};
use sim::terminal;
use std::fmt::Write as _;
use std::io;
use std::path::PathBuf;

/// Options of `motors check`.
#[derive(Clone, Debug, Args)]
pub struct CheckArgs {
    /// A scene of the arm (TOML).
    pub scene: PathBuf,
    /// Only the drives on this bus of the robot file.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=3))]
    pub bus: Option<u8>,
}

/// Compares, prints, and returns the exit code: 3 if a motor does not fit.
///
/// # Errors
/// A wrong scene; drives whose settings cannot be read; an adapter that is gone.
pub(super) fn run(
    args: &CheckArgs,
    adapter: &mut dyn Adapter,
    name: &AdapterName,
    is_json: bool,
    failed: impl Fn(io::Error) -> Failure,
) -> Result<u8, Failure> {
    let scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    let wrong = |why: String| Failure::Input(miette::miette!("{}: {why}", scene.robot.path.display()));
    let kind = scene.protocol().ok_or_else(|| wrong("[joint.drive]: expected a drive on CAN at every joint".into()))?;
    if args.bus.is_none()
        && let Some(why) = conflict_on_one_bus(&scene.robot)
    {
        return Err(wrong(format!("{why}: expected `--bus 1`, and then the next bus: one adapter is at one bus")));
    }
    let of_bus = |drive: &MitDrive| args.bus.is_none_or(|bus| drive.bus + 1 == bus);
    let drives: Vec<(usize, MitDrive)> =
        scene.mit_drives().into_iter().enumerate().filter(|(_, drive)| of_bus(drive)).collect();
    if drives.is_empty() {
        return Err(wrong(format!("no drive on bus {}", args.bus.unwrap_or(1))));
    }
    let found = check(adapter, kind, drives.iter().copied()).map_err(failed)?.ok_or_else(|| {
        let kind = kind.facts().name;
        wrong(format!(
            "drives of the kind {kind} have no settings that can be read: compare the file with the maker's program"
        ))
    })?;
    let text = match found.as_slice() {
        [] => format!("{name}: all {} motors fit {}\n", drives.len(), scene.robot.path.display()),
        found => {
            let mut text = String::new();
            for it in found {
                let _ = writeln!(text, "{it}");
            }
            text + advice(found) + "\n"
        }
    };
    let of = |joint: &usize| found.iter().filter(|it| it.joint == *joint).map(|it| it.mismatch.to_string()).collect();
    let motors: Vec<_> = drives
        .iter()
        .map(|(joint, drive)| {
            let wrong: Vec<String> = of(joint);
            json!({ "joint": joint + 1, "id": drive.id, "mismatches": wrong })
        })
        .collect();
    terminal::print(&if is_json { terminal::json(&json!({ "motors": motors }))? } else { text })?;
    Ok(if found.is_empty() { 0 } else { failure::FAULT })
}
