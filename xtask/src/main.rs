//! Project tasks: `cargo xtask --help`.

mod api;
mod bench;
mod budget;
mod check;
mod cores;
mod cost;
mod docs;
mod gate;
mod machine;
mod measured;
mod pages;
mod peers;
mod python;
mod qemu;
mod report;
mod robot_data;
mod scenes;
mod setup;
mod table;
mod tally;
mod templates;
mod test;
mod trials;
mod vcan;
mod workspace;

use clap::{Parser, Subcommand};
use firmware_image::board::SCENE_DEFAULT;
use firmware_image::{BadInput, Board, Build, Trust, process, toolchain};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Project tasks.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Install missing tools: the chip's target, the emulator, the test runner
    Setup,
    /// Run all tests and checks; installs missing tools
    Test,
    /// Fast checks during development: format, lints and unit tests of the changed packages
    Check,
    /// Run and measure the firmware; `newtau firmware` builds and flashes it
    Firmware {
        #[command(subcommand)]
        task: FirmwareTask,
    },
    /// Measure speed, instruction counts and code size; write docs/measured/kernels.md
    Bench {
        #[command(flatten)]
        options: bench::BenchOptions,
    },
    /// Measure the costs of every firmware and compare them with the ranges in firmware/budget.toml; exit code 2 if one is outside. With --port,
    /// cycles on a flashed board
    Budget {
        #[command(flatten)]
        options: budget::BudgetOptions,
    },
    /// Estimate the cycles of kernels on the chip from the emulator's trace, from flash and from SRAM. With --port, exit code 1 if a board's cycles
    /// are outside their range, 2 if there is no such board
    Cycles {
        /// Write the tables of docs/measured/cycles.md
        #[arg(long, conflicts_with_all = ["micro", "port"])]
        write: bool,
        /// Estimate stretches of one class of instructions each instead
        #[arg(long)]
        micro: bool,
        /// Compare these stretches with a board that runs them, on this serial port
        #[arg(long)]
        port: Option<String>,
        /// Flash the program with the stretches first, with probe-rs; only while the drives' power is off
        #[arg(long, requires = "port")]
        flash: bool,
    },
    /// Run the dynamics on a dozen cores in emulators: results equal to the desk's, instructions in their ranges
    Cores {
        #[command(flatten)]
        options: cores::CoresOptions,
    },
    /// Install the Python wheel into an environment of its own, and run its tests
    Python,
    /// Compile every firmware template for its chip, test its loop here, and run one in the emulated chip
    Templates,
    /// Run `newtau drive` at SocketCAN's virtual interface, in an emulated PC with Debian's kernel (a minute or two)
    Vcan,
    /// Show which pages of docs/measured are current, and measure again; exit code 1 if one is not current and is not measured again
    Measured {
        #[command(flatten)]
        options: measured::MeasuredOptions,
    },
    /// The report page: bundle its scripts, take its picture for the README
    Report {
        #[command(flatten)]
        options: report::ReportOptions,
    },
    /// Run the commands of the README and of docs, and compare their output with the output shown
    Pages {
        /// These pages alone, such as docs/trade.md
        pages: Vec<String>,
    },
    /// Write the listings of the public interface in docs/reference/api
    Api {
        /// Compare them instead; fail if one differs
        #[arg(long)]
        check: bool,
    },
    /// Build the documentation as a searchable book in target/book, and the crates' API documentation
    Docs,
    /// Inject every fault in every state of the safety state machine, and judge every tick; --help lists the options
    #[command(disable_help_flag = true)]
    Campaign {
        /// Options and scenes of the campaign
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
    /// Check that the control tick can reach no software f64 arithmetic and no panic
    Gate {
        /// The scene whose arm and controller are built in
        #[arg(long, default_value = SCENE_DEFAULT)]
        scene: PathBuf,
    },
}

#[derive(clap::Args)]
struct What {
    /// The scene whose arm and controller are built in; the default is one that the board has drives for
    #[arg(long)]
    scene: Option<PathBuf>,
    /// The board
    #[arg(long, value_enum, default_value_t = Board::Netduinoplus2)]
    board: Board,
    /// Accept every host on the wire, without a key. Only for an isolated bench; the firmware reports this to every host
    #[arg(long)]
    insecure: bool,
}

impl What {
    fn scene(&self) -> PathBuf {
        self.scene.clone().unwrap_or_else(|| self.board.scene().into())
    }

    fn build(&self) -> anyhow::Result<PathBuf> {
        Build { trust: Trust::insecure(self.insecure), ..Build::of(&self.scene(), self.board) }.run()
    }
}

#[derive(Subcommand)]
enum FirmwareTask {
    /// Start it in the emulator and print its log
    Run {
        #[command(flatten)]
        what: What,
        /// Stop after this time, in seconds
        #[arg(long)]
        seconds: Option<u64>,
    },
    /// Print the flash, RAM and stack that it needs, and compare them with firmware/budget.toml
    Size {
        #[command(flatten)]
        what: What,
    },
    /// Measure a control tick of each of many scenes in the emulated chip; print one JSON object per scene
    Cost {
        /// A text file with the path of a scene file on each line
        #[arg(long)]
        scenes: PathBuf,
    },
    /// Measure the whole interrupt of a supervised tick in the emulated chip; print a JSON object
    Interrupt {
        /// The scene whose arm and controller are built in
        #[arg(long)]
        scene: PathBuf,
    },
}

fn main() -> ExitCode {
    match run(Arguments::parse().task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            if error.is::<BadInput>() { ExitCode::from(BadInput::EXIT_CODE) } else { ExitCode::FAILURE }
        }
    }
}

fn run(task: Task) -> anyhow::Result<()> {
    match task {
        Task::Setup => setup::all(),
        Task::Test => test::all(),
        Task::Check => check::changed(),
        Task::Bench { options } => bench::run(options),
        Task::Budget { options } => budget::run(&options),
        Task::Cycles { micro, port, flash, .. } if micro || port.is_some() => bench::micro::run(port.as_deref(), flash),
        Task::Cycles { write, .. } => bench::cycles::run(write),
        Task::Cores { options } => cores::run(&options),
        Task::Python => python::check(),
        Task::Templates => templates::run(),
        Task::Vcan => vcan::check(),
        Task::Measured { options } => measured::run(&options),
        Task::Report { options } => report::run_task(&options),
        Task::Api { check } => api::run_task(check),
        Task::Docs => docs::build(),
        Task::Pages { pages } => pages::run_commands(&pages),
        Task::Campaign { arguments } => process::become_command(trials::fast_program("campaign").args(arguments)),
        Task::Gate { scene } => gate::check(&scene),
        Task::Firmware { task } => match task {
            FirmwareTask::Run { what, seconds } => qemu::run(&what.build()?, seconds.map(Duration::from_secs)),
            FirmwareTask::Size { what } => budget::sizes(&what.build()?, &what.scene(), what.board),
            FirmwareTask::Cost { scenes } => cost::print(&scenes),
            FirmwareTask::Interrupt { scene } => budget::interrupt(&scene),
        },
    }
}
