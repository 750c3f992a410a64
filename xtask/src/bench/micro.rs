//! `cargo xtask cycles --micro` and `--port`: stretches of one class of instructions each, estimated, counted in the emulator, and measured on a
//! board.
//!
//! The board runs the same program that is estimated (`firmware/probe/src/bin/probe-micro`). So a difference is an error of the estimate, and a
//! stretch outside its range shows which rule is wrong.

mod port;
mod report;

use crate::qemu;
use crate::table::{Table, thousands};
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result, bail, ensure};
use chip_image::Program;
use chip_image::cycles::steps::{self, Detail, Event};
use chip_image::cycles::{Estimate, Estimator, Memory, Placement};
use firmware_image::{BadInput, flash, install};
use report::{StretchRow, rows};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A stretch that returns at once. Its count is the cost of a call and is subtracted from all others.
const NOTHING: &str = "nothing_flash";

/// Cycles by which a measured stretch may leave its range. The call and the counter readings are at another offset in a flash line than those of the
/// stretch that returns at once.
const SLACK: u64 = 8;

/// A stretch with its estimate.
#[derive(Clone, Debug)]
struct Stretch {
    name: String,
    /// Instructions; the emulator's count and its trace agree.
    instructions: u64,
    /// Cycles: low, likely, high.
    cycles: [u64; 3],
}

/// Estimates the stretches. If a port is given, compares them with the board on it, which is flashed first if `flashes`.
///
/// # Errors
/// [`BadInput`]: there is no such port, or no such program on it. Any other failure, including a stretch outside its range.
pub(crate) fn run(port: Option<&str>, flashes: bool) -> Result<()> {
    let (elf, stretches) = estimated()?;
    let Some(port) = port else {
        println!("{}", table(&stretches));
        println!(
            "on a board: `cargo xtask cycles --port PORT --flash`, or write {} yourself and leave --flash out",
            elf.display()
        );
        return Ok(());
    };
    if flashes {
        flash::write_program(&elf)?;
    }
    let (table, outside) = compare(&stretches, &port::read(port)?)?;
    println!("{table}");
    ensure!(outside.is_empty(), "outside their ranges: {}", outside.join(", "));
    Ok(())
}

/// Builds the program, counts its stretches in the emulator, and estimates the second run of each.
fn estimated() -> Result<(PathBuf, Vec<Stretch>)> {
    install::qemu()?;
    let toolchain = Toolchain::find_or_install()?;
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--locked", "--package", "probe", "--features", "micro"]);
    let elf = toolchain::build(&mut cargo, toolchain::product("probe-micro"))?;
    let counted = rows(&qemu::semihosted(&elf)?).context("the program on the emulated chip said nothing")?;
    let program = Program::parse(&std::fs::read(&elf)?)?;
    let traced = traced(&elf, &program, &counted)?;
    let nothing = StretchRow { name: NOTHING.to_owned(), count: 0 };
    let nothing = counted.iter().find(|row| row.name == NOTHING).unwrap_or(&nothing);
    let call = traced.get(NOTHING).with_context(|| format!("no stretch {NOTHING}"))?;
    let mut stretches = Vec::new();
    for row in counted.iter().filter(|row| row.name != NOTHING) {
        let estimate = traced.get(&row.name).with_context(|| format!("{} is not in the trace", row.name))?;
        stretches.push(stretch(row, estimate, nothing, call)?);
    }
    Ok((elf, stretches))
}

/// Checks the counts of a stretch, and subtracts the cost of the call from its estimate.
fn stretch(row: &StretchRow, estimate: &Estimate, nothing: &StretchRow, call: &Estimate) -> Result<Stretch> {
    let name = &row.name;
    let counted = row.count.saturating_sub(nothing.count);
    let instructions = estimate.instructions - call.instructions;
    ensure!(
        counted == instructions,
        "{name}: {instructions} instructions traced, {counted} counted by the chip's timer"
    );
    ensure!(estimate.unknown == 0, "{name}: {} instructions that the decoder does not know", estimate.unknown);
    let (all, call) = (estimate.cycles, call.cycles);
    let cycles = [all.low - call.high.min(all.low), all.likely - call.likely, all.high - call.low];
    ensure!(cycles.is_sorted(), "{name}: {all:?} is out of order");
    Ok(Stretch { name: name.clone(), instructions, cycles })
}

/// Estimates of the last run of each stretch, by name. The trace covers the whole program, so that the caches have their true state.
fn traced(elf: &Path, program: &Program, rows: &[StretchRow]) -> Result<BTreeMap<String, Estimate>> {
    let mut starts = BTreeMap::new();
    for StretchRow { name, .. } in rows {
        let symbol = format!("micro_{name}");
        let start = program.address_of(|other| other == symbol).with_context(|| format!("no function {symbol}"))?;
        starts.insert(start, name.clone());
    }
    let mut estimator = Estimator::new(program, Memory::new(Placement::ByAddress));
    let mut inside: Option<(String, u32)> = None;
    let mut estimates = BTreeMap::new();
    steps::run(elf, Detail::Registers, |event| {
        let Event::Step(step) = event else { return };
        if let Some((name, _)) = inside.take_if(|(_, back)| *back == step.address) {
            estimates.insert(name, estimator.finish());
        }
        if inside.is_none()
            && let Some(name) = starts.get(&step.address)
        {
            estimator.finish();
            // The link register holds the return address; bit 0 marks Thumb code.
            inside = Some((name.clone(), step.registers[14] & !1));
        }
        estimator.execute_with(step.address, &step.registers);
    })?;
    Ok(estimates)
}

