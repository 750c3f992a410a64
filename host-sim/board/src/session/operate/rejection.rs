//! Reason why a request had no effect.

use link::Denial;
use std::time::Duration;

/// Reason why a request had no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// The board rejects it.
    Denied(Denial),
    /// A stronger request came for the same tick.
    Superseded,
    /// No answer has come for this long: the request may or may not have arrived.
    Unconfirmed(Duration),
}
