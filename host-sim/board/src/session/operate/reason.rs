//! Reasons why a command was not completed.

use super::device::DeviceError;
use crate::chip::ChipError;
use std::io;

/// Reason why a command was not completed.
#[derive(Debug, thiserror::Error)]
pub enum Stop {
    /// The board can no longer be used.
    #[error(transparent)]
    Board(#[from] DeviceError),
    /// The input is wrong or asks for something impossible.
    #[error("{0}")]
    Input(String),
    /// Ctrl-C.
    #[error("interrupted")]
    Interrupted,
    /// The stop key.
    #[error("stopped")]
    Pressed,
    /// Standard output cannot be written.
    #[error(transparent)]
    Output(#[from] io::Error),
}

impl From<ChipError> for Stop {
    fn from(error: ChipError) -> Self {
        Self::Board(error.into())
    }
}
