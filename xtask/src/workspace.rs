//! The project's workspaces: the product's, and that of what is built only to be measured. Each has a lock file of its own; both share one
//! build folder (`.cargo/config.toml`).

use crate::process;
use std::fmt;
use std::process::Command;

/// A workspace, by its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Workspace {
    /// At the top: what ships, and the tasks.
    Product,
    /// `bench/`: kernels that are measured or compared, the batch, the peers. No package of the product depends on it.
    Bench,
}

impl Workspace {
    pub(crate) const ALL: [Self; 2] = [Self::Product, Self::Bench];

    /// Its manifest, from the project's folder on.
    pub(crate) const fn manifest(self) -> &'static str {
        match self {
            Self::Product => "Cargo.toml",
            Self::Bench => "bench/Cargo.toml",
        }
    }

    /// Cargo in it, with its first arguments.
    pub(crate) fn cargo<'a>(self, arguments: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = process::cargo(arguments);
        if self == Self::Bench {
            command.args(["--manifest-path", self.manifest()]);
        }
        command
    }
}

/// Suffix of a step's name.
impl fmt::Display for Workspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Product => "",
            Self::Bench => " of bench",
        })
    }
}
