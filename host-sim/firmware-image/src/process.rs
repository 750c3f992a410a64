//! Running of other programs, with errors that name them; lines of a source; files that only their owner can read.

use anyhow::{Context as _, Result, bail};
use std::env::consts::EXE_SUFFIX;
use std::fs::{DirBuilder, OpenOptions};
use std::io::{self, BufRead, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};

/// The workspace's folder.
pub fn root() -> PathBuf {
    let manifest = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    manifest.ancestors().nth(2).map_or_else(|| manifest.clone(), PathBuf::from)
}

/// Writes a new file that only its owner can read.
///
/// # Errors
/// The file exists or cannot be written.
pub fn write_for_owner(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)?.write_all(bytes)
}

/// Makes a folder that only its owner can enter, and the folders above it if `recursive`.
///
/// # Errors
/// It cannot be made; it exists, unless `recursive`.
pub fn folder_for_owner(path: &Path, recursive: bool) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(recursive);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Cargo's build folder.
pub fn target_directory() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |folder| root().join(folder))
}

/// Path of `program`, if it is on the `PATH`.
pub fn which(program: &str) -> Option<PathBuf> {
    let paths = std::env::var_os("PATH")?;
    std::env::split_paths(&paths)
        .map(|folder| folder.join(format!("{program}{EXE_SUFFIX}")))
        .find(|path| path.is_file())
}

/// Command for the cargo that runs this task, in the workspace's folder.
pub fn cargo<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).args(arguments);
    command
}

/// Command `cargo run` for a package, in the profile of the tasks.
pub fn cargo_run(package: &str) -> Command {
    cargo(["run", "--quiet", "--locked", "--release", "--package", package, "--"])
}

/// Runs a command, and ends this program with its exit code. Returns only if the command cannot start.
pub fn become_command(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    std::process::exit(status.code().unwrap_or(1));
}

/// Runs a command to its end. An error names the command.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    if !status.success() {
        let name = command.get_program().to_string_lossy().into_owned();
        let arguments: Vec<_> = command.get_args().map(|argument| argument.to_string_lossy()).collect();
        bail!("{name} {} failed: {status}", arguments.join(" "));
    }
    Ok(())
}

/// Standard output of a command, without the final line end; `None` if it cannot start or fails.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Lines of a source, read by a thread of their own, so that a reader can wait for a limited time. The channel is closed at the end of the source, and
/// after a line that cannot be read.
pub fn line_channel(source: impl BufRead + Send + 'static) -> Receiver<String> {
    let (sender, lines) = channel();
    // It ends with the program at the latest: a read that waits cannot be interrupted.
    std::thread::spawn(move || source.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
    lines
}

/// A path relative to the project's folder, if it is inside.
pub(crate) fn shown(path: &Path) -> String {
    let inside = root().canonicalize().ok().and_then(|root| path.strip_prefix(root).ok().map(Path::to_owned));
    inside.unwrap_or_else(|| path.to_owned()).display().to_string()
}
