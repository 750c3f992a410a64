//! `cargo xtask budget`: measures the costs of every firmware on its chip and compares them with the ranges in `firmware/budget.toml`. With `--port`,
//! measures the cycles of a tick on a board.
//!
//! | module | holds |
//! |---|---|
//! | [`row`] | the numbers of one firmware: one scene on one board |
//! | [`image`] | flash, RAM and the bound of the stack, from the linked program |
//! | [`measure`] | the rest, in the emulator, by `chip-budget` |
//! | [`board`] | cycles of a flashed board, over its serial port |
//! | [`tuning`] | one firmware, built with different compiler settings |
//! | [`variant`] | a scene with some settings changed |
//! | [`bounds`] | `firmware/budget.toml`: ranges, targets, and violations of them |
//! | [`table`] | the table of docs/measured/budget.md, and its rows in the README |

mod board;
mod bounds;
pub(crate) mod image;
mod measure;
pub(crate) mod row;
mod table;
mod targets;
mod tuning;
pub(crate) mod variant;

use crate::measured::write_into;
use crate::scenes::shipped;
use crate::toolchain::Toolchain;
use anyhow::Result;
use bounds::Budget;
use firmware_image::Board;
use firmware_image::board::SCENE_DEFAULT;
use row::BudgetRow;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  cargo xtask budget --scene scenes/puma560_pick.toml
  cargo xtask budget --port /dev/ttyACM0 --board f405-can --scene scenes/examples/mit6_wave.toml

With --port the ticks are those of a flashed board, in lock step on the bench: no drive is driven, but whatever the board does is stopped by
it, so take the drives' power off. It must have the scene's hash and rate, its torques must be the desk's to the last bit, and its
cycle counter (DWT CYCCNT) must count. Nothing is held to a bound. An adapter that keeps bytes for 16 ms takes some minutes for 10,000 ticks.

Code 2: what you named is not there or does not fit, or the counter stands still; code 1: the board failed meanwhile, or a torque differs.

--port --json is an object {robot, scene, board, port, hash, rate_hz, clock_hz, ticks, bits_differ, cycles_per_tick: {min, max, mean},
share_of_period: {max, mean}, emulator: {instructions_per_tick, interrupt_cycles_estimate}}; the emulator's are ranges of
firmware/budget.toml, null where it has none.";

/// Options of `budget`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct BudgetOptions {
    /// Write the table of docs/measured/budget.md, and three rows of it into README.md
    #[arg(long)]
    write: bool,
    /// Make the present measurements the bounds of firmware/budget.toml, with 2 % on both sides
    #[arg(long)]
    bless: bool,
    /// With --port: print JSON
    #[arg(long, requires = "port")]
    json: bool,
    /// Measure only these scenes, and the sizes on the other boards. With --bless or --write the rows of other scenes stay unchanged or are left out
    #[arg(long = "scene")]
    scenes: Vec<PathBuf>,
    /// Also send a flood on the link at the same time as the timer's ticks, and record how late the ticks begin
    #[arg(long)]
    flood: bool,
    /// Measure the cost of the link instead, byte by byte and by DMA
    #[arg(long, conflicts_with_all = ["bless", "flood", "scenes", "port"])]
    link: bool,
    /// Measure the cost with other compiler settings instead
    #[arg(long, conflicts_with_all = ["bless", "flood", "link", "scenes", "port"])]
    tuning: bool,
    /// Measure the board on this serial port instead: cycles of its ticks, counted by the chip; drives get no torque
    #[arg(long, requires = "board", conflicts_with_all = ["write", "bless", "flood"])]
    port: Option<String>,
    /// With --port: the board that was flashed, with --scene or with its example
    #[arg(long, value_enum, requires = "port")]
    board: Option<Board>,
    /// With --port: the board's key file, if it has a key
    #[arg(long, value_name = "FILE", requires = "port")]
    key: Option<PathBuf>,
    /// With --port: number of ticks
    #[arg(long, requires = "port", default_value_t = 10_000)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    ticks: u32,
}

/// Scene for the flood. Its tick must also stay below a share of the chip's time.
const HARDEST: &str = "scenes/puma560_collision.toml";

/// Boards without an emulator: only the sizes of their programs are measured.
const SIZE_ONLY: [Board; 4] = [Board::F405Can, Board::F405Pwm, Board::OdriveV3, Board::G474Fdcan];

