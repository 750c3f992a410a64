//! Costs of a firmware while it runs: printed by the program that measures them, read by the task that compares them.

use serde::{Deserialize, Serialize};

/// An estimate and its range, from the best case to the worst case of every choice that the manuals leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Cycles {
    /// Best case.
    pub low: u64,
    /// Most probable case.
    pub likely: u64,
    /// Worst case.
    pub high: u64,
}

/// Lateness of ticks while the timer paced them and the link was never idle for long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Late {
    /// Ticks that the timer started.
    pub ticks: u64,
    /// Number of these that did not start at once.
    pub delayed: u64,
    /// Most instructions from the timer's interrupt becoming pending to the first one of its handler.
    pub most: u64,
    /// Bytes from the host in that time.
    pub bytes_to_chip: u64,
    /// Bytes to the host.
    pub bytes_from_chip: u64,
}

/// An interrupt's runs: how often, instructions as counted, and cycles, **estimated**, without the core's own entry and return.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Runs {
    /// Number of starts.
    pub times: u64,
    /// Instructions of all runs together.
    pub instructions: u64,
    /// Cycles of all runs together.
    pub cycles: Cycles,
}

/// The link's interrupts on one of its two ways, in supervised ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct LinkInterrupts {
    /// Bytes from the host.
    pub to_chip: u64,
    /// Bytes to the host.
    pub from_chip: u64,
    /// The receiver's interrupt: of each byte, or of the idle line behind a packet.
    pub receive: Runs,
    /// The interrupt of each half of the buffer of received bytes; none where nothing but the processor moves them.
    pub half_filled: Runs,
    /// The interrupt that reads the packets and sends the answers.
    pub serve: Runs,
    /// The interrupt behind each piece that is sent.
    pub sent: Runs,
}

/// The link byte by byte and by DMA.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Ways {
    /// An interrupt a byte.
    pub bytes: LinkInterrupts,
    /// Two streams of a DMA.
    pub dma: LinkInterrupts,
}
