//! URDF files of real robots, downloaded for the tests.

use crate::process::{root, run, target_directory, which};
use std::path::PathBuf;
use std::process::Command;

/// Downloads the files if they are missing, and returns their folder. Without Python or a network, the tests that need them are skipped with a
/// message; in continuous integration they fail. No robot of the project depends on these files.
pub(crate) fn fetch() -> PathBuf {
    let folder = target_directory().join("robot-data");
    let script = root().join("robot-compiler/tests/tools/fetch_urdf.py");
    let Some(python) = which("python3") else {
        eprintln!("setup: no python3 here, so no URDF files of real robots: their tests are skipped");
        return folder;
    };
    eprintln!("setup: URDF files of real robots, from the PyPI package example-robot-data (131 MB, once)");
    if let Err(why) = run(Command::new(python).arg(script).arg(&folder)) {
        eprintln!("setup: {why:#}; the tests that need these files are skipped");
    }
    folder
}
