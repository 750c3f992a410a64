//! What the firmware takes of the chip's memory, held to budgets from above and below.

use crate::firmware::Board;
use crate::process::root;
use anyhow::{Context as _, Result, bail};
use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind, elf};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Allowed bytes, from and to.
#[derive(Deserialize)]
struct Range {
    min: u64,
    max: u64,
}

#[derive(Deserialize)]
struct Budget {
    flash: Range,
    ram: Range,
}

/// Bytes in flash and in RAM.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Size {
    flash: u64,
    ram: u64,
}

/// Print the sections and hold the sums to `firmware/budgets.toml`.
///
/// From below too: a program that suddenly shrinks has lost something, and nobody has said so.
pub(crate) fn check(elf: &Path, board: Board) -> Result<()> {
    let size = measure(elf)?;
    let file = root().join("firmware/budgets.toml");
    let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
    let budgets: BTreeMap<String, Budget> = toml::from_str(&text)?;
    let Some(budget) = budgets.get(board.name()) else { bail!("{} has no budget for {board}", file.display()) };
    let mut kept = true;
    for (name, bytes, Range { min, max }) in [("flash", size.flash, &budget.flash), ("RAM", size.ram, &budget.ram)] {
        let verdict = match bytes {
            bytes if bytes < *min => "BELOW",
            bytes if bytes > *max => "OVER",
            _ => "within",
        };
        kept &= verdict == "within";
        println!("{name:<16}{bytes:>8}   {verdict} the budget of {min} to {max}");
    }
    if !kept {
        bail!("the firmware's size left its budget; if that is meant, change {} and say why", file.display());
    }
    Ok(())
}

fn measure(elf: &Path) -> Result<Size> {
    let bytes = std::fs::read(elf)?;
    let file = object::File::parse(&*bytes)?;
    let mut size = Size::default();
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 || section.size() == 0 {
            continue;
        }
        let zeroed = matches!(section.kind(), SectionKind::UninitializedData);
        let writable = sh_flags & u64::from(elf::SHF_WRITE) != 0;
        // Initial values of variables lie in flash, and are copied to RAM.
        size.flash += if zeroed { 0 } else { section.size() };
        size.ram += if writable || zeroed { section.size() } else { 0 };
        println!("{:<16}{:>8}", section.name()?, section.size());
    }
    Ok(size)
}
