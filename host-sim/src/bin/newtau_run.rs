//! The program that `cargo newtau` starts: `run`. Every other command is left to `newtau`, which cargo compiles when it is first needed.
#![forbid(unsafe_code)]

use clap::{ArgAction, Parser, Subcommand};
use host_sim::run::{self, RunArgs};
use sim::failure::Failure;
use sim::terminal::{exit_code, keep_lines_of_messages};
use std::ffi::OsString;
use std::io;
use std::process::{Command, ExitCode};

/// The part of the command line of `newtau` that is here; its help and its messages are the same.
#[derive(Debug, Parser)]
#[command(name = "newtau", bin_name = "newtau", disable_help_flag = true, disable_help_subcommand = true)]
struct Here {
    /// Print help.
    #[arg(short, long, global = true, action = ArgAction::HelpShort)]
    help: Option<bool>,
    #[command(subcommand)]
    command: Run,
}

#[derive(Debug, Subcommand)]
enum Run {
    /// Simulate a scene in closed loop: table, CSV log, and a report for a browser.
    Run(RunArgs),
}

fn main() -> ExitCode {
    keep_lines_of_messages();
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    if words.first().is_some_and(|word| word == "run") {
        let Run::Run(args) = Here::parse().command;
        return exit_code(run::run(&args, &run::stop_on_interrupt()));
    }
    match newtau(&words) {
        Ok(code) => code,
        Err(error) => exit_code(Err(Failure::Target(miette::miette!(
            help = "expected a Rust toolchain, as when this program was compiled",
            "cargo, which compiles and starts the other commands: {error}"
        )))),
    }
}

/// Starts the whole program with these arguments. Cargo compiles it first, if it or a source has changed.
fn newtau(words: &[OsString]) -> io::Result<ExitCode> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args([
        "run",
        "--release",
        "--manifest-path",
        concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"),
        "--bin",
        "newtau",
    ]);
    // Cargo prints its progress only while it compiles the whole program for the first time, which takes minutes.
    let whole = std::env::current_exe()?.with_file_name(format!("newtau{}", std::env::consts::EXE_SUFFIX));
    if whole.exists() {
        cargo.arg("--quiet");
    } else {
        eprintln!(
            "newtau: commands other than `run` are compiled when they are first used; this takes some minutes, once"
        );
    }
    in_its_place(cargo.arg("--").args(words))
}

/// Replaces this program by another one, which then gets the terminal's signals.
#[cfg(unix)]
fn in_its_place(program: &mut Command) -> io::Result<ExitCode> {
    Err(std::os::unix::process::CommandExt::exec(program))
}

/// Starts another program and waits for its end. Ctrl-C is for that program, which gets it as well.
#[cfg(not(unix))]
fn in_its_place(program: &mut Command) -> io::Result<ExitCode> {
    ctrlc::set_handler(|| {}).map_err(io::Error::other)?;
    let code = program.status()?.code();
    Ok(ExitCode::from(code.and_then(|code| u8::try_from(code).ok()).unwrap_or(1)))
}
