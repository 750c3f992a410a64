//! The program as a person or a script runs it.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses its part")]

use std::process::{Command, Output};

/// In the folder at the top of the project.
pub fn at_the_top() -> Command {
    within(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// In the simulator's own folder, where its fixtures are: messages that name them are the same on every machine.
pub fn at_its_fixtures() -> Command {
    within(env!("CARGO_MANIFEST_DIR"))
}

fn within(folder: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.current_dir(folder).env("NO_COLOR", "1").env_remove("RUST_BACKTRACE");
    command
}

/// What it printed, having ended well and complained of nothing.
pub fn printed(output: Output) -> String {
    let (code, printed, error) = told(output);
    assert_eq!((code, error.as_str()), (0, ""));
    printed
}

/// Exit code, standard output, standard error.
pub fn told(output: Output) -> (i32, String, String) {
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}
