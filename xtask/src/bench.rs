//! `cargo xtask bench`: measures the cost of the code on the desk and on the chip, and writes `docs/measured/kernels.md`.
//!
//! | module | holds |
//! |---|---|
//! | [`arms`] | commercially available arms with their drives, in simulation |
//! | [`chip`] | instructions in the emulator; bytes and stack traffic in the linked program |
//! | [`cycles`], [`disassembly`] | cycles estimated from the emulator's trace; the decoder compared with objdump |
//! | [`micro`] | stretches of one class of instructions each: their estimates compared with the emulator and a board |
//! | [`kernels`] | source of the kernels that are counted on the chip |
//! | [`counts`] | instructions on the desk, by callgrind |
//! | [`desk`] | times on the desk, and the kernel compiler's |
//! | [`baseline`] | the gate: counts compared with `bench/baseline.toml` |
//! | [`simulators`] | the simulator's speed for one run and for many runs, compared with MuJoCo's |
//! | [`growth`] | the growth of the simulator's computing time with joints, steps, runs and threads |
//! | [`report`] | the tables of `docs/measured/kernels.md` |

mod arms;
mod baseline;
mod chip;
mod counts;
pub(crate) mod cycles;
mod desk;
mod disassembly;
mod growth;
mod json;
pub(crate) mod kernels;
pub(crate) mod micro;
mod report;
mod simulators;

use crate::toolchain::rustc_version;
use anyhow::Result;

/// Options of `bench`.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct BenchOptions {
    /// Make the present instruction counts the baseline
    #[arg(long)]
    bless: bool,
    /// Count instructions and compare them with the baseline; measure no times and write nothing
    #[arg(long)]
    gate: bool,
    /// Compare with other projects' dynamics instead; installs them from PyPI and Debian
    #[arg(long, conflicts_with_all = ["bless", "gate"])]
    peers: bool,
    /// Simulate commercially available arms instead, and write docs/measured/arms.md
    #[arg(long, conflicts_with_all = ["bless", "gate", "peers"])]
    arms: bool,
    /// Compare the simulator's speed with MuJoCo's instead, and write docs/measured/simulators.md
    #[arg(long, conflicts_with_all = ["bless", "gate", "peers", "arms"])]
    simulators: bool,
    /// Measure the growth of the simulator's computing time with joints, steps, runs and threads instead
    #[arg(long, conflicts_with_all = ["bless", "gate", "peers", "arms", "simulators"])]
    growth: bool,
    #[command(flatten)]
    growth_options: growth::GrowthOptions,
}

/// Counts, compares with the baseline, measures, and writes the tables.
pub(crate) fn run(options: BenchOptions) -> Result<()> {
    if options.peers {
        return crate::peers::run();
    }
    if options.arms {
        return arms::run();
    }
    if options.simulators {
        return simulators::run();
    }
    if options.growth {
        return growth::run(options.growth_options);
    }
    let chip = chip::count()?;
    let desk = counts::count()?;
    baseline::hold(&format!("chip, {}", chip.rustc), &chip.counts(), options.bless)?;
    let rustc = rustc_version("rustc")?;
    baseline::hold(&format!("desk, {rustc}"), &desk, options.bless)?;
    if options.gate {
        return Ok(());
    }
    // The counts are written first, so that they stay even if the time measurement fails.
    report::write(&report::Counts { chip, desk, rustc }.tables()?)?;
    let times = [desk::measure(false)?, desk::measure(true)?];
    report::write(&report::Clock { times, compile: desk::compile_times()? }.tables()?)
}

/// The gate of `cargo xtask test`: counts only.
pub(crate) fn gate() -> Result<()> {
    run(BenchOptions { gate: true, ..BenchOptions::default() })
}
