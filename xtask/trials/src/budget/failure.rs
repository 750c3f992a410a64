//! Reasons why there is no measurement.

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
    Chip(#[from] board::chip::ChipError),
    /// The emulator's log is not usable.
    #[error(transparent)]
    Log(#[from] chip_image::cycles::emulator::Error),
    /// A file or a socket failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// No motion was found that the controller follows without a fault or an active limit.
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
    /// There is no board on the port, or it has another firmware than this scene's.
    #[error("{found}\n{advice}")]
    Board {
        /// Description of the finding.
        found: String,
        /// The remedy.
        advice: String,
    },
    /// A board does not count cycles.
    #[error(transparent)]
    Counter(#[from] BadCounter),
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
    Port(#[from] board::session::serial::SerialError),
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

/// Reasons why a board's count is not accepted as cycles.
///
/// The counter is CYCCNT in the core's DWT unit. The firmware switches it on (TRCENA, CYCCNTENA) and tests it at start-up. If the counter does not
/// count, or counts differently for the same work, the firmware never reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadCounter {
    /// The firmware itself rejected the counter.
    #[error(
        "tick {tick} has no cost: when the firmware started, the cycle counter stood still or did not repeat itself. {STANDS_STILL}"
    )]
    None {
        /// The first such tick.
        tick: u32,
    },
    /// The counter has stopped since start-up. The count is then at most zero, because the cost of reading the counter is subtracted.
    #[error("tick {tick} took {} cycles: the counter stands still. {STANDS_STILL}", .count.cast_signed())]
    Stuck {
        /// The first such tick.
        tick: u32,
        /// The reported count.
        count: u32,
    },
    /// Fewer cycles than instructions, although no core runs more than one instruction per cycle.
    #[error(
        "tick {tick} took {count} cycles, and the emulator counts at least {instructions} instructions in it, of which no core does two at \
         once: the counter does not count every cycle. {STANDS_STILL}"
    )]
    TooFew {
        /// The first such tick.
        tick: u32,
        /// The reported count.
        count: u32,
        /// The emulator's count.
        instructions: u32,
    },
    /// An emulator, whose instruction counts are not cycles.
    #[error(
        "tick {tick} is counted in instructions, not in cycles: there is the emulated board's firmware on this port; \
         `cargo xtask budget --scene SCENE` without --port measures that"
    )]
    Instructions {
        /// The first such tick.
        tick: u32,
    },
}

/// Advice for a counter that does not count.
const STANDS_STILL: &str = "CYCCNT counts while TRCENA is set in DEMCR and CYCCNTENA in DWT_CTRL, and on a chip that has it (NOCYCCNT is 0 in \
                            DWT_CTRL). The firmware sets both once; a debugger that detaches may clear them: take the probe off, reset the board, \
                            and measure again";
