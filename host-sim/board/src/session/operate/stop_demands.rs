//! Demands for a stop, and their times.

use crate::session::local::shared::Demanded;
use std::time::Instant;

/// Number of demands for a stop, modulo 2^32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StopDemands {
    /// Presses of the stop key.
    pub(super) keys: u32,
    /// Demands of other programs.
    pub(super) others: Demanded,
}

/// Time of a stop.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moment {
    /// Time of this machine, for a person who presses a key.
    Wall(Instant),
    /// Tick of a dry run, so that a script has the same result on every machine.
    Tick(u32),
}
