//! The simulator's command line.

use clap::Parser;
use host_sim::cli::{Cli, Command};
use host_sim::{dynamics_command, info_command, run_command};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(args) => run_command::run(&args, &stop_on_interrupt()),
        Command::Dynamics(args) => dynamics_command::run(&args).map(|()| 0),
        Command::Info(args) => info_command::run(&args).map(|()| 0),
    };
    ExitCode::from(done.unwrap_or_else(|failure| {
        let code = failure.code();
        eprintln!("{:?}", failure.report());
        code
    }))
}

/// A flag that the first Ctrl-C sets; the second ends the program at once.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let set = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(host_sim::exit::INTERRUPTED));
        }
    });
    if let Err(error) = set {
        eprintln!("Ctrl-C will end the run without a summary: {error}");
    }
    stop
}
