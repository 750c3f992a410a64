//! The program as run by a person or a script.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses its part")]

#[cfg(unix)]
pub mod probe;

use std::path::Path;
use std::process::{Command, Output};

/// Command in the project's root folder.
pub fn at_the_top() -> Command {
    within(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Command in the simulator's folder, with its fixtures: messages that name these are the same on every machine.
pub fn at_its_fixtures() -> Command {
    within(env!("CARGO_MANIFEST_DIR"))
}

fn within(folder: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_newtau"));
    command.current_dir(folder).env("NO_COLOR", "1").env_remove("RUST_BACKTRACE");
    command
}

/// A path at which there is no file, because the program does not overwrite a file of an earlier test run.
pub fn new(path: &Path) -> &Path {
    if path.is_dir() {
        std::fs::remove_dir_all(path).unwrap()
    } else {
        std::fs::remove_file(path).ok().unwrap_or_default()
    }
    path
}

/// Standard output of a program that succeeded with an empty standard error.
pub fn printed(output: Output) -> String {
    let (code, printed, error) = told(output);
    assert_eq!((code, error.as_str()), (0, ""));
    printed
}

/// Exit code, standard output and standard error.
pub fn told(output: Output) -> (i32, String, String) {
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}
