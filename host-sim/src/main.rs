//! The simulator's command line.

use clap::Parser;
use host_sim::cli::{self, Cli, Command};
use sim::terminal::{self, exit_code, keep_lines_of_messages};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use studies::trade::chip::EmulatedChip;

fn main() -> ExitCode {
    keep_lines_of_messages();
    let done = match Cli::parse().command {
        Command::Run(args) => cli::run::run(&args, &stop_on_interrupt()),
        Command::Compare(args) => cli::compare::run(&args).map(|()| 0),
        Command::Dynamics(args) => cli::dynamics::run(&args).map(|()| 0),
        Command::Terms(args) => cli::terms::run(&args).map(|()| 0),
        Command::Statics(args) => cli::statics::run(&args).map(|()| 0),
        Command::Contact(args) => cli::contact::run(&args).map(|()| 0),
        Command::Energy(args) => cli::energy::run(&args, &stop_on_interrupt()),
        Command::Explain(args) => cli::explain::run(&args, &EmulatedChip, &stop_on_interrupt()).map(|()| 0),
        Command::Info(args) => cli::info::run(&args).map(|()| 0),
        Command::Check(args) => cli::check::run(&args),
        Command::Motion(args) => cli::motion::run(&args).map(|()| 0),
        Command::Excite(args) => cli::excite::run(&args).map(|()| 0),
        Command::Identify(args) => cli::identify::run(&args),
        Command::Export(args) => cli::export::run(&args).map(|()| 0),
        Command::Import(args) => cli::import::run(&args).map(|()| 0),
        Command::Kernel(args) => cli::kernel::run(&args).map(|()| 0),
        Command::Linkage(args) => cli::linkage::run(&args),
        Command::Doctor(args) => cli::doctor::run(&args),
        Command::Key(args) => cli::key::run(&args),
        Command::Connect(args) => cli::connect::run(&args, presses()),
        Command::Replay(args) => cli::replay::run(&args),
        Command::Bound(args) => cli::bound::run(&args).map(|()| 0),
        Command::Extremes(args) => cli::extremes::run(&args).map(|()| 0),
        Command::Sweep(args) => cli::sweep::run(&args, &stop_on_interrupt()),
        Command::Merge(args) => cli::merge::run(&args),
        Command::Trade(args) => cli::trade::run(&args, &EmulatedChip, &stop_on_interrupt()).map(|()| 0),
        Command::Choose(args) => cli::choose::run(&args, &EmulatedChip, &stop_on_interrupt()).map(|()| 0),
    };
    exit_code(done)
}

/// Returns a flag that Ctrl-C sets. The loop checks it in every tick, and no tick waits longer than the chip's timeout.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    terminal::stop_on_interrupt("end the run without a summary")
}

/// Returns a counter of Ctrl-C presses: the first press stops the operator's arm, the second ends the program.
fn presses() -> Arc<AtomicU32> {
    let presses = Arc::new(AtomicU32::new(0));
    let count = Arc::clone(&presses);
    if let Err(error) = ctrlc::set_handler(move || {
        count.fetch_add(1, Ordering::Relaxed);
    }) {
        eprintln!("Ctrl-C will leave the arm to its heartbeat: {error}");
    }
    presses
}
