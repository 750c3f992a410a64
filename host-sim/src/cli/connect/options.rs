//! Options of `connect`, and those of every session with an arm.

use crate::force::ForceArgs;
use crate::run::Target;
use board::session::operate::simulated_board::Places;
use board::session::operate::wire::Disturbance;
use board::session::serial::BAUD;
use clap::{ArgGroup, Args};
use std::path::PathBuf;

const EXAMPLE: &str = "Example:\n  newtau connect scenes/planar2r_swing.toml --target desk";

const EXAMPLES: &str = "\
Examples:
  newtau connect scenes/puma560_pick.toml --port /dev/ttyACM0 --key arm.key --record out/session.log
  newtau connect scenes/puma560_pick.toml --target qemu --record out/session.mcap
  printf 'home\\nconfirm\\narm\\nrun\\nwait\\n' | newtau connect scenes/planar2r_swing.toml --target desk

Commands, one a line: status, home, confirm, arm, stop, park, disarm, run, hold, clear, jog, goto, wait, watch, dump, quit and more; `help`
lists all of them with their arguments. With --target the scene's simulated arm replaces the joints. In a script its time passes only while a command or a
motion needs it; at a terminal it passes at the pace of the clock. Ctrl-C holds the arm, waits until it rests, and disarms; a second one ends the program. While a script's arm
parks, Ctrl-C stops and holds it instead, and another one disarms it. The end of a script or a pipe parks or disarms the arm and ends the
program; Ctrl-D at a terminal is `quit`.

A script or a pipe ends with 3 if anything was refused or a fault stands.";

/// Cables that lose frames at random.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Lossy {
    /// The link between host and board.
    Host,
    /// The buses of the drives.
    Buses,
    /// Both.
    Both,
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err("expected a probability, 0 to 1".into()),
    }
}

fn delay(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.0..=10_000.0).contains(&value) => Ok(value),
        _ => Err("expected a time in ms, 0 to 10000".into()),
    }
}

/// Options of `connect`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES, group = ArgGroup::new("board").required(true).args(["port", "target"]))]
pub struct ConnectArgs {
    /// The scene file (TOML) that the board's firmware was built from.
    pub scene: PathBuf,
    /// The serial port of the board.
    #[arg(long)]
    pub port: Option<String>,
    /// Baud rate of the port, bit/s.
    #[arg(long, default_value_t = BAUD, requires = "port")]
    pub baud: u32,
    /// Allow a script to continue with an arm that an earlier session left driven. A user at a terminal is always allowed.
    #[arg(long, requires = "port")]
    pub take_over: bool,
    /// The key file of the board (`newtau firmware key new`). A board without this key is rejected.
    #[arg(long, value_name = "FILE", requires = "port")]
    pub key: Option<PathBuf>,
    /// A dry run instead of a board: the firmware in an emulated STM32F405 (qemu), or the firmware's session in this program (desk).
    #[arg(long, value_enum)]
    pub target: Option<Target>,
    /// With `--target desk`: put simulated cables between host and board and between board and drives. They can lose frames, and `cut`
    /// and `plug` work. The options below switch it on too.
    #[arg(long, requires = "target")]
    pub simulate_link: bool,
    /// Probability that a frame is lost, 0 to 1.
    #[arg(long, value_name = "P", requires = "target", value_parser = probability, allow_negative_numbers = true)]
    pub drop_chance: Option<f64>,
    /// Probability that a frame is damaged and discarded, 0 to 1.
    #[arg(long, value_name = "P", requires = "target", value_parser = probability, allow_negative_numbers = true)]
    pub corrupt_chance: Option<f64>,
    /// Delay of the host link in each direction, ms.
    #[arg(long, value_name = "MS", requires = "target", value_parser = delay, allow_negative_numbers = true)]
    pub delay: Option<f64>,
    /// Seed of the random losses.
    #[arg(long, value_name = "N", requires = "target")]
    pub seed: Option<u64>,
    /// Cables that lose frames at random.
    #[arg(long, value_enum, default_value_t = Lossy::Both, requires = "target")]
    pub lossy: Lossy,
    /// Script, record, motion and output.
    #[command(flatten)]
    pub session: SessionArgs,
}

/// Options of every session with an arm.
#[derive(Clone, Debug, Args)]
pub struct SessionArgs {
    /// Read commands from this file, not from standard input.
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Record every frame in this file, for `newtau connect replay`. A file that ends in `.mcap` can also be opened in viewers.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// A file with another table `[motion]` for the command `run`, such as `newtau model motion` and `excite` write. Without it, the scene's
    /// motion.
    #[arg(long, value_name = "FILE")]
    pub motion: Option<PathBuf>,
    /// Show the session on a page for a browser of this computer: the arm, its state, a stop button. PORT: of 127.0.0.1; without it, the system
    /// chooses one.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0")]
    pub page: Option<u16>,
    /// Begin and continue motions only while the Tab key is held: to let go of it stops and holds the arm. `arm` and hand guiding need no key. For a person
    /// at a terminal; a foot switch may press Tab.
    #[arg(long)]
    pub dead_man: bool,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print a JSON object for each event, one per line.
    #[arg(long)]
    pub json: bool,
}

impl ConnectArgs {
    /// The simulated link's disturbances; `None` without a simulated link.
    pub(super) fn disturbance(&self) -> Option<(Disturbance, Places)> {
        let Self { simulate_link, drop_chance, corrupt_chance, delay, seed, lossy, .. } = *self;
        let given = drop_chance.or(corrupt_chance).or(delay).is_some() || seed.is_some();
        (simulate_link || given).then(|| {
            let disturbance = Disturbance {
                drop: drop_chance.unwrap_or(0.0),
                corrupt: corrupt_chance.unwrap_or(0.0),
                delay: 1e-3 * delay.unwrap_or(0.0),
                seed: seed.unwrap_or(0),
            };
            (disturbance, Places { host: lossy != Lossy::Buses, buses: lossy != Lossy::Host })
        })
    }
}
