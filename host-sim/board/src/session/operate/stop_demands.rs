//! Demands for a stop.

use crate::session::local::shared::Demanded;

/// Number of demands for a stop, modulo 2^32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StopDemands {
    /// Presses of the stop key.
    pub(super) keys: u32,
    /// Demands of other programs.
    pub(super) others: Demanded,
}
