//! The emulator, an instruction at a time, between addresses.
//!
//! QEMU runs blocks of instructions and can log each block that it executes; with one instruction in a block, that is each
//! instruction, with the core's registers before it. The log goes through a pipe and is never kept: it is some 350 bytes an
//! instruction.

use crate::ImageError;
use crate::cycles::steps::{Event, Step, read_saying};
use std::io::BufReader;
use std::ops::Range;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// The emulator.
const QEMU: &str = "qemu-system-arm";

/// Errors of a trace.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Not installed, or not allowed to run.
    #[error("cannot start {QEMU}: {0}")]
    CannotStart(#[source] std::io::Error),
    /// The version is not at its expected place in the output.
    #[error("{QEMU} --version says {0:?}; expected \"QEMU emulator version MAJOR.MINOR\"")]
    Version(String),
    /// The end of a call is not known.
    #[error("nothing in the program counts calls")]
    CountsNothing,
    /// A function to be traced is not known.
    #[error(transparent)]
    Function(#[from] ImageError),
    /// The pipe from it broke.
    #[error("the emulator's log cannot be read: {0}")]
    Log(#[source] std::io::Error),
    /// The program failed, or the emulator did.
    #[error("the emulated program gave up: {status}\n{said}")]
    GaveUp {
        /// Its exit status.
        status: std::process::ExitStatus,
        /// The emulator's output besides the trace.
        said: String,
    },
}

/// Option of the installed emulator for one instruction per block.
///
/// # Errors
/// The emulator cannot be started, or does not print its version.
pub(crate) fn one_instruction_a_block() -> Result<&'static [&'static str], Error> {
    let output = Command::new(QEMU).arg("--version").output().map_err(Error::CannotStart)?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    option_for(&text).ok_or(Error::Version(text))
}

/// Since 8.1 it is a property of the accelerator; 9.2 no longer knows the older option.
fn option_for(version: &str) -> Option<&'static [&'static str]> {
    let mut numbers = version.strip_prefix("QEMU emulator version ")?.split(['.', ' ', '\n']).map(str::parse::<u32>);
    let found = (numbers.next()?.ok()?, numbers.next()?.ok()?);
    Some(if found >= (8, 1) { &["-accel", "tcg,one-insn-per-tb=on"] } else { &["-singlestep"] })
}

/// Runs a program that ends by itself, and calls back for each instruction between two addresses, in the order of
/// execution.
///
/// A stretch `(start, end)` begins with the instruction at `start` and ends before the one at `end`. While one lasts, no
/// other begins. The number in the call is the stretch's place in `between`.
///
/// The ranges must hold the starts and ends, and all code between that is to be reported. This is some ten times faster
/// than logging all of a program, because the emulator does not log the rest.
///
/// # Errors
/// The emulator cannot be started, or the program fails.
pub fn run(
    elf: &Path,
    between: &[(u32, u32)],
    ranges: &[Range<u32>],
    mut on_instruction: impl FnMut(usize, &Step),
) -> Result<(), Error> {
    let ranges: Vec<String> = ranges.iter().map(|range| format!("{:#x}+{:#x}", range.start, range.len())).collect();
    let mut options = one_instruction_a_block()?.to_vec();
    let filter = ranges.join(",");
    options.extend(["-d", "exec,cpu,nochain", "-dfilter", &filter]);
    let mut child = Ended(start(elf, &options)?);
    let mut sorter = Sorter::new(between);
    let mut said = String::new();
    if let Some(log) = child.0.stderr.take() {
        said = read_saying(BufReader::with_capacity(1 << 16, log), |event| {
            if let Event::Step(step) = event
                && let Some(stretch) = sorter.stretch(step.address)
            {
                on_instruction(stretch, &step);
            }
        })?;
    }
    let status = child.0.wait().map_err(Error::Log)?;
    if !status.success() {
        return Err(Error::GaveUp { status, said });
    }
    Ok(())
}

/// Starts the emulator for a program that ends by itself; its log comes on its standard error.
pub(crate) fn start(elf: &Path, options: &[&str]) -> Result<Child, Error> {
    Command::new(QEMU)
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-semihosting-config", "enable=on,target=native"])
        .args(options)
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(Error::CannotStart)
}

/// The emulator; it is ended on every way out of the run.
pub(crate) struct Ended(pub(crate) Child);

impl Drop for Ended {
    fn drop(&mut self) {
        // Fails only if the emulator has already ended.
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// A line of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// `Trace 0: 0x7f... [flags/pc/flags/flags] function`.
    Executed(u32),
    /// The block before was not executed after all: an access to a device restarts it, or the instruction count ran out
    /// before it. It is logged again.
    Undone,
    Other,
}

impl Line {
    pub(crate) fn of(line: &[u8]) -> Self {
        if line.starts_with(b"Trace ") {
            let address = line.split(|byte| *byte == b'/').nth(1);
            let address = address.and_then(|hex| u32::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
            address.map_or(Self::Other, Self::Executed)
        } else if line.starts_with(b"cpu_io_recompile") || line.starts_with(b"Stopped execution of TB chain before") {
            Self::Undone
        } else {
            Self::Other
        }
    }
}

/// Sorts executed instructions into stretches.
struct Sorter<'a> {
    between: &'a [(u32, u32)],
    inside: Option<usize>,
}

impl<'a> Sorter<'a> {
    fn new(between: &'a [(u32, u32)]) -> Self {
        Self { between, inside: None }
    }

    /// The stretch that the instruction executed next belongs to.
    fn stretch(&mut self, address: u32) -> Option<usize> {
        if let Some((_, end)) = self.inside.and_then(|inside| self.between.get(inside))
            && *end == address
        {
            self.inside = None;
        }
        if self.inside.is_none() {
            self.inside = self.between.iter().position(|(start, _)| *start == address);
        }
        self.inside
    }
}

#[cfg(test)]
mod tests {
    use super::{Line, Sorter, option_for};

    #[test]
    fn each_emulator_is_told_in_its_own_words() {
        let says = |version: &str| option_for(version).map(<[&str]>::to_vec);
        assert_eq!(says("QEMU emulator version 7.2.22 (Debian 1:7.2)\n"), Some(vec!["-singlestep"]));
        let newer = Some(vec!["-accel", "tcg,one-insn-per-tb=on"]);
        assert_eq!(says("QEMU emulator version 8.1.0\n"), newer);
        assert_eq!(says("QEMU emulator version 10.0.2 (Debian)\n"), newer);
        assert_eq!(says("something else"), None);
    }

    #[test]
    fn lines_of_the_log_are_read() {
        let line = b"Trace 0: 0x7ff824000100 [00800408/08000188/00000110/ff020201] Reset\n";
        assert_eq!(Line::of(line), Line::Executed(0x0800_0188));
        assert_eq!(Line::of(b"cpu_io_recompile: rewound execution of TB to 080001b0\n"), Line::Undone);
        assert_eq!(Line::of(b"qemu-system-arm: warning\n"), Line::Other);
    }

    #[test]
    fn stretches_begin_with_their_start_and_end_before_their_end() {
        let between = [(10, 30), (40, 50)];
        let mut sorter = Sorter::new(&between);
        let seen = [8, 10, 12, 40, 30, 32, 40, 50, 10].map(|address| sorter.stretch(address));
        assert_eq!(seen, [None, Some(0), Some(0), Some(0), None, None, Some(1), None, Some(0)]);
    }
}
