//! Regions of the memory protection unit that make the tick's code read-only.
//!
//! The processor can also write to single bits of SRAM, at other addresses ([`BIT_ALIAS`]). The unit checks the address that the program uses, in the
//! emulator too, so a further region forbids those addresses. No chip has run this yet.
//!
//! A region has a size of a power of two and begins at a multiple of it. Its eight parts can be switched off one by one (Arm DDI 0403, B3.5). So one
//! region covers the middle of the code, in eighths of the smallest block that holds all of it. Smaller regions cover what is left at both ends.

use heapless::Vec;

/// Multiple of bytes at which the code begins and ends (`tick.x`).
pub const GRAIN: u32 = 256;

/// Number of regions that a Cortex-M4 has.
pub const MAX_REGIONS: usize = 8;

/// Address of 32 MiB in which each word stands for a bit of SRAM (Arm DDI 0403, B3.1 and ST PM0214, 2.2.5).
pub const BIT_ALIAS: u32 = 0x2200_0000;

/// No access, no execution, 32 MiB.
const FORBIDDEN: u32 = 1 << 28 | 24 << 1 | 1;

/// Values of the registers RBAR and RASR for one region. RBAR selects the region too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Address, number of the region, and the bit that makes the number valid.
    pub base: u32,
    /// Access, kind of memory, switched-off parts, size.
    pub attributes: u32,
}

/// Read-only for all code, and executable; memory on the chip, cached as write-through (ST PM0214, table 42).
const READ_ONLY: u32 = 0b110 << 24 | 1 << 18 | 1 << 17;

/// Returns all regions of the unit: they make `start..end` read-only and forbid [`BIT_ALIAS`]; the others are off. `None` if the range is empty, if an end
/// is no multiple of [`GRAIN`], or if more regions are needed than there are; 128 KiB that begin at a multiple of their size need no more than there are.
#[must_use]
pub fn read_only(start: u32, end: u32) -> Option<[Region; MAX_REGIONS]> {
    let mut regions = Vec::new();
    if start >= end || !start.is_multiple_of(GRAIN) || !end.is_multiple_of(GRAIN) {
        return None;
    }
    let mut block = (start ^ (end - 1)).checked_add(1)?.checked_next_power_of_two()?.max(8 * GRAIN);
    let part = block / 8;
    let (mut from, mut to) = (start.next_multiple_of(part), end / part * part);
    add(&mut regions, block, from, to)?;
    block = part;
    while from != start || to != end {
        let part = block / 8;
        let (before, after) = (start.next_multiple_of(part), end / part * part);
        add(&mut regions, block, before, from)?;
        add(&mut regions, block, to, after)?;
        (from, to, block) = (before, after, part);
    }
    push(&mut regions, BIT_ALIAS, FORBIDDEN)?;
    while !regions.is_full() {
        push(&mut regions, 0, 0)?;
    }
    regions.into_array().ok()
}

/// Adds a region with the next number.
fn push(regions: &mut Vec<Region, MAX_REGIONS>, address: u32, attributes: u32) -> Option<()> {
    let number = u32::try_from(regions.len()).ok()?;
    regions.push(Region { base: address | 1 << 4 | number, attributes }).ok()
}

/// Adds the region that covers `from..to` in its block, unless that is nothing.
fn add(regions: &mut Vec<Region, MAX_REGIONS>, block: u32, from: u32, to: u32) -> Option<()> {
    if from >= to {
        return Some(());
    }
    let base = from / block * block;
    let part = |address: u32| (address - base) / (block / 8);
    let on = (part(from)..part(to)).fold(0, |on, part| on | 1 << part);
    push(regions, base, READ_ONLY | (!on & 0xFF) << 8 | (block.trailing_zeros() - 1) << 1 | 1)
}
