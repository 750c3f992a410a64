//! The command line: one file a command, with its arguments, its help, the call and what is printed.

pub mod bound;
pub mod chain;
pub mod check;
pub mod choose;
pub mod compare;
pub mod connect;
pub mod contact;
pub mod corrections;
pub mod doctor;
pub mod dynamics;
pub mod energy;
pub mod excite;
pub mod explain;
pub mod export;
pub mod extremes;
pub mod force;
pub mod gravity;
pub mod identify;
pub mod import;
pub mod info;
pub mod kernel;
pub mod key;
pub mod linkage;
pub mod merge;
pub mod motion;
pub mod names;
pub mod replay;
pub mod run;
pub mod statics;
pub mod sweep;
pub mod terms;
pub mod trade;

mod output;

use clap::{Parser, Subcommand};

/// Simulate a robot arm under computed-torque control, on the desk or with the chip's own firmware in the loop.
#[derive(Clone, Debug, Parser)]
#[command(name = "host-sim", version, after_long_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Files: what exists is not overwritten. A folder that host-sim made has a marker, .host-sim-output.json; files in it that host-sim wrote and
that nobody changed since are replaced. --force of a command overwrites other files too, but never an input of that command.

Exit codes:
  0    done
  1    something outside failed: a file could not be written, the target died; a replay that differs, or ends before its record
  2    bad input: a file, a line or an option; the message says where and what was expected
  3    the run ended in a fault, a command of a session was refused, the simulated arm ran away, the simulated linkage came to a dead
       point, or a check found something wrong; everything recorded was written
  4    chip and desk differed in some tick
  130  interrupted; everything recorded until then was written";

/// What to do.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Close the loop of a scene: table, CSV log, a report for a browser.
    Run(run::RunArgs),
    /// Two runs on one page: both arms, curves over each other, what differs.
    Compare(compare::CompareArgs),
    /// Inverse and forward dynamics of states given as JSON lines.
    Dynamics(dynamics::DynamicsArgs),
    /// Show the matrices of the equations of motion at one posture.
    Terms(terms::TermsArgs),
    /// Torques that hold an arm at rest, what its joints carry, and the posture that takes least.
    Statics(statics::StaticsArgs),
    /// The wrench at the tip from a sensor in the base, or its reading for a known contact.
    Contact(contact::ContactArgs),
    /// Run a scene and account for the energy: work of every joint, friction, what is left over.
    Energy(energy::EnergyArgs),
    /// Explain a scene's model: what each term costs, and what goes wrong without it.
    Explain(explain::ExplainArgs),
    /// Show what a robot file holds.
    Info(info::InfoArgs),
    /// Make a motion of the path that an arm was led along by hand.
    Motion(motion::MotionArgs),
    /// Would a physicist believe a robot file: impossible bodies, placeholders, what cannot hold itself, what is missing.
    Check(check::CheckArgs),
    /// Design a motion worth recording, to identify an arm from.
    Excite(excite::ExciteArgs),
    /// Identify an arm from logs: masses, inertias, friction, what it holds.
    Identify(identify::IdentifyArgs),
    /// Write the arm of a robot file as a URDF.
    Export(export::ExportArgs),
    /// Write a TOML robot file from an arm of a URDF file.
    Import(import::ImportArgs),
    /// Print the arm's dynamics as straight-line Rust, or what that saves.
    Kernel(kernel::KernelArgs),
    /// Drive a four-bar linkage or a slider-crank round, or let it run.
    Linkage(linkage::LinkageArgs),
    /// How wrong the torques of single precision are: a proven bound, and the worst that was found.
    Bound(bound::BoundArgs),
    /// What every choice of accuracy costs on the chip: the ones that nothing beats.
    Trade(trade::TradeArgs),
    /// The cheapest choice that meets a request, as a scene.
    Choose(choose::ChooseArgs),
    /// What happens at the edges: masses, numbers, integrators, time, gains; pass or fail, cell by cell.
    Extremes(extremes::ExtremesArgs),
    /// Very many runs of a scene whose keys vary: a study, or a shard of it.
    Sweep(sweep::SweepArgs),
    /// Put the shards of a study together.
    Merge(merge::MergeArgs),
    /// Is everything there: tool chain, emulator, probe, serial port, the firmware on a board; and what to do.
    Doctor(doctor::DoctorArgs),
    /// Make the key that a host and a board share.
    Key(key::KeyArgs),
    /// Operate the arm at a board on a serial port, or in a drill: status, arm, jog, run the motion, record.
    Connect(connect::ConnectArgs),
    /// Run a record of `connect` again on the desk, and demand the very same bits.
    Replay(replay::ReplayArgs),
}
