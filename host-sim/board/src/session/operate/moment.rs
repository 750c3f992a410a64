//! Time of a stop.

use std::time::Instant;

/// Time of a stop.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moment {
    /// Time of this machine, for a person who presses a key.
    Wall(Instant),
    /// Tick of a dry run, so that a script has the same result on every machine.
    Tick(u32),
}
