//! What a firmware takes of the emulated chip while it runs: the firmware that is flashed, unchanged, measured from outside. And of a
//! board on a serial port: cycles of its ticks.
//!
//! | module | holds |
//! |---|---|
//! | [`swing`] | random states that the controller drives through, with neither fault nor limit |
//! | [`ticks`] | the chip in lock step: instructions of each tick, and the depth of the stack by painting |
//! | [`drilled`] | the chip under its safety state machine, along a trajectory |
//! | [`traced`] | from the emulator's trace: the tick's interrupt and its estimated cycles, how long it is masked, what a link byte takes |
//! | [`flood`] | how late a tick begins while the timer paces and the link is never idle |
//! | [`board`] | a board on a serial port, in lock step: cycles of each tick as its own counter has them |
//! | [`interrupts`] | numbers of the exceptions, and how the core holds them off |
//! | [`paint`] | RAM filled before the program starts, and read back |
//! | [`report`] | what is measured, as one JSON object |
#![forbid(unsafe_code)]

pub mod board;
pub mod drilled;
pub mod flood;
pub mod interrupts;
pub mod paint;
mod program;
pub mod report;
pub mod swing;
pub mod ticks;
pub mod traced;

use std::path::PathBuf;

/// Why there is no measurement.
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
        /// What is wrong with it.
        why: String,
    },
    /// The chip is of no use.
    #[error(transparent)]
    Chip(#[from] host_sim::chip::ChipError),
    /// The emulator's log is of no use.
    #[error(transparent)]
    Log(#[from] chip_image::cycles::trace::Error),
    /// A file or a socket.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// No motion was found that the controller drives through without a fault or a limit.
    #[error("{scene}: the controller brakes or limits in every swing that was tried; the last said: {why}")]
    NoSwing {
        /// The scene's name.
        scene: String,
        /// What the controller did.
        why: String,
    },
    /// Something that must be there was not seen.
    #[error("{0}")]
    NotSeen(String),
    /// There is no board on the port, or another firmware than this scene's.
    #[error("{found}\n{advice}")]
    Board {
        /// What was found.
        found: String,
        /// What to do about it.
        advice: String,
    },
    /// A board does not count cycles.
    #[error(transparent)]
    Counter(#[from] board::BadCounter),
    /// A board computes something else than the desk.
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
    Port(#[from] host_sim::session::serial::SerialError),
}

impl Failure {
    /// The exit code, as the simulator has them: 2 where the person has to change something, 1 where something outside has failed.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Board { .. } | Self::Counter(_) => host_sim::failure::INPUT,
            _ => host_sim::failure::OUTSIDE,
        }
    }
}
