//! Sizes of the linked program; nothing is run.

use anyhow::{Context as _, Result, bail};
use chip_image::Program;
use std::path::Path;

/// Sizes of a program in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Image {
    /// Code, constants, and initial values of variables.
    pub(crate) flash: u64,
    /// Variables; without the stack, and without code that runs from RAM.
    pub(crate) ram: u64,
    /// Worst-case stack depth, with all interrupts nested.
    pub(crate) stack_bound: u64,
}

impl Image {
    /// Measures a linked program.
    pub(crate) fn measure(elf: &Path) -> Result<Self> {
        let bytes = std::fs::read(elf).with_context(|| elf.display().to_string())?;
        let program = Program::parse(&bytes)?;
        let stack = program.stack()?;
        if !stack.unknown.is_empty() {
            bail!("{}: the stack of {} cannot be bounded", elf.display(), stack.unknown.join(", "));
        }
        let room = program.stack_room()?.len() as u64;
        if stack.bytes() > room {
            bail!(
                "{}: the stack needs up to {} bytes, and has {room} (`firmware/memory`)",
                elf.display(),
                stack.bytes()
            );
        }
        Ok(Self { flash: program.flash_bytes(), ram: program.ram_bytes(), stack_bound: stack.bytes() })
    }
}
