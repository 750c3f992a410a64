//! Check that a program's log can be decoded from its file.

use anyhow::{Context as _, Result, bail};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use std::path::Path;

/// Symbol that a probe searches for in the chip's memory to find the log.
const RTT_CONTROL_BLOCK: &str = "_SEGGER_RTT";

/// The section that the linker script `defmt.x` creates, with a symbol for each string.
const SECTION: &str = ".defmt";

/// Returns the number of strings that the program can log.
///
/// The log contains only numbers; the strings are in the program's file. Without them the log would be lost silently.
///
/// # Errors
/// A file that cannot be read, or one without strings.
pub fn count(elf: &Path) -> Result<usize> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    strings(&parse(&bytes, elf)?, elf)
}

/// Returns the number of strings that a probe can read from the program through RTT.
///
/// # Errors
/// As [`count`]; also a program without RTT's control block, such as one for the emulator, which logs by semihosting.
pub fn count_over_rtt(elf: &Path) -> Result<usize> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let program = parse(&bytes, elf)?;
    let strings = strings(&program, elf)?;
    if !program.symbols().any(|symbol| symbol.name() == Ok(RTT_CONTROL_BLOCK)) {
        bail!("{}: found no {RTT_CONTROL_BLOCK}, expected a program that logs over RTT", elf.display());
    }
    Ok(strings)
}

fn parse<'bytes>(bytes: &'bytes [u8], elf: &Path) -> Result<object::File<'bytes>> {
    object::File::parse(bytes).with_context(|| elf.display().to_string())
}

fn strings(program: &object::File<'_>, elf: &Path) -> Result<usize> {
    let section = program.section_by_name(SECTION).map(|section| section.index());
    // The symbols of strings are JSON. Other symbols mark levels and the version.
    let of_string = |symbol: &object::Symbol<'_, '_>| {
        section.is_some() && symbol.section_index() == section && symbol.name().is_ok_and(|name| name.starts_with('{'))
    };
    let strings = program.symbols().filter(of_string).count();
    if strings == 0 {
        bail!("{}: found no log strings, expected a program that was linked with defmt.x", elf.display());
    }
    Ok(strings)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::count_over_rtt;

    #[test]
    fn a_program_whose_log_nobody_could_read_is_refused() {
        let this = std::env::current_exe().unwrap();
        let error = count_over_rtt(&this).unwrap_err().to_string();
        assert!(error.contains("found no log strings"), "{error}");
    }
}
