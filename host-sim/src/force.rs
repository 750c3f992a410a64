//! Overwriting files that exist, on the command line.

use clap::Args;
use sim::output::Output;

/// Permission to overwrite files that exist.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct ForceArgs {
    /// Overwrite existing files. Without it, newtau replaces only files that it wrote and that have not changed since.
    #[arg(long)]
    pub force: bool,
}

impl ForceArgs {
    /// Outputs of a command with this option.
    #[must_use]
    pub fn output(self) -> Output {
        Output::new(self.force)
    }
}
