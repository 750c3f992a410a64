//! Start and end of the emulator, and the lines of its log.

use crate::ImageError;
use firmware_image::child_process::ChildProcess;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// The emulator's program.
const QEMU: &str = "qemu-system-arm";

/// Errors of a trace.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The emulator is not installed, or may not be run.
    #[error("cannot start {QEMU}: {0}")]
    CannotStart(#[source] std::io::Error),
    /// The version is not at its expected position in the output.
    #[error("{QEMU} --version says {0:?}; expected \"QEMU emulator version MAJOR.MINOR\"")]
    Version(String),
    /// The program contains no call that the trace could count.
    #[error("nothing in the program counts calls")]
    CountsNothing,
    /// A function to be traced does not exist.
    #[error(transparent)]
    Function(#[from] ImageError),
    /// The pipe from the emulator broke.
    #[error("the emulator's log cannot be read: {0}")]
    Log(#[source] std::io::Error),
    /// The program failed, or the emulator did.
    #[error("the emulated program gave up: {status}\n{said}")]
    GaveUp {
        /// Its exit status.
        status: std::process::ExitStatus,
        /// The emulator's output, without the trace.
        said: String,
    },
}

/// Option that makes the installed emulator translate one instruction per block.
///
/// # Errors
/// The emulator cannot be started, or does not print its version.
pub(crate) fn one_instruction_a_block() -> Result<&'static [&'static str], Error> {
    let output = Command::new(QEMU).arg("--version").output().map_err(Error::CannotStart)?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    option_for(&text).ok_or(Error::Version(text))
}

/// Since 8.1 it is a property of the accelerator; 9.2 no longer accepts the older option.
fn option_for(version: &str) -> Option<&'static [&'static str]> {
    let mut numbers = version.strip_prefix("QEMU emulator version ")?.split(['.', ' ', '\n']).map(str::parse::<u32>);
    let found = (numbers.next()?.ok()?, numbers.next()?.ok()?);
    Some(if found >= (8, 1) { &["-accel", "tcg,one-insn-per-tb=on"] } else { &["-singlestep"] })
}

/// Processor time after which an emulator is killed. The slowest traces are those of double precision, some minutes.
const LONGEST: Duration = Duration::from_secs(3600);

/// Starts the emulator for a program that ends without being stopped; the log comes on standard error.
pub(crate) fn start(elf: &Path, options: &[&str]) -> Result<ChildProcess, Error> {
    let mut emulator = Command::new(QEMU);
    emulator
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-semihosting-config", "enable=on,target=native"])
        .args(options)
        .arg("-kernel")
        .arg(elf);
    ChildProcess::spawn(&emulator, LONGEST, Stdio::null(), Stdio::piped()).map_err(Error::CannotStart)
}

/// A line of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// `Trace 0: 0x7f... [flags/pc/flags/flags] function`.
    Executed(u32),
    /// The previous block was not executed after all: an access to a device restarts it, or the instruction count ran out before it. It is logged
    /// again.
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

#[cfg(test)]
mod tests {
    use super::{Line, option_for};

    #[test]
    fn each_emulator_gets_options_of_its_own_syntax() {
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
}
