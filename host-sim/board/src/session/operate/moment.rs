//! Time of a stop.

use std::time::Instant;

/// Time of a stop.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moment {
    /// Time of this machine: a person presses a key.
    Wall(Instant),
    /// Tick of a dry run: a script does the same on every machine.
    Tick(u32),
}
