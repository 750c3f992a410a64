//! Measurements of an arm.

use super::chip::Count;
use super::desk::Time;

/// Measurements of an arm.
pub(super) struct Measured {
    pub(super) arm: &'static str,
    pub(super) desk: Vec<Time>,
    pub(super) chip: Vec<Count>,
}
