//! A motion along the targets of another program.

use super::follower::Follower;

/// A motion along targets.
#[derive(Clone, Debug)]
pub(super) struct Following {
    /// The reference.
    pub(super) follower: Follower,
    /// Longest time between two targets, s.
    pub(super) patience: f64,
}
