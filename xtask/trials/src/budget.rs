//! Costs of a firmware at run time. On the emulated chip, the flashed firmware is measured unchanged, from outside. On a
//! board at a serial port, the cycles of its ticks are measured.
//!
//! | module | holds |
//! |---|---|
//! | [`random_motion`] | random motions that the controller follows, with neither fault nor limit |
//! | [`ticks`] | the chip in lock step: instructions of each tick, and the depth of the stack by painting |
//! | [`supervised`] | the chip under its safety state machine, along a trajectory |
//! | [`traced`] | from the emulator's trace: the tick's interrupt, its estimated cycles and masked time, the cost of a link byte |
//! | [`ways`] | the link's interrupts byte by byte and by DMA |
//! | [`flood`] | lateness of a tick while the timer paces and the link is never idle |
//! | [`board`] | a board on a serial port, in lock step: cycles of each tick as its own counter has them |
//! | [`interrupts`] | numbers of the exceptions, and how the core holds them off |
//! | [`stack_paint`] | RAM filled before the program starts, and read back |
//! | [`report`] | the measured values, as one JSON object |

pub mod board;
pub mod flood;
pub mod interrupts;
mod program;
pub mod random_motion;
pub mod report;
pub mod stack_paint;
pub mod supervised;
pub mod ticks;
pub mod traced;
pub mod ways;

use std::path::PathBuf;

/// Reasons why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The scene cannot be read.
    #[error("{0}")]
    Scene(String),
    /// The program cannot be read.
    #[error("{path}: {why}")]
    Program {
        /// The file.
        path: PathBuf,
        /// The problem.
        why: String,
    },
    /// The chip is not usable.
    #[error(transparent)]
    Chip(#[from] ::board::chip::ChipError),
    /// The emulator's log is not usable.
    #[error(transparent)]
    Log(#[from] chip_image::cycles::trace::Error),
    /// A file or a socket failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// No motion was found that the controller drives through without a fault or a limit.
    #[error("{scene}: the controller brakes or limits in every swing that was tried; the last said: {why}")]
    NoSwing {
        /// The scene's name.
        scene: String,
        /// The controller's reaction.
        why: String,
    },
    /// An expected event was not seen.
    #[error("{0}")]
    NotSeen(String),
    /// There is no board on the port, or another firmware than this scene's.
    #[error("{found}\n{advice}")]
    Board {
        /// The finding.
        found: String,
        /// The remedy.
        advice: String,
    },
    /// A board does not count cycles.
    #[error(transparent)]
    Counter(#[from] board::BadCounter),
    /// A board computes other results than the desk.
    #[error(
        "{differ} of {ticks} ticks differ from the desk in some bit, tick {first} first: what they take says nothing of this program"
    )]
    Differ {
        /// Ticks that differ.
        differ: u64,
        /// All ticks.
        ticks: u64,
        /// The first that differs.
        first: u32,
    },
    /// The port failed while it was open.
    #[error(transparent)]
    Port(#[from] ::board::session::serial::SerialError),
}

impl Failure {
    /// The exit code, as in the simulator: 2 if the user has to change something, 1 if something outside has failed.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Board { .. } | Self::Counter(_) => sim::failure::INPUT,
            _ => sim::failure::OUTSIDE,
        }
    }
}
