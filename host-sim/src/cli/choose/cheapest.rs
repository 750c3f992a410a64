//! `choose`: the cheapest choice that meets a request, as a scene.

use super::trade::{folder, measured};
use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use clap::Args;
use sim::failure::{Failure, in_file};
use sim::terminal::{json, print};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::trade::baseline::Baseline;
use studies::trade::chip::Chip;
use studies::trade::product::{TradeAxes, choices};
use studies::trade::request::{Budget, Percentage, Request};

const EXAMPLE: &str =
    "Example:\n  newtau choose scenes/planar2r_swing.toml --max-torque-error 0.2% --budget 20%@4kHz --alone";

const EXAMPLES: &str = "\
The choices, and what is measured of them, are those of `trade`, whose measurements are used where they are known. The cheapest is the one
with the fewest cycles. Percentage of the processor: mean cycles (an estimate) of the whole interrupt that the firmware runs, not of the
controller alone, times the rate over the clock; the longest tick must also end before the next is due. If no choice does, the message says what the nearest would cost, and the exit code is 2.

Examples:
  newtau choose scenes/puma560_pick.toml --max-torque-error 0.2% --budget 20%@4kHz
  newtau choose scenes/puma560_pick.toml --max-tracking-error 2e-3 --trig polynomial --out scenes/mine.toml";

/// Options of `choose`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ChooseArgs {
    /// The scene file, or a robot file, for which a scene is made up.
    pub scene: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Greatest torque error of any joint on any test motion, as a share of its limit: 0.2% or 0.002.
    #[arg(long, value_name = "SHARE")]
    pub max_torque_error: Option<Percentage>,
    /// Greatest tracking error of any joint on any test motion, rad or m.
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    pub max_tracking_error: Option<f64>,
    /// Percentage of the processor that the whole interrupt may take at a control rate: 20%@4kHz.
    #[arg(long, value_name = "SHARE@RATE")]
    pub budget: Option<Budget>,
    /// Clock of the processor, MHz.
    #[arg(long, value_name = "MHZ", default_value_t = 168.0, allow_negative_numbers = true)]
    pub clock: f64,
    /// Choices to combine.
    #[command(flatten)]
    pub axes: TradeAxes,
    /// File for the scene. Without it, out/trade/NAME/chosen.toml.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Repeat measurements whose results are stored.
    #[arg(long)]
    pub fresh: bool,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Chooses the cheapest point that meets a request, and writes its scene.
///
/// # Errors
/// As [`run`](super::trade::run); also an empty request, or a request that no choice meets.
pub fn run(args: &ChooseArgs, chip: &dyn Chip, stop: &AtomicBool) -> Result<(), Failure> {
    if args.max_torque_error.is_none() && args.max_tracking_error.is_none() && args.budget.is_none() {
        return Err(Failure::Input(miette::miette!(
            "no limit was given: expected --max-torque-error, --max-tracking-error, --budget, or several of them"
        )));
    }
    let base = Baseline::load(&args.scene, args.chain.ends())?;
    let mut output = args.force.output().reads(&args.scene);
    let work = folder(None, &base, &mut output)?;
    let path = args.out.clone().unwrap_or_else(|| work.join("chosen.toml"));
    // An error here is better before the measurements than after them.
    output.file(&path)?;
    let rate = args.budget.map(|budget| budget.rate);
    let trade = measured(&base, &args.scene, &choices(&args.axes, &base, rate)?, chip, &work, args.fresh, stop)?;
    let request = Request {
        torque: args.max_torque_error.map(|share| share.0),
        tracking: args.max_tracking_error,
        share: args.budget.map(|budget| budget.share),
        clock: args.clock * 1e6,
    };
    let Some(chosen) = request.cheapest(&trade) else {
        return Err(Failure::Input(miette::miette!(
            help = request.nearest(&trade),
            "{}: none of {} choices meets the request",
            args.scene.display(),
            trade.points.len()
        )));
    };
    let home = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_stem().map_or_else(|| base.file.name.clone(), |stem| stem.to_string_lossy().into_owned());
    fs::write(&path, base.with_in(&chosen.choice, &name, home)).map_err(|error| in_file(&path, &error))?;
    output.written(std::slice::from_ref(&path))?;
    if args.json {
        let text = serde_json::json!({ "scene": path, "point": chosen, "cpu_share": request.share_of(chosen) });
        return print(&(json(&text)? + "\n"));
    }
    print(&request.explain(&trade, chosen, &path))
}
