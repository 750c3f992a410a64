//! Reason why a request had no effect.

use link::Denial;
use std::time::Duration;

/// Reason why a request had no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// The board rejects it.
    Denied(Denial),
    /// Replaced by a stronger request in the same tick.
    Superseded,
    /// No answer has come for this long. The board may or may not have received the request.
    Unconfirmed(Duration),
}
