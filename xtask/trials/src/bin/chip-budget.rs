//! Measures one firmware, in the emulator or on a board, and prints its costs as JSON. `cargo xtask budget` builds and runs this program.

use clap::{Parser, Subcommand};
use robot_compiler::{SceneFile, with_dof};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trials::budget::report::Measured;
use trials::budget::{Failure, board, flood, random_motion, supervised, ticks, traced, ways};

/// Random seed for the motion of the counted ticks.
const SEED: u64 = 1;

/// Measure a firmware in the emulated chip, or on a board.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Ticks in lock step, and their trace
    Ticks {
        #[command(flatten)]
        firmware: Firmware,
        /// Number of ticks to count
        #[arg(long)]
        ticks: usize,
        /// Number of them to trace
        #[arg(long)]
        traced: usize,
    },
    /// Delay of the timer's ticks under a flood of the link
    Flood {
        #[command(flatten)]
        firmware: Firmware,
        /// Number of ticks
        #[arg(long)]
        ticks: u64,
    },
    /// Cost of the link's interrupts, byte by byte and by DMA
    Ways {
        #[command(flatten)]
        firmware: Firmware,
        /// The same firmware with the stand-in for a DMA
        #[arg(long)]
        dma: PathBuf,
        /// The firmware of a board with a DMA, for the interrupts that touch its registers
        #[arg(long)]
        board: PathBuf,
        /// Number of ticks
        #[arg(long)]
        ticks: usize,
    },
    /// Cycles of the ticks of a board on a serial port, in lock step; exit code 2 if there is no such board or its counter is implausible
    Board {
        /// The scene that its firmware was built for
        #[arg(long)]
        scene: PathBuf,
        /// The serial port of its link
        #[arg(long)]
        port: String,
        /// The board's key file, if it has a key
        #[arg(long)]
        key: Option<PathBuf>,
        /// Number of ticks to count
        #[arg(long)]
        ticks: usize,
        /// Fewest instructions of such a tick in the emulator; a smaller count of cycles is rejected
        #[arg(long)]
        instructions: Option<u32>,
    },
}

#[derive(clap::Args)]
struct Firmware {
    /// The scene that it was built for
    #[arg(long)]
    scene: PathBuf,
    /// The program
    #[arg(long)]
    elf: PathBuf,
}

fn main() -> ExitCode {
    match run(&Arguments::parse().what) {
        Ok(json) => {
            println!("{json}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.code())
        }
    }
}

fn run(what: &What) -> Result<String, Failure> {
    let json = match what {
        What::Ticks { firmware, ticks, traced } => {
            let scene = load(&firmware.scene)?;
            let measured = with_dof!(scene.robot.dof(), N => {
                measure::<N>(&scene, &firmware.elf, *ticks, *traced)
            })?;
            serde_json::to_string(&measured)
        }
        What::Flood { firmware, ticks } => {
            let scene = load(&firmware.scene)?;
            let late = with_dof!(scene.robot.dof(), N => {
                random_motion::undisturbed::<N>(&scene, SEED, 1)
                    .and_then(|motion| flood::flood::<N>(&scene, &firmware.elf, *ticks, &motion[0]))
            })?;
            serde_json::to_string(&late)
        }
        What::Ways { firmware, dma, board, ticks } => {
            let scene = load(&firmware.scene)?;
            let ways = with_dof!(scene.robot.dof(), N => {
                supervised::undisturbed::<N>(&scene, SEED, *ticks)
                    .and_then(|motion| ways::measure::<N>(&scene, &firmware.elf, dma, board, &motion))
            })?;
            serde_json::to_string(&ways)
        }
        What::Board { scene, port, key, ticks, instructions } => {
            let scene = load(scene)?;
            let key = key.as_deref().map(::board::key::load).transpose();
            let key = key.map_err(|error| Failure::Scene(error.to_string()))?;
            let measured = with_dof!(scene.robot.dof(), N => {
                random_motion::undisturbed::<N>(&scene, SEED, *ticks)
                    .and_then(|motion| board::measure::<N>(&scene, (port, key), &motion, *instructions))
            })?;
            serde_json::to_string(&measured)
        }
    };
    json.map_err(|error| Failure::NotSeen(format!("numbers that can be printed: {error}")))
}

fn load(path: &Path) -> Result<SceneFile, Failure> {
    SceneFile::load(path).map_err(|error| Failure::Scene(format!("{error:?}")))
}

fn measure<const N: usize>(scene: &SceneFile, elf: &Path, ticks: usize, traced: usize) -> Result<Measured, Failure> {
    let motion = random_motion::undisturbed::<N>(scene, SEED, ticks)?;
    let supervised = supervised::undisturbed::<N>(scene, SEED, ticks)?;
    let few = &supervised[..traced.min(motion.len())];
    Ok(Measured { ticks: ticks::count(scene, elf, &motion, &supervised)?, traced: traced::trace(scene, elf, few)? })
}
