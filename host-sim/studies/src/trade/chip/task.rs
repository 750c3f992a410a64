//! Measuring programs of `cargo xtask firmware`.

use board::chip::ChipError;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Builds and runs the program that measures a tick, for each scene of a list. Returns the output of
/// `cargo xtask firmware cost`: a JSON object on one line for each scene.
///
/// # Errors
/// As [`build_firmware`](board::chip::build_firmware); a measuring program that fails.
pub(super) fn run_cost(list: &Path) -> Result<String, ChipError> {
    xtask(["firmware", "cost", "--scenes"], list)
}

/// Builds a scene's firmware and traces its supervised ticks. Returns the output of `cargo xtask firmware interrupt`: one
/// JSON object.
///
/// # Errors
/// As [`build_firmware`](board::chip::build_firmware); a motion that the scene's controller does not follow.
pub(super) fn run_interrupt(scene: &Path) -> Result<String, ChipError> {
    let scene = scene.canonicalize().unwrap_or_else(|_| scene.to_owned());
    xtask(["firmware", "interrupt", "--scene"], &scene)
}

/// Standard output of an xtask command; an error holds its standard error.
fn xtask<const M: usize>(arguments: [&str; M], file: &Path) -> Result<String, ChipError> {
    let cargo = PathBuf::from(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let mut child = Command::new(&cargo)
        .args(["run", "--quiet", "--package", "xtask"])
        // In the profile of this program, which has compiled most of it.
        .args(if cfg!(debug_assertions) { None } else { Some("--release") })
        .arg("--")
        .args(arguments)
        .arg(file)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|source| ChipError::CannotStart { program: cargo, source })?;
    let messages = child.stderr.take().map(|pipe| std::thread::spawn(move || relay(pipe)));
    let output = child.wait_with_output()?;
    let messages = messages.and_then(|thread| thread.join().ok()).unwrap_or_default();
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(ChipError::Build { output: messages.trim_end().to_owned() })
    }
}

/// Collects all messages of a build. Messages about installations are printed at once; the others matter only if the
/// build fails.
fn relay(pipe: impl Read) -> String {
    let mut all = String::new();
    for line in BufReader::new(pipe).lines().map_while(Result::ok) {
        if line.starts_with("setup: ") {
            eprintln!("{line}");
        }
        all += &line;
        all.push('\n');
    }
    all
}