fn table(stretches: &[Stretch]) -> String {
    let mut table = Table::new(&["stretch", "instructions", "low", "likely", "high"]);
    for stretch in stretches {
        table.row(&cells(stretch));
    }
    table.0
}

fn cells(Stretch { name, instructions, cycles: [low, likely, high] }: &Stretch) -> Vec<String> {
    let mut cells = vec![format!("`{name}`")];
    cells.extend([instructions, low, likely, high].map(|number| thousands(*number)));
    cells
}

/// Returns the table with a board's cycles, and the names of the stretches outside their ranges.
///
/// # Errors
/// [`BadInput`]: the board reports other stretches.
fn compare(stretches: &[Stretch], measured: &[StretchRow]) -> Result<(String, Vec<String>)> {
    let count = |name: &str| {
        let row = measured.iter().find(|row| row.name == name);
        row.map(|row| row.count).ok_or_else(|| {
            BadInput(format!("the board timed {} stretches, and not {name}: write this program to it", measured.len()))
        })
    };
    let call = count(NOTHING)?;
    let mut table =
        Table::new(&["stretch", "instructions", "low", "likely", "high", "measured", "measured / likely", ""]);
    let mut outside = Vec::new();
    for stretch in stretches {
        let [low, likely, high] = stretch.cycles;
        let Some(cycles) = count(&stretch.name)?.checked_sub(call) else {
            bail!("{}: fewer cycles than a call alone: the counter does not count every cycle", stretch.name)
        };
        let fits = (low.saturating_sub(SLACK)..=high + SLACK).contains(&cycles);
        let mut all = cells(stretch);
        all.push(thousands(cycles));
        all.push(format!("{:.3}", cycles as f64 / likely.max(1) as f64));
        all.push(if fits { String::new() } else { "OUTSIDE".to_owned() });
        table.row(&all);
        if !fits {
            outside.push(stretch.name.clone());
        }
    }
    Ok((table.0, outside))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{BadInput, NOTHING, SLACK, Stretch, StretchRow, compare, stretch};
    use chip_image::cycles::{Estimate, Range};

    fn row(name: &str, count: u64) -> StretchRow {
        StretchRow { name: name.to_owned(), count }
    }

    fn estimate(instructions: u64, low: u64, likely: u64, high: u64) -> Estimate {
        Estimate { instructions, cycles: Range { low, likely, high }, ..Estimate::default() }
    }

    #[test]
    fn the_cost_of_a_call_is_taken_off_counts_and_estimates() {
        let (nothing, call) = (row(NOTHING, 5), estimate(1, 3, 3, 4));
        let found = stretch(&row("vldr", 104), &estimate(100, 150, 180, 200), &nothing, &call).unwrap();
        assert_eq!((found.instructions, found.cycles), (99, [146, 177, 197]));
        let error = stretch(&row("vldr", 105), &estimate(100, 150, 180, 200), &nothing, &call).unwrap_err();
        assert_eq!(error.to_string(), "vldr: 99 instructions traced, 100 counted by the chip's timer");
        let unknown = Estimate { unknown: 2, ..estimate(100, 150, 180, 200) };
        assert!(stretch(&row("vldr", 104), &unknown, &nothing, &call).is_err());
    }

    #[test]
    fn what_leaves_its_range_by_more_than_the_slack_is_marked() {
        let stretches =
            ["a", "b", "c"].map(|name| Stretch { name: name.into(), instructions: 90, cycles: [100, 150, 200] });
        let measured = [row(NOTHING, 12), row("a", 112 - SLACK), row("b", 213 + SLACK), row("c", 162)];
        let (table, outside) = compare(&stretches, &measured).unwrap();
        assert_eq!(outside, ["b"]);
        let lines: Vec<_> = table.lines().skip(2).collect();
        assert_eq!(lines[0], "| `a` | 90 | 100 | 150 | 200 | 92 | 0.613 |  |");
        assert_eq!(lines[1], "| `b` | 90 | 100 | 150 | 200 | 209 | 1.393 | OUTSIDE |");
        assert_eq!(lines[2], "| `c` | 90 | 100 | 150 | 200 | 150 | 1.000 |  |");
    }

    #[test]
    fn another_program_on_the_board_and_a_counter_that_stands_still_are_distinguished_apart() {
        let stretches = [Stretch { name: "a".into(), instructions: 90, cycles: [100, 150, 200] }];
        for measured in [&[row("a", 100)][..], &[row(NOTHING, 12), row("b", 100)]] {
            assert!(compare(&stretches, measured).unwrap_err().is::<BadInput>(), "{measured:?}");
        }
        assert!(!compare(&stretches, &[row(NOTHING, 12), row("a", 2)]).unwrap_err().is::<BadInput>());
    }
}
