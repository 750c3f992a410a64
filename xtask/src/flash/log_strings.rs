//! Whether what a program logs can be read by whoever holds its file.

use crate::qemu::log_strings;
use anyhow::{Context as _, Result, bail};
use chip_image::Program;
use std::path::Path;

/// What a probe looks for in the chip's memory to find the log.
const RTT_CONTROL_BLOCK: &str = "_SEGGER_RTT";

/// The number of strings that the program can log.
///
/// A log travels as numbers; the strings lie in the program's file, in a section that the linker script `defmt.x` makes, and
/// the bytes are found through RTT's control block. Without either the log is lost, and nothing else would say so.
///
/// # Errors
/// A file that cannot be read, one without strings, or one without the control block.
pub(crate) fn check(elf: &Path) -> Result<usize> {
    let program = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let strings = log_strings(elf)?;
    if strings == 0 {
        bail!("{}: found no log strings, expected a program that was linked with defmt.x", elf.display());
    }
    if !Program::parse(&program)?.symbols().any(|(name, _)| name == RTT_CONTROL_BLOCK) {
        bail!("{}: found no {RTT_CONTROL_BLOCK}, expected a program that logs over RTT", elf.display());
    }
    Ok(strings)
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn a_program_whose_log_nobody_could_read_is_refused() {
        let this = std::env::current_exe().unwrap();
        let error = check(&this).unwrap_err().to_string();
        assert!(error.contains("found no log strings"), "{error}");
    }
}
