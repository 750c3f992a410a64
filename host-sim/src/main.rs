//! The program `newtau`.

use clap::Parser;
use host_sim::cli::{Cli, renamed};
use sim::terminal::{exit_code, keep_lines_of_messages};
use std::process::ExitCode;

fn main() -> ExitCode {
    keep_lines_of_messages();
    exit_code(renamed::refuse(std::env::args().nth(1).as_deref()).and_then(|()| Cli::parse().command.run()))
}
