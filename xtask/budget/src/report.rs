//! What is measured, as one JSON object: the numbers that `cargo xtask budget` holds to `firmware/budget.toml`, or prints for a board.

use serde::Serialize;

/// Ticks in lock step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Ticks {
    /// How many.
    pub ticks: u64,
    /// Fewest instructions of the controller in one, as the chip counts them.
    pub min: u64,
    /// Most.
    pub max: u64,
    /// Bytes of the stack that were written to, in these ticks and in the supervised ones.
    pub stack: u64,
    /// The same under the safety state machine.
    pub supervised: Supervised,
}

/// Ticks under the safety state machine, while the arm runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Supervised {
    /// How many.
    pub ticks: u64,
    /// Fewest instructions of trajectory, safety state machine and controller in one, as the chip counts them.
    pub min: u64,
    /// Most.
    pub max: u64,
}

/// What the trace of a few ticks shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Traced {
    /// Ticks traced.
    pub ticks: u64,
    /// Most instructions of the tick's interrupt: trajectory, safety state machine, controller, black box, and what copies in and out.
    pub tick_interrupt: u64,
    /// Most instructions for which the tick's interrupt is masked, at a stretch.
    pub masked: u64,
    /// Most instructions of the interrupt of a received byte.
    pub byte_interrupt: u64,
    /// Instructions for each byte of the link in either direction: receiving, decoding, taking, encoding, sending.
    pub link_byte: u64,
    /// Cycles of the tick's interrupt, **estimated**: the longest of the ticks behind the first.
    pub cycles_estimate: Cycles,
}

/// An estimate, and its range: every choice of the manuals for the best and for the worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cycles {
    /// Every choice for the best.
    pub low: u64,
    /// The likeliest.
    pub likely: u64,
    /// Every choice for the worst.
    pub high: u64,
}

/// How late ticks began while the timer paced them and the link was never idle for long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Late {
    /// Ticks that the timer began.
    pub ticks: u64,
    /// Of these, how many did not begin at once.
    pub delayed: u64,
    /// Most instructions between the timer's interrupt and its handler's first.
    pub most: u64,
    /// Bytes from the host meanwhile.
    pub bytes_to_chip: u64,
    /// Bytes to the host.
    pub bytes_from_chip: u64,
}

/// Everything of one firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Measured {
    /// Ticks in lock step.
    pub ticks: Ticks,
    /// What their trace shows, the program as it is.
    pub traced: Traced,
    /// The same of a program whose kernel is in SRAM, where there is one.
    pub kernel_in_sram: Option<Traced>,
}

/// Ticks of a board on the bench, in lock step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OnBoard {
    /// Hash of robot, scene and configuration, as its firmware and the scene have it: 16 hexadecimal digits.
    pub hash: String,
    /// Control rate of the scene, Hz: the bench's ticks are not paced by it.
    pub rate_hz: f64,
    /// How many ticks were counted.
    pub ticks: u64,
    /// In how many of them a torque or a limit differed from the desk's by any bit: none, or there is no report.
    pub bits_differ: u64,
    /// Cycles of the controller in one, as the board's own counter has them.
    pub cycles_per_tick: Spread,
}

/// Fewest, most, and mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Fewest.
    pub min: u32,
    /// Most.
    pub max: u32,
    /// Their sum by their number.
    pub mean: f64,
}

impl Spread {
    /// Of these counts; `None` where there are none.
    #[must_use]
    pub fn of(counts: &[u32]) -> Option<Self> {
        let (min, max) = (*counts.iter().min()?, *counts.iter().max()?);
        let sum: u64 = counts.iter().map(|count| u64::from(*count)).sum();
        Some(Self { min, max, mean: sum as f64 / counts.len() as f64 })
    }
}
