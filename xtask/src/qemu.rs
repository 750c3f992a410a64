//! The firmware in the emulator, its log decoded.

use crate::process::cargo_run;
use anyhow::{Context as _, Result, bail, ensure};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The package that decodes logs.
pub(crate) const LOG: &str = "chip-log";

/// Start the emulator on a program, print its log, and stop after `limit` or when the program ends.
pub(crate) fn run(elf: &Path, limit: Option<Duration>) -> Result<()> {
    crate::setup::qemu()?;
    // Built before the emulator starts, because the emulator does not wait for a reader of its log.
    let strings = log_strings(elf)?;
    ensure!(strings > 0, "the program has no log strings: is it the firmware?");
    let mut child = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start qemu-system-arm")?;
    let log = child.stdout.take().context("the emulator's output is piped")?;
    let mut words = cargo_run(LOG).arg("print").arg(elf).stdin(log).spawn().context("cannot start cargo")?;
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
    // If the emulator has ended by itself, the firmware gave up, and its log says why.
    let ended = child.try_wait()?;
    child.kill().ok();
    child.wait()?;
    // Prints the rest of the pipe.
    words.wait()?;
    ensure!(printed, "the log cannot be decoded");
    match ended {
        Some(status) if !status.success() => bail!("the program stopped by itself: {status}"),
        _ => Ok(()),
    }
}

/// Number of strings that a program can log.
pub(crate) fn log_strings(elf: &Path) -> Result<usize> {
    let said =
        cargo_run(LOG).arg("strings").arg(elf).stderr(Stdio::inherit()).output().context("cannot start cargo")?;
    let text = String::from_utf8_lossy(&said.stdout);
    text.trim().parse().with_context(|| format!("{LOG} does not count the log strings of {}", elf.display()))
}

/// Runs a program that prints over semihosting and ends by itself; an instruction takes 1 ns of its time.
pub(crate) fn semihosted(elf: &Path) -> Result<String> {
    let output = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .output()
        .context("cannot start qemu-system-arm")?;
    // Debug messages of semihosting come on the emulator's standard error, files on its standard output.
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("{} gave up in the emulator: {}\n{said}", elf.display(), output.status);
    }
    Ok(said)
}
