//! The simulator's command line.

use clap::Parser;
use host_sim::cli::{Cli, Command};
use host_sim::trade::on_the_chip;
use host_sim::{
    bound_command, campaign_command, connect_command, doctor_command, dynamics_command, energy_command,
    explain_command, extremes_command, info_command, kernel_command, linkage_command, replay_command, run_command,
    statics_command, terms_command, trade_command,
};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

fn main() -> ExitCode {
    // Messages are read by scripts too, which search them for a line number: no line is broken in the middle.
    let unbroken = || miette::MietteHandlerOpts::new().wrap_lines(false).build();
    if let Err(error) = miette::set_hook(Box::new(move |_| Box::new(unbroken()))) {
        eprintln!("{error}");
    }
    let done = match Cli::parse().command {
        Command::Run(args) => run_command::run(&args, &stop_on_interrupt()),
        Command::Dynamics(args) => dynamics_command::run(&args).map(|()| 0),
        Command::Terms(args) => terms_command::run(&args).map(|()| 0),
        Command::Statics(args) => statics_command::run(&args).map(|()| 0),
        Command::Energy(args) => energy_command::run(&args, &stop_on_interrupt()),
        Command::Explain(args) => explain_command::run(&args, &on_the_chip, &stop_on_interrupt()).map(|()| 0),
        Command::Info(args) => info_command::run(&args).map(|()| 0),
        Command::Kernel(args) => kernel_command::run(&args).map(|()| 0),
        Command::Linkage(args) => linkage_command::run(&args),
        Command::Doctor(args) => doctor_command::run(&args),
        Command::Connect(args) => connect_command::run(&args, presses()),
        Command::Replay(args) => replay_command::run(&args),
        Command::Bound(args) => bound_command::run(&args).map(|()| 0),
        Command::Extremes(args) => extremes_command::run(&args).map(|()| 0),
        Command::Campaign(args) => campaign_command::run(&args, &stop_on_interrupt()),
        Command::Trade(args) => trade_command::run(&args, &on_the_chip, &stop_on_interrupt()).map(|()| 0),
        Command::Choose(args) => trade_command::choose(&args, &on_the_chip, &stop_on_interrupt()).map(|()| 0),
    };
    ExitCode::from(done.unwrap_or_else(|failure| {
        let code = failure.code();
        eprintln!("{:?}", failure.report());
        code
    }))
}

/// A flag that Ctrl-C sets. The loop looks at it in every tick, and no tick waits longer than the chip's timeout.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    if let Err(error) = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)) {
        eprintln!("Ctrl-C will end the run without a summary: {error}");
    }
    stop
}

/// How often Ctrl-C was pressed: whoever operates an arm stops it on the first, and leaves on the second.
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
