//! The firmware in the emulator, its log decoded.

use anyhow::{Context as _, Result, bail};
use defmt_decoder::{DecodeError, Table};
use std::io::Read as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Start the emulator on a program, print its log, and stop after `limit` or when the program ends.
pub(crate) fn run(elf: &Path, limit: Option<Duration>) -> Result<()> {
    crate::setup::qemu()?;
    let program = std::fs::read(elf)?;
    let table = Table::parse(&program)?.context("the program has no log strings: is it the firmware?")?;
    let mut child = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start qemu-system-arm")?;
    let mut log = child.stdout.take().context("the emulator's output is piped")?;
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || {
        let mut buffer = [0; 4096];
        while let Ok(count @ 1..) = log.read(&mut buffer) {
            if send.send(buffer[..count].to_vec()).is_err() {
                return;
            }
        }
    });
    let printed = print_log(&table, &receive, limit);
    // Ended by itself: the firmware gave up, and its log says why.
    let ended = child.try_wait()?;
    child.kill().ok();
    child.wait()?;
    printed?;
    match ended {
        Some(status) if !status.success() => bail!("the program stopped by itself: {status}"),
        _ => Ok(()),
    }
}

/// Run a program that prints over semihosting and ends by itself; an instruction takes 1 ns of its time.
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

fn print_log(table: &Table, receive: &mpsc::Receiver<Vec<u8>>, limit: Option<Duration>) -> Result<()> {
    let end = limit.map(|limit| Instant::now() + limit);
    let mut decoder = table.new_stream_decoder();
    loop {
        let left = end.map_or(Duration::from_secs(3600), |end| end.saturating_duration_since(Instant::now()));
        match receive.recv_timeout(left) {
            Ok(bytes) => decoder.received(&bytes),
            Err(mpsc::RecvTimeoutError::Timeout) if end.is_none() => {}
            Err(_) => return Ok(()),
        }
        loop {
            match decoder.decode() {
                Ok(frame) => println!("{}", frame.display(false)),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) if table.encoding().can_recover() => {}
                Err(DecodeError::Malformed) => bail!("the log cannot be decoded"),
            }
        }
    }
}
