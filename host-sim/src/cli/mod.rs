//! The command line: sixteen commands, each with a file or folder that holds its arguments, its help, the call and the output. `run` is [beside it](crate::run).

pub mod chain;
pub mod check;
pub mod choose;
pub mod connect;
pub mod doctor;
pub mod drive;
pub mod emit;
pub mod explain;
pub mod firmware;
pub mod identify;
pub mod import;
pub mod model;
pub mod motors;
pub mod names;
pub mod parts;
pub mod renamed;
pub mod report;
pub mod stop;
pub mod sweep;

mod interrupt;

use crate::run::{self, stop_on_interrupt};
use clap::{ArgAction, CommandFactory as _, Parser, Subcommand};
use clap_complete::Shell;
use sim::failure::Failure;
use sim::terminal;
use studies::trade::chip::EmulatedChip;

/// Computed-torque control for robot arms of one to six joints: simulate it, fit it to your arm, put it on a board.
#[derive(Clone, Debug, Parser)]
#[command(name = "newtau", version, disable_help_flag = true, help_template = TEMPLATE, after_help = AFTER, after_long_help = EXIT_CODES)]
pub struct Cli {
    /// Print help.
    #[arg(short, long, global = true, action = ArgAction::HelpShort)]
    pub help: Option<bool>,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const TEMPLATE: &str = "\
{about}

{usage-heading} {usage}

Your arm
  import    URDF to robot file
  check     find what is wrong or missing in a robot file
  identify  masses, inertias and friction from logs; `identify excite` designs the motion to record

Simulate
  run       close the loop of a scene, on the desk or through the firmware in an emulated chip
  sweep     very many runs of a scene whose keys vary; `sweep merge` puts shards together
  report    two runs side by side on one page

Operate
  connect   operate an arm: status, arm, jog, run, record; `connect replay` demands the bits of a record
  drive     the same from this computer, with the drives at a CAN adapter
  stop      stop the arm of a session in another terminal
  motors    search a CAN bus for motors, show one, change its settings
  firmware  build it, flash it, make and write the key
  doctor    find what is missing on this computer, and what to do

Choose
  explain   what each term of a scene's model costs, and what goes wrong without it
  choose    the cheapest settings that are accurate enough; `choose trade`, `bound`, `margins`

Compute
  model     dynamics, terms, statics, contact, energy, linkage, kernel and more
  emit      a Rust crate of an arm for your own firmware

Options:
{options}{after-help}";

const AFTER: &str = "\
Example:
  newtau run scenes/yam_split.toml

`newtau COMMAND --help` shows a command on one screen, `newtau help COMMAND` all about it; `newtau help` lists the exit\ncodes. `newtau completions bash` (or zsh, fish, elvish, powershell) prints a completion script.";

const EXIT_CODES: &str = "\
Example:
  newtau run scenes/yam_split.toml

Files: what exists is not overwritten. A folder that newtau made has a marker, .newtau-output.json; files in it that newtau wrote and
that nobody changed since are replaced. --force of a command overwrites other files too, but never an input of that command.

Exit codes:
  0    done
  1    something outside failed: a file could not be written, the target died; a replay that differs, or ends before its record
  2    bad input: a file, a line or an option; the message says where and what was expected
  3    the run ended in a fault, a command of a session was refused, the simulated arm ran away, the simulated linkage came to a dead
       point, or a check found something wrong; everything recorded was written
  4    chip and desk differed in some tick
  130  interrupted; everything recorded until then was written";

/// The command.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Write a TOML robot file from an arm of a URDF file.
    Import(import::ImportArgs),
    /// Check a robot file for wrong, doubtful and missing values.
    Check(check::CheckArgs),
    /// Identify an arm from logs: masses, inertias, friction, payload.
    Identify(Box<identify::IdentifyCommand>),
    /// Simulate a scene in closed loop: table, CSV log, and a report for a browser.
    Run(run::RunArgs),
    /// Run a study: many runs of a scene with keys that vary from run to run.
    Sweep(sweep::SweepCommand),
    /// Compare two runs on one page: both arms, overlaid curves, differences.
    Report(report::ReportArgs),
    /// Operate an arm through a board on a serial port, or in a dry run: status, arm, jog, run the motion, record.
    Connect(connect::ConnectCommand),
    /// Operate an arm from this computer, with its drives at a CAN adapter.
    Drive(drive::DriveArgs),
    /// Stop the arm of every session that runs on this computer, from another terminal.
    Stop(stop::StopArgs),
    /// Search a CAN bus for motors, show a motor, change its settings. Enables none.
    Motors(motors::MotorsArgs),
    /// Build the firmware, flash it, and make and write the key that a host and a board share.
    Firmware(firmware::FirmwareArgs),
    /// Check the installation: tool chain, emulator, probe, serial port, the firmware on a board; and say what to do.
    Doctor(doctor::DoctorArgs),
    /// Explain a scene's model: the cost of each term, and the error without it.
    Explain(explain::ExplainArgs),
    /// Choose the cheapest settings that are accurate enough, as a scene.
    Choose(choose::ChooseCommand),
    /// Compute the arm's equations of motion.
    Model(model::ModelArgs),
    /// Write code for your own firmware.
    Emit(emit::EmitArgs),
    /// Print a completion script for a shell.
    #[command(hide = true, after_help = "Example:\n  newtau completions bash")]
    Completions {
        /// The shell.
        shell: Shell,
    },
}

impl Command {
    /// Runs the command. Returns the exit code.
    ///
    /// # Errors
    /// Errors of the command.
    pub fn run(&self) -> Result<u8, Failure> {
        match self {
            Self::Import(args) => import::run(args).map(|()| 0),
            Self::Check(args) => check::run(args),
            Self::Identify(command) => identify::run(command),
            Self::Run(args) => run::run(args, &stop_on_interrupt()),
            Self::Sweep(command) => sweep::run(command),
            Self::Report(args) => report::run(args).map(|()| 0),
            Self::Connect(command) => connect::run(command),
            Self::Drive(args) => drive::run(args, interrupt::presses_of_any_kind),
            Self::Stop(args) => stop::run(*args),
            Self::Motors(args) => motors::run(args),
            Self::Firmware(args) => firmware::run(args),
            Self::Doctor(args) => doctor::run(args),
            Self::Explain(args) => explain::run(args, &EmulatedChip, &stop_on_interrupt()).map(|()| 0),
            Self::Choose(command) => choose::run(command, &EmulatedChip),
            Self::Model(args) => args.run(),
            Self::Emit(args) => emit::run(args).map(|()| 0),
            Self::Completions { shell } => {
                let mut script = Vec::new();
                clap_complete::generate(*shell, &mut Cli::command(), "newtau", &mut script);
                terminal::print(&String::from_utf8_lossy(&script)).map(|()| 0)
            }
        }
    }
}
