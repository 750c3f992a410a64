//! The firmware in the emulator, its log decoded.

use crate::process::{cargo, run as run_command};
use anyhow::{Context as _, Result, bail, ensure};
use firmware_image::log_strings;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Arguments of cargo for the program that decodes logs.
const LOG: [&str; 6] = ["--quiet", "--locked", "--release", "--package=chip-image", "--features=log", "--bin=chip-log"];

/// Start the emulator on a program, print its log, and stop after `limit` or when the program ends.
pub(crate) fn run(elf: &Path, limit: Option<Duration>) -> Result<()> {
    firmware_image::install::qemu()?;
    // Over semihosting; only a probe needs RTT.
    log_strings::count(elf)?;
    // Built before the emulator starts, because the emulator does not wait for a reader of its log.
    run_command(cargo(["build"]).args(LOG))?;
    let mut child = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start qemu-system-arm")?;
    let log = child.stdout.take().context("the emulator's output is piped")?;
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
