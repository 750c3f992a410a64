//! Measured values as one JSON object. `cargo xtask budget` compares them with `firmware/budget.toml`, or prints them for a
//! board.

use chip_image::costs::Cycles;
use serde::Serialize;

/// Ticks in lock step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Ticks {
    /// Number of ticks.
    pub ticks: u64,
    /// Fewest instructions of the controller in a tick, as counted by the chip.
    pub min: u64,
    /// Most instructions of the controller in a tick.
    pub max: u64,
    /// Bytes of the stack that were written, in these ticks and in the supervised ones.
    pub stack: u64,
    /// Ticks under the safety state machine.
    pub supervised: Supervised,
}

/// Ticks under the safety state machine, while the arm runs and no request is pending.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Supervised {
    /// Number of ticks.
    pub ticks: u64,
    /// Fewest instructions of trajectory, safety state machine and controller in a tick, as counted by the chip.
    pub min: u64,
    /// Most instructions of the same in a tick.
    pub max: u64,
    /// Instructions of the preceding tick, which accepts the request to run.
    pub granting: u64,
}

/// Results of the trace of a few ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Traced {
    /// Number of traced ticks.
    pub ticks: u64,
    /// Longest interrupt of a tick in which the arm runs and no request is pending, as in nearly every tick.
    pub running: Interrupt,
    /// Longest interrupt of all ticks except the first; it accepts a request.
    pub longest: Interrupt,
    /// Longest time for which the tick's interrupt is masked, in instructions.
    pub masked: u64,
    /// Most instructions of the interrupt of a received byte.
    pub byte_interrupt: u64,
    /// Instructions per byte of the link in either direction: receiving, decoding, handling, encoding, sending.
    pub link_byte: u64,
}

/// One interrupt of the tick: trajectory, safety state machine, controller, black box, and copying in and out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Interrupt {
    /// Its instructions.
    pub instructions: u64,
    /// Its cycles, **estimated**.
    pub cycles: Cycles,
}

/// All values of one firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Measured {
    /// Ticks in lock step.
    pub ticks: Ticks,
    /// Trace of a few of them.
    pub traced: Traced,
}

/// Ticks of a board in bench mode and lock step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OnBoard {
    /// Hash of robot, scene and configuration, which firmware and scene share: 16 hexadecimal digits.
    pub hash: String,
    /// Control rate of the scene, Hz; in bench mode it does not pace the ticks.
    pub rate_hz: f64,
    /// Number of counted ticks.
    pub ticks: u64,
    /// Number of ticks in which a torque or a limit differs from the desk's in any bit. Always zero in a report.
    pub bits_differ: u64,
    /// Cycles of the controller in a tick, from the board's own counter.
    pub cycles_per_tick: Spread,
}

/// Fewest, most, and mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Fewest.
    pub min: u32,
    /// Most.
    pub max: u32,
    /// Mean.
    pub mean: f64,
}

impl Spread {
    /// Spread of these counts; `None` for an empty list.
    #[must_use]
    pub fn of(counts: &[u32]) -> Option<Self> {
        let (min, max) = (*counts.iter().min()?, *counts.iter().max()?);
        let sum: u64 = counts.iter().map(|count| u64::from(*count)).sum();
        Some(Self { min, max, mean: sum as f64 / counts.len() as f64 })
    }
}
