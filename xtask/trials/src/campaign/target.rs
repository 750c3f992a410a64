//! The targets under test.

/// The target under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The session on the desk; readings and lines are injected.
    Desk,
    /// The session and the drivers of the joints on the desk, with simulated drives on buses.
    Drives,
    /// The firmware in the emulated chip, together with the desk.
    Qemu,
}

impl Target {
    /// Name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Desk => "desk",
            Self::Drives => "drives",
            Self::Qemu => "qemu",
        }
    }
}
