//! Runs of the firmware in the emulator, with its log decoded.

use crate::process::{cargo, run as run_command};
use anyhow::{Context as _, Result, bail, ensure};
use firmware_image::child_process::ChildProcess;
use firmware_image::log_strings;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Processor time after which an emulator is killed: one whose log a person reads, and one whose program prints its results and ends.
const LOGGED: Duration = Duration::from_secs(6 * 3600);
const LONGEST: Duration = Duration::from_secs(600);

/// Arguments of cargo for the program that decodes logs.
const LOG: [&str; 5] = ["--quiet", "--locked", "--package=chip-image", "--features=log", "--bin=chip-log"];

/// Starts the emulator on a program and prints its log. Stops after `limit`, or when the program ends.
pub(crate) fn run(elf: &Path, limit: Option<Duration>) -> Result<()> {
    firmware_image::install::qemu()?;
    // The emulator's log comes over semihosting; RTT is needed only with a probe.
    log_strings::count(elf)?;
    // Build the decoder before the emulator starts, because the emulator does not wait for a reader of its log.
    run_command(cargo(["build"]).args(LOG))?;
    let mut emulator = Command::new("qemu-system-arm");
    emulator
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf);
    let mut process = ChildProcess::spawn(&emulator, LOGGED, Stdio::piped(), Stdio::inherit())
        .context("cannot start qemu-system-arm")?;
    let log = process.child().stdout.take().context("the emulator's output is piped")?;
    let mut words = cargo(["run"]).args(LOG).arg("--").arg(elf).stdin(log).spawn().context("cannot start cargo")?;
    let end = limit.map(|limit| Instant::now() + limit);
    let printed = loop {
        if let Some(status) = words.try_wait()? {
            break status.success();
        }
        if end.is_some_and(|end| Instant::now() >= end) {
            break true;
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    // If the emulator has ended before the limit, the firmware stopped with an error, and its log gives the reason.
    let ended = process.child().try_wait()?;
    process.end();
    // Wait until the decoder has printed the rest of the pipe.
    words.wait()?;
    ensure!(printed, "the log cannot be decoded");
    match ended {
        Some(status) if !status.success() => bail!("the program stopped by itself: {status}"),
        _ => Ok(()),
    }
}

/// Runs a program that prints over semihosting and then ends. One instruction takes 1 ns of emulated time.
pub(crate) fn semihosted(elf: &Path) -> Result<String> {
    semihosted_by(Command::new("qemu-system-arm").args(["-M", "netduinoplus2"]), elf)
}

/// As [`semihosted`], by a command that names the emulator and the machine.
pub(crate) fn semihosted_by(emulator: &mut Command, elf: &Path) -> Result<String> {
    emulator
        .args(["-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf);
    let output = ChildProcess::output(emulator, LONGEST, true).with_context(|| format!("cannot start {emulator:?}"))?;
    // The emulator writes semihosting debug messages to its standard error, and semihosting files to its standard output.
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("{} gave up in the emulator: {}\n{said}", elf.display(), output.status);
    }
    Ok(said)
}
