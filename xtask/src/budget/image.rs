//! What the linked program shows without being run.

use anyhow::{Context as _, Result, bail};
use chip_image::Program;
use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind, elf};
use std::path::Path;

/// Bytes of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Image {
    /// Code, constants, and what variables start with.
    pub(crate) flash: u64,
    /// Variables, and code that runs from RAM; the stack is not among it.
    pub(crate) ram: u64,
    /// The stack at its deepest, all interrupts on each other.
    pub(crate) stack_bound: u64,
}

impl Image {
    /// Measure a linked program.
    pub(crate) fn measure(elf: &Path) -> Result<Self> {
        let bytes = std::fs::read(elf).with_context(|| elf.display().to_string())?;
        let (flash, ram) = memory(&bytes)?;
        let stack = Program::parse(&bytes)?.stack()?;
        if !stack.unknown.is_empty() {
            bail!("{}: the stack of {} cannot be bounded", elf.display(), stack.unknown.join(", "));
        }
        Ok(Self { flash, ram, stack_bound: stack.bytes() })
    }
}

/// Bytes in flash and in RAM.
fn memory(bytes: &[u8]) -> Result<(u64, u64)> {
    let file = object::File::parse(bytes)?;
    let (mut flash, mut ram) = (0, 0);
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 || section.size() == 0 {
            continue;
        }
        let zeroed = matches!(section.kind(), SectionKind::UninitializedData);
        let writable = sh_flags & u64::from(elf::SHF_WRITE) != 0;
        // Initial values of variables lie in flash, and are copied to RAM.
        flash += if zeroed { 0 } else { section.size() };
        ram += if writable || zeroed { section.size() } else { 0 };
    }
    Ok((flash, ram))
}