/// Measures, compares with the bounds, and prints or writes.
pub(crate) fn run(options: &BudgetOptions) -> Result<()> {
    if let (Some(port), Some(board)) = (&options.port, options.board) {
        let key = options.key.as_deref();
        let asked = board::Asked { port, key, board, scenes: &options.scenes, ticks: options.ticks };
        return board::run(&asked, options.json);
    }
    if options.link {
        return link(options);
    }
    if options.tuning {
        let table = tuning::table(Path::new(SCENE_DEFAULT))?;
        println!("{table}");
        return if options.write { write_into("docs/measured/tuning.md", &[("tuning", table)]) } else { Ok(()) };
    }
    let all = options.scenes.is_empty();
    let scenes = if all { shipped()? } else { options.scenes.clone() };
    let rustc = Toolchain::find_or_install()?.rustc()?;
    let mut budget = Budget::load()?;
    let mut rows = Vec::new();
    // Save each row as soon as it is known, so that a failure in the last scene does not lose minutes of measurement.
    let mut take = |row: BudgetRow, budget: &mut Budget| {
        if options.bless {
            budget.bless(std::slice::from_ref(&row), &rustc, false);
            budget.save()?;
        }
        rows.push(row);
        anyhow::Ok(())
    };
    for scene in &scenes {
        eprintln!("budget: {}", scene.display());
        take(measure::row(scene, measure::Extent::FULL)?, &mut budget)?;
    }
    for board in SIZE_ONLY {
        eprintln!("budget: {board}");
        take(measure::sizes(Path::new(board.scene()), board)?, &mut budget)?;
    }
    if options.bless && all {
        budget.bless(&rows, &rustc, all);
        budget.save()?;
    }
    if options.write {
        write_into("docs/measured/budget.md", &[("budget", table::markdown(&rows))])?;
        if table::shows(&rows) {
            write_into("README.md", &[("budget", table::teaser(&rows))])?;
        }
    }
    // Run the flood last, so that its failure does not lose minutes of measurement.
    let late = options.flood.then(|| measure::flood(Path::new(HARDEST))).transpose()?;
    println!("{}", table::markdown(&rows));
    late.iter().for_each(|late| println!("{}", table::late(late)));
    if let (true, Some(late)) = (options.write, &late) {
        write_into("docs/measured/budget.md", &[("tick start", table::late(late))])?;
    }
    let fields = if all { bounds::Fields::All } else { bounds::Fields::Measured };
    let mut broken = budget.hold(&rows, &rustc, fields);
    broken.extend(late.iter().flat_map(|late| budget.hold_late(late)));
    bounds::verdict(rows.len(), &broken)
}

/// Prints the link's cost, and writes its table if requested.
fn link(options: &BudgetOptions) -> Result<()> {
    let ways = measure::ways(Path::new(SCENE_DEFAULT), Board::F405Can)?;
    if options.write {
        write_into("docs/measured/budget.md", &[("link", table::ways(&ways))])?;
    }
    println!("{}", table::ways(&ways));
    Ok(())
}

/// True if the compiler of the chip's programs is the one in `firmware/budget.toml`.
pub(crate) fn is_of_this_compiler() -> Result<bool> {
    Ok(Budget::load()?.is_of(&Toolchain::find_or_install()?.rustc()?))
}

/// The short part, for `cargo xtask test`: a few hundred ticks of the hardest scene.
pub(crate) fn gate() -> Result<()> {
    let row = measure::row(Path::new(HARDEST), measure::Extent::SHORT)?;
    let budget = Budget::load()?;
    let rustc = Toolchain::find_or_install()?.rustc()?;
    bounds::verdict(1, &budget.hold(&[row], &rustc, bounds::Fields::Measured))
}

/// Checks flash, RAM and stack of one firmware against its row.
pub(crate) fn sizes(elf: &Path, scene: &Path, board: Board) -> Result<()> {
    let row = BudgetRow::sizes(scene, board, &image::Image::measure(elf)?);
    for (field, value) in &row.numbers {
        println!("{:<16}{value:>8} {}", field.name(), field.unit());
    }
    let rustc = Toolchain::find_or_install()?.rustc()?;
    bounds::verdict(1, &Budget::load()?.hold(&[row], &rustc, bounds::Fields::Measured))
}

/// Prints the longest interrupt of a scene's supervised ticks on the emulated board, as one JSON object.
pub(crate) fn interrupt(scene: &Path) -> Result<()> {
    println!("{}", measure::interrupt(scene)?);
    Ok(())
}
