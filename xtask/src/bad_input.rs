//! What the person who called has to change.

use std::fmt;

/// A wrong option or file, a budget that is not kept, or a tool that has to be installed first. The program leaves with [`BadInput::EXIT_CODE`].
#[derive(Debug)]
pub(crate) struct BadInput(pub(crate) String);

impl BadInput {
    /// The same as the simulator's for bad input.
    pub(crate) const EXIT_CODE: u8 = 2;
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BadInput {}
