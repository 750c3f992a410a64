//! `cargo xtask bench`: costs of the code on the desk and on the chip, and `docs/measured/kernels.md` from them.
//!
//! | module | holds |
//! |---|---|
//! | [`arms`] | arms that people own, with their drives, in simulation |
//! | [`chip`] | instructions in the emulator; bytes and stack traffic in the linked program |
//! | [`cycles`], [`disassembly`] | cycles estimated from the emulator's trace; the decoder compared with objdump |
//! | [`micro`] | instructions of one class each: their estimates beside the emulator and a board |
//! | [`kernels`] | source of the kernels that are counted on the chip |
//! | [`counts`] | instructions on the desk, by callgrind |
//! | [`desk`] | times on the desk, and the kernel compiler's |
//! | [`baseline`] | the gate: counts compared with `bench/baseline.toml` |
//! | [`simulators`] | the simulator's speed, alone and side by side, beside MuJoCo's |
//! | [`report`] | the tables of `docs/measured/kernels.md` |

mod arms;
mod baseline;
mod chip;
mod counts;
pub(crate) mod cycles;
mod desk;
mod disassembly;
mod json;
pub(crate) mod kernels;
pub(crate) mod micro;
mod report;
mod simulators;

use crate::toolchain::rustc_version;
use anyhow::Result;

/// Options of `bench`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct BenchOptions {
    /// Make the instruction counts of now the baseline
    #[arg(long)]
    bless: bool,
    /// Count instructions and hold them to the baseline; measure no time and write nothing
    #[arg(long)]
    gate: bool,
    /// Measure other people's dynamics beside ours instead, installing them from PyPI and Debian
    #[arg(long, conflicts_with_all = ["bless", "gate"])]
    peers: bool,
    /// Simulate arms that people own instead, and write docs/measured/arms.md
    #[arg(long, conflicts_with_all = ["bless", "gate", "peers"])]
    arms: bool,
    /// Measure the simulator beside MuJoCo instead, and write docs/measured/simulators.md
    #[arg(long, conflicts_with_all = ["bless", "gate", "peers", "arms"])]
    simulators: bool,
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
    run(BenchOptions { bless: false, gate: true, peers: false, arms: false, simulators: false })
}
