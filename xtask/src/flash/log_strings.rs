//! Check that a program's log can be decoded from its file.

use crate::qemu::log_strings;
use anyhow::{Context as _, Result, bail};
use chip_image::Program;
use std::path::Path;

/// Symbol that a probe looks for in the chip's memory to find the log.
const RTT_CONTROL_BLOCK: &str = "_SEGGER_RTT";

/// The number of strings that the program can log.
///
/// A log travels as numbers. The strings lie in the program's file, in a section that the linker script `defmt.x` makes,
/// and the probe finds the bytes through RTT's control block. Without either the log would be lost silently.
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
