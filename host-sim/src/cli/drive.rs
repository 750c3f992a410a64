//! `drive`: operates the arm of a scene from this computer, with its drives at CAN adapters.

use crate::cli::connect::options::SessionArgs;
use crate::cli::connect::session::Setup;
use crate::run::stop_on_interrupt;
use board::can::adapter_name::AdapterName;
use board::session::drive::arm::Wiring;
use board::session::drive::timing_check;
use board::session::operate::Presses;
use clap::{ArgGroup, Args};
use robot_compiler::SceneFile;
use sim::failure::{self, Failure};
use sim::run::trial;
use sim::terminal;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

const EXAMPLE: &str = "Example:\n  newtau drive scenes/yam_one_bus.toml --can simulated";

const EXAMPLES: &str = "\
Examples:
  newtau drive scenes/yam_one_bus.toml --can simulated
  newtau drive scenes/yam_one_bus.toml --check-timing 60
  newtau drive scenes/yam_one_bus.toml --can can0 --record out/session.log
  newtau drive scenes/yam_one_bus.toml --can slcan:/dev/ttyACM0
  newtau drive scenes/yam_one_bus.toml --can gs_usb

The firmware's session, its safety state machine and its driver of the joints run in this program, on a thread of its own. Commands are those of
`newtau connect`. `--can` names an adapter: an interface of Linux (`can0`), `slcan:PORT`, `damiao:PORT`, `gs_usb:SERIAL` (candleLight; `gs_usb` for the
only one, `gs_usb:SERIAL:CHANNEL` for a further channel), or `simulated` for the scene's simulated arm; the bus has 1 Mbit/s. One adapter has all drives; several have the buses 1, 2 and 3 of the robot file, in this order.

No emergency stop is wired to a computer: use one that cuts the drives' power. If this program dies, each drive's own timeout acts
(docs/start/adapter.md).

A script or a pipe ends with 3 if anything was refused or a fault stands.";

/// Options of `drive`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES, group = ArgGroup::new("where").required(true).args(["can", "check_timing"]))]
pub struct DriveArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// A CAN adapter: can0, slcan:PORT, damiao:PORT, gs_usb:SERIAL, or simulated. Once for each bus of the robot file, or once for all drives.
    #[arg(long, value_name = "ADAPTER")]
    pub can: Vec<AdapterName>,
    /// Accept drives without a communication timeout: if this program dies, they may keep their last torque.
    #[arg(long, requires = "can")]
    pub without_timeout: bool,
    /// Measure for this many seconds, without an arm, how late this computer begins its ticks, and print the rate that it holds.
    #[arg(long, value_name = "SECONDS", conflicts_with = "can", value_parser = seconds)]
    pub check_timing: Option<f64>,
    /// Script, record, motion and output.
    #[command(flatten)]
    pub session: SessionArgs,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.1..=86_400.0).contains(&value) => Ok(value),
        _ => Err("expected a time in seconds, 0.1 to 86400".into()),
    }
}

/// Operates the arm. Returns the exit code.
///
/// # Errors
/// A wrong scene or command; an adapter that cannot be opened or dies; a record that cannot be written.
pub fn run(args: &DriveArgs, presses: fn() -> Presses) -> Result<u8, Failure> {
    if let Some(seconds) = args.check_timing {
        return check_timing(args, seconds);
    }
    let setup = Setup::new(&args.scene, &args.session, None)?;
    let wiring = Wiring::new(&setup.scene, &args.can, args.without_timeout)?;
    if let Some(found) = trial::oscillation(&setup.scene)? {
        let error = found.error(&setup.scene);
        if args.can.iter().any(|name| *name != AdapterName::Simulated) {
            return Err(Failure::input(error));
        }
        let (problem, expected) = (error.problem(), error.expected());
        setup.say("loop", &format!("{problem}; {expected}; an arm at an adapter is refused with this scene"))?;
    }
    for load in wiring.loads() {
        setup.say("bus", &load.to_string())?;
    }
    let presses = presses();
    let device = wiring.start(&setup.scene, Arc::clone(&presses))?;
    let shown = device.shown();
    if let Some(real_time) = shown.real_time() {
        setup.say("real time", &real_time.text())?;
    }
    setup.operate(Box::new(device), presses, false, || shown.text())
}

/// Prints how late ticks begin on this computer.
fn check_timing(args: &DriveArgs, seconds: f64) -> Result<u8, Failure> {
    let scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    let found = timing_check::check(&scene, Duration::from_secs_f64(seconds), &stop_on_interrupt())?;
    let text = match args.session.json {
        true => terminal::json(&found.report(&scene))?,
        false => found.text(&scene),
    };
    terminal::print(&text)?;
    Ok(if found.times.overruns == 0 { 0 } else { failure::FAULT })
}
