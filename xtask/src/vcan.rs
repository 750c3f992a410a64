//! `cargo xtask vcan`: `newtau drive` at SocketCAN's virtual interface, in an emulated PC with Debian's kernel.
//!
//! Few kernels of test machines have the module `vcan`. So the program, a simulated arm (`vcan-arm`) and a script are packed into a file system for the emulator,
//! and the script's results come back over the emulated serial port.

use crate::process::{cargo, root, run, target_directory, which};
use anyhow::{Context as _, Result, bail, ensure};
use firmware_image::child_process::ChildProcess;
use firmware_image::install::apt;
use firmware_image::process::line_channel;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest run of the emulator. It interprets every instruction of the PC.
const LONGEST: Duration = Duration::from_secs(400);

/// Memory of the PC.
const MEMORY: &str = "1500M";

/// Modules of the kernel, in the order in which they are loaded.
const MODULES: [&str; 4] =
    ["net/can/can.ko", "net/can/can-raw.ko", "drivers/net/can/dev/can-dev.ko", "drivers/net/can/vcan.ko"];

/// The script that the kernel starts. Each line `RESULT name: ok` or `RESULT name: bad` is a result.
const SCRIPT: &str = include_str!("vcan/init.sh");

/// Names of all results.
const RESULTS: [&str; 6] = ["scan", "session", "second program", "interface down", "killed", "no interface"];

/// Runs everything.
pub(crate) fn check() -> Result<()> {
    for (program, package) in
        [("qemu-system-x86_64", "qemu-system-x86"), ("busybox", "busybox-static"), ("cpio", "cpio")]
    {
        if which(program).is_none() {
            apt(&[package])?;
        }
    }
    run(cargo([
        "build",
        "--locked",
        "--package",
        "host-sim",
        "--package",
        "trials",
        "--bin",
        "newtau",
        "--bin",
        "vcan-arm",
    ])
    .current_dir(root()))?;
    let folder = target_directory().join("vcan");
    let (kernel, modules) = kernel(&folder)?;
    let files = file_system(&folder, &modules)?;
    let results = boot(&kernel, &files)?;
    for name in RESULTS {
        let found: Vec<_> = results.iter().filter(|(result, _)| result == name).collect();
        ensure!(matches!(found.as_slice(), [(_, true)]), "vcan: {name}: not ok; the output is above");
    }
    eprintln!("vcan: {} results, all ok", RESULTS.len());
    Ok(())
}

/// Debian's kernel and its modules, unpacked.
fn kernel(folder: &Path) -> Result<(PathBuf, PathBuf)> {
    let unpacked = folder.join("kernel");
    if !unpacked.join("boot").is_dir() {
        fs::create_dir_all(folder)?;
        let listed = Command::new("apt-cache").args(["depends", "linux-image-amd64"]).output()?;
        let listed = String::from_utf8(listed.stdout)?;
        let is_version = |name: &str| {
            name.strip_prefix("linux-image-").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        };
        let package = listed.split_whitespace().find(|word| is_version(word));
        let package = package.context("Debian's package linux-image-amd64 is not known here")?;
        run(Command::new("apt-get").args(["download", "--quiet", package]).current_dir(folder))?;
        let file = newest(folder, "linux-image-")?;
        run(Command::new("dpkg-deb").arg("-x").args([&file, &unpacked]))?;
        fs::remove_file(file)?;
    }
    let kernel = newest(&unpacked.join("boot"), "vmlinuz-")?;
    let modules = newest(&unpacked.join("lib/modules"), "")?;
    Ok((kernel, modules.join("kernel")))
}

/// An entry of a folder whose name begins like this.
fn newest(folder: &Path, begin: &str) -> Result<PathBuf> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    let named = |path: &&PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(begin));
    paths.iter().filter(named).max().cloned().with_context(|| format!("{}: no {begin}", folder.display()))
}

/// Packs the programs, what they are linked with, robots and scenes, modules and the script.
fn file_system(folder: &Path, modules: &Path) -> Result<PathBuf> {
    let tree = folder.join("tree");
    if tree.exists() {
        fs::remove_dir_all(&tree)?;
    }
    for name in ["bin", "proc", "sys", "dev", "tmp", "modules", "project"] {
        fs::create_dir_all(tree.join(name))?;
    }
    let busybox = which("busybox").context("busybox is not on the path")?;
    fs::copy(busybox, tree.join("bin/busybox"))?;
    for program in ["newtau", "vcan-arm"] {
        let from = target_directory().join("debug").join(program);
        fs::copy(&from, tree.join("bin").join(program)).with_context(|| from.display().to_string())?;
        libraries(&from, &tree)?;
    }
    for module in MODULES {
        let from = modules.join(module);
        let name = from.file_name().context("a module's name")?;
        fs::copy(&from, tree.join("modules").join(name)).with_context(|| from.display().to_string())?;
    }
    for part in ["robots", "scenes"] {
        run(Command::new("cp").arg("-r").arg(root().join(part)).arg(tree.join("project")))?;
    }
    fs::write(tree.join("init"), SCRIPT)?;
    run(Command::new("chmod").arg("+x").arg(tree.join("init")))?;
    let packed = folder.join("files.cpio");
    let pack = format!("find . | cpio --quiet -o -H newc > {}", packed.display());
    run(Command::new("sh").args(["-c", &pack]).current_dir(&tree))?;
    Ok(packed)
}

/// Copies the shared libraries of a program.
fn libraries(program: &Path, tree: &Path) -> Result<()> {
    let listed = Command::new("ldd").arg(program).output().context("cannot start ldd")?;
    let listed = String::from_utf8(listed.stdout)?;
    for path in listed.split_whitespace().filter(|word| word.starts_with('/')) {
        let to = tree.join(path.trim_start_matches('/'));
        fs::create_dir_all(to.parent().context("a library in a folder")?)?;
        fs::copy(path, to).with_context(|| path.to_owned())?;
    }
    Ok(())
}

/// Starts the PC, prints what it prints, and returns its results.
fn boot(kernel: &Path, files: &Path) -> Result<Vec<(String, bool)>> {
    let mut qemu = Command::new("qemu-system-x86_64");
    qemu.args([
        "-cpu",
        "max",
        "-smp",
        "2",
        "-m",
        MEMORY,
        "-nographic",
        "-no-reboot",
        "-nic",
        "none",
        "-accel",
        "tcg,thread=multi",
    ]);
    qemu.arg("-kernel").arg(kernel).arg("-initrd").arg(files).args(["-append", "console=ttyS0 quiet panic=-1"]);
    let mut process = ChildProcess::spawn(&qemu, 4 * LONGEST, Stdio::piped(), Stdio::inherit())
        .context("cannot start qemu-system-x86_64")?;
    let output = process.child().stdout.take().context("the emulator's output is piped")?;
    let received = line_channel(BufReader::new(output));
    let (begun, mut results) = (Instant::now(), Vec::new());
    loop {
        match received.recv_timeout(LONGEST.saturating_sub(begun.elapsed())) {
            Ok(line) => {
                eprintln!("{line}");
                if let Some((name, ok)) = line.trim().strip_prefix("RESULT ").and_then(|rest| rest.split_once(": ")) {
                    results.push((name.to_owned(), ok == "ok"));
                }
            }
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {
                bail!("vcan: the emulated PC did not end within {LONGEST:?}");
            }
        }
    }
    process.child().wait()?;
    Ok(results)
}
