//! Run-time costs of a firmware: the measuring program prints them, and the comparing task reads them.

use serde::{Deserialize, Serialize};

/// An estimate and its range, from the best case to the worst case of everything that the manuals leave open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Cycles {
    /// Best case.
    pub low: u64,
    /// Most probable case.
    pub likely: u64,
    /// Worst case.
    pub high: u64,
}

/// Lateness of ticks while the timer paced them and the link was nearly always busy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Late {
    /// Ticks that the timer started.
    pub ticks: u64,
    /// Number of these that started late.
    pub delayed: u64,
    /// Most instructions from the timer's interrupt becoming pending to the first instruction of its handler.
    pub most: u64,
    /// Bytes from the host during all these ticks.
    pub bytes_to_chip: u64,
    /// Bytes to the host during all these ticks.
    pub bytes_from_chip: u64,
}

/// All runs of an interrupt: their number, counted instructions, and **estimated** cycles without the core's own entry and return.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Runs {
    /// Number of starts.
    pub times: u64,
    /// Instructions of all runs together.
    pub instructions: u64,
    /// Cycles of all runs together.
    pub cycles: Cycles,
}

/// The link's interrupts in one of its two modes, in supervised ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct LinkInterrupts {
    /// Bytes from the host.
    pub to_chip: u64,
    /// Bytes to the host.
    pub from_chip: u64,
    /// The receiver's interrupt: for each byte, or for the idle line after a packet.
    pub receive: Runs,
    /// The interrupt for each filled half of the receive buffer; without DMA there is none.
    pub half_filled: Runs,
    /// The interrupt that reads the packets and sends the answers.
    pub serve: Runs,
    /// The interrupt after each sent piece.
    pub sent: Runs,
}

/// The link's interrupts byte by byte and by DMA.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Ways {
    /// One interrupt per byte.
    pub bytes: LinkInterrupts,
    /// Two DMA streams.
    pub dma: LinkInterrupts,
}
