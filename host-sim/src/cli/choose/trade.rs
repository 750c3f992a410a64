//! `choose trade`: the cost of every choice of accuracy.

use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use clap::Args;
use sim::failure::Failure;
use sim::output::Output;
use sim::pages;
use sim::run::files::file_name;
use sim::terminal::{json, print, progress_bar};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::trade::baseline::Baseline;
use studies::trade::chip::Chip;
use studies::trade::choice::Choice;
use studies::trade::product::{TradeAxes, choices};
use studies::trade::{Trade, Workshop, trade};

const EXAMPLE: &str = "Example:\n  newtau choose trade scenes/planar2r_swing.toml --terms full,gravity,none --alone";

const EXAMPLES: &str = "\
Every combination of the choices below is a scene file of its own; so is the scene's own choice, and each that differs from it in one
thing (not with --alone). Measured of each:
  controller     its tick on the emulated chip: instructions, every one counted, and cycles, an estimate from the instructions that were
                 executed; mean and most, over consecutive ticks of the scene's motion
  interrupt      estimated cycles of all that the firmware runs in the interrupt of a tick under supervision: the controller, and around it
                 what the scene's firmware takes more than its controller, measured once
  share          mean cycles of the interrupt times the rate over 168 MHz; the longest tick's in brackets
  flash, RAM     the tick with all that it reaches, and what it remembers from tick to tick
  torque error   with the arm exactly on its reference: against the full model in 31 digits, greatest and root mean square
  tracking       of the closed loop in the scene's world
on three motions: slow (a tenth of the speed limits), fast (as velocity and torque limits allow), singular (fast through the posture in
which the scaled mass matrix is nearest to singular). Every torque of the chip must have the desk's very bits.

Choices, each a key of the scene file:
  --scalar   f32, f64                                                                      [control] scalar
  --trig     polynomial, polynomial-5, polynomial-3, table, libm                           [control] trig
  --terms    full; no-coriolis; diagonal: gravity and a constant diagonal inertia;
             gravity; none                                                                 [control] law, [model] coriolis
  --friction, --rotors   on, off                                                           [model] friction, rotor
  --every    the model every so many ticks: 1, 4:hold, 4:extrapolate                       [control] model_every, model_between
  --kernel   exact, regrouped                                                              [control] kernel
  --rate     Hz; the scene's otherwise                                                     [control] rate

Examples:
  newtau choose trade scenes/puma560_pick.toml
  newtau choose trade scenes/puma560_pick.toml --scalar f32 --trig polynomial,table --terms full,diagonal --every 1,2:hold
  newtau choose trade robots/ur5.toml --json | jq '.points[] | select(.on_torque_front) | .command'

Files, in the folder given by --out (out/trade/NAME otherwise):
  report.html            every choice on one page, which says on hover what measures it again
  trade.csv              every choice with every number
  points/                the scene of every choice
  measured.jsonl         what has been measured: after an interruption the work goes on from there";

/// Options of `trade`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct TradeArgs {
    /// The scene file, or a robot file, for which a scene is made up.
    pub scene: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Choices to combine.
    #[command(flatten)]
    pub axes: TradeAxes,
    /// Folder for the files.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Repeat measurements whose results are stored.
    #[arg(long)]
    pub fresh: bool,
    /// Write the tables between `<!-- measured: trade, NAME -->` and `<!-- end measured: trade, NAME -->` of this file, and the picture next to
    /// it.
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Measures a trade-off, and prints and writes it.
///
/// # Errors
/// A wrong scene, or a choice that it does not allow; a program for the chip that cannot be built or run; an interruption.
pub fn run(args: &TradeArgs, chip: &dyn Chip, stop: &AtomicBool) -> Result<(), Failure> {
    let base = Baseline::load(&args.scene, args.chain.ends())?;
    let place = place_of(&base.file.name);
    let page = pages::document(args.write.as_deref(), &[&place])?;
    let mut output = args.force.output().reads(&args.scene);
    let folder = folder(args.out.as_deref(), &base, &mut output)?;
    let trade = measured(&base, &args.scene, &choices(&args.axes, &base, None)?, chip, &folder, args.fresh, stop)?;
    let csv = folder.join("trade.csv");
    trade.write_csv(&csv)?;
    let report = folder.join("report.html");
    pages::write(&report, &trade.page())?;
    output.written(&[csv.clone(), report.clone()])?;
    if let Some(page) = page {
        pages::fill(page, &[(&place, trade.markdown())])?;
    }
    let text = if args.json {
        json(&trade)? + "\n"
    } else {
        format!("{}files     {}\n          {}\n", trade.table(), csv.display(), report.display())
    };
    print(&text)
}

fn place_of(scene: &str) -> String {
    format!("trade, {scene}")
}

/// The folder for the files. It is created if it does not exist.
pub(super) fn folder(out: Option<&Path>, base: &Baseline, output: &mut Output) -> Result<PathBuf, Failure> {
    let folder = out.map_or_else(|| Path::new("out/trade").join(file_name(&base.file.name)), Path::to_owned);
    output.folder(&folder, &["trade.csv", "report.html"])?;
    Ok(folder)
}

/// Measures these choices, with a progress bar.
pub(super) fn measured(
    base: &Baseline,
    scene: &Path,
    choices: &[Choice],
    chip: &dyn Chip,
    folder: &Path,
    fresh: bool,
    stop: &AtomicBool,
) -> Result<Trade, Failure> {
    let progress = progress_bar(None, "measurements");
    trade(base, scene, choices, chip, &Workshop { folder, fresh, stop, progress: &progress })
}
