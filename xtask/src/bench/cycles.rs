//! `cargo xtask cycles`: estimates the cycles of kernels from the emulator's trace, and writes the tables of `docs/measured/cycles.md`.

use super::chip::{self, Counted};
use super::disassembly;
use super::report::{ARMS, LEVELS};
use crate::measured::write_into;
use crate::table::{Table, thousands};
use anyhow::{Context as _, Result, ensure};
use chip_image::cycles::{Estimate, Memory, Placement, calls, timing};
use std::ops::Range;

/// The kernel whose instructions are listed by class.
const LISTED: &str = "puma560_exact_with_trig";

/// Plausible range of estimated cycles per instruction, for a kernel that has run before. The estimates of all kernels are 1.64 to 1.84 from flash
/// and 1.60 to 1.74 from SRAM; the range adds about 10 % on both sides. The bound is per instruction, so that it also holds if another compiler makes
/// a kernel longer or shorter.
const FROM_FLASH: Range<f64> = 1.47..2.03;
const FROM_SRAM: Range<f64> = 1.44..1.91;

/// A function, and the estimates of its calls.
struct Traced {
    name: String,
    /// Its first call from flash, with empty caches.
    first: Estimate,
    /// Its last call from flash.
    flash: Estimate,
    sram: Estimate,
    least: u64,
    most: u64,
}

/// Traces the kernels, compares them with the program's own counts and with the bounds, and prints the tables or writes them.
pub(crate) fn run(write: bool) -> Result<()> {
    let counted = chip::count()?;
    match disassembly::compare(&counted.elf, &counted.program)? {
        Some(compared) => println!("decoder: {compared} instructions as objdump lists them"),
        None => println!("decoder: SKIPPED, there is no arm-none-eabi-objdump to compare with"),
    }
    let all = traced(&counted)?;
    let (kernels, empty) = all.split_at(all.len() - 1);
    let empty = empty.first().map_or(0, |empty| empty.most);
    for function in kernels {
        hold(function, &counted, empty)?;
    }
    let tables = [("cycles", cycle_table(kernels)), ("cycles by class", class_table(kernels)?)];
    if write {
        return write_into("docs/measured/cycles.md", &tables);
    }
    for (name, table) in tables {
        println!("{name}\n{table}");
    }
    Ok(())
}

/// Part of the symbol of the function that counts a call, in programs that use `probe::Counter`.
pub(crate) const COUNTER: &str = "Counter4call";

/// An empty function. The program subtracts its count from all others.
const EMPTY: &str = "cases7nothing";

/// The recursion's kernels, alone and with sine and cosine, in every state in which the program counts them; the empty function is last.
fn traced(counted: &Counted) -> Result<Vec<Traced>> {
    let program = &counted.program;
    let mut names = Vec::new();
    for (arm, _) in ARMS {
        for level in LEVELS {
            names.extend(["", "_with_trig"].map(|with| format!("{arm}_{level}{with}")));
        }
    }
    let mut starts = names.iter().map(|name| Ok(counted.row(name)?.address)).collect::<Result<Vec<_>>>()?;
    starts.push(program.address_of(|name| name.contains(EMPTY)).with_context(|| format!("no function {EMPTY}"))?);
    names.push(EMPTY.to_owned());
    let memories = [Placement::Flash, Placement::Sram].map(Memory::new);
    let traced = |(name, mut calls): (String, Vec<[Estimate; 2]>)| {
        let lengths = calls.iter().map(|[flash, _]| flash.instructions);
        let (least, most) = (lengths.clone().min().unwrap_or(0), lengths.max().unwrap_or(0));
        let first = calls.first().map(|[flash, _]| flash.clone()).unwrap_or_default();
        let [flash, sram] = calls.pop().unwrap_or_default();
        Traced { name, first, flash, sram, least, most }
    };
    let calls = calls(&counted.elf, program, COUNTER, &starts, memories)?;
    Ok(names.into_iter().zip(calls).map(traced).collect())
}

/// Checks a trace: it has as many instructions as the chip's timer counted, the decoder knows all of them, and the cycles are within bounds.
fn hold(function: &Traced, counted: &Counted, empty: u64) -> Result<()> {
    let Traced { name, flash, sram, least, most, .. } = function;
    let row = counted.row(name)?;
    // The program subtracts the cost of an empty call.
    ensure!(
        (*least, *most) == (row.least + empty, row.most + empty),
        "{name}: {least} to {most} instructions traced, {} to {} and {empty} of a call counted by the chip's timer",
        row.least,
        row.most
    );
    for (estimate, from, bounds) in [(flash, "flash", FROM_FLASH), (sram, "SRAM", FROM_SRAM)] {
        let each = estimate.cycles.likely as f64 / estimate.instructions as f64;
        ensure!(estimate.unknown == 0, "{name}: {} instructions that the decoder does not know", estimate.unknown);
        ensure!(
            estimate.cycles.low <= estimate.cycles.likely && estimate.cycles.likely <= estimate.cycles.high,
            "{name} from {from}: {:?} is out of order",
            estimate.cycles
        );
        ensure!(
            bounds.contains(&each),
            "{name} from {from}: {each:.3} cycles an instruction, expected {:.3} to {:.3}",
            bounds.start,
            bounds.end
        );
    }
    Ok(())
}

/// `likely (low to high)`
fn cycles(estimate: &Estimate) -> String {
    let range = estimate.cycles;
    format!("{} ({} to {})", thousands(range.likely), thousands(range.low), thousands(range.high))
}

fn cycle_table(all: &[Traced]) -> String {
    let mut table = Table::new(&[
        "kernel",
        "instructions",
        "flash, first run",
        "flash, later runs",
        "waiting for flash: code / constants",
        "SRAM",
        "microseconds at 168 MHz, flash / SRAM",
    ]);
    for Traced { name, first, flash, sram, .. } in all {
        let us = |estimate: &Estimate| estimate.cycles.likely as f64 * 1e6 / timing::CLOCK as f64;
        table.row(&[
            format!("`{name}`"),
            thousands(flash.instructions),
            cycles(first),
            cycles(flash),
            format!("{} / {}", thousands(flash.stalls.fetch), thousands(flash.stalls.literal)),
            cycles(sram),
            format!("{:.2} / {:.2}", us(flash), us(sram)),
        ]);
    }
    table.0
}

fn class_table(all: &[Traced]) -> Result<String> {
    let function = all.iter().find(|function| function.name == LISTED).context("the listed kernel is not traced")?;
    let mut table = Table::new(&["class", "instructions"]);
    let mut classes: Vec<_> = function.flash.histogram.iter().collect();
    classes.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    for (class, count) in classes {
        table.row(&[class.to_string(), thousands(*count)]);
    }
    for (from, estimate) in [("flash", &function.flash), ("SRAM", &function.sram)] {
        let stalls = estimate.stalls;
        for (what, count) in [
            ("code", stalls.fetch),
            ("constants", stalls.literal),
            ("refill behind a branch", stalls.refill),
            ("a result", stalls.result),
            ("the float unit", stalls.unit),
            ("the bus", stalls.bus),
        ] {
            if count > 0 {
                table.row(&[format!("from {from}, cycles waiting: {what}"), thousands(count)]);
            }
        }
    }
    Ok(table.0)
}
