//! The project's two workspaces: the product, and code that is built only for measurements. Each has its own lock file; both share one build folder
//! (`.cargo/config.toml`).

use crate::process;
use std::fmt;
use std::process::Command;

/// A workspace, by its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Workspace {
    /// The top-level workspace: everything that ships, and the tasks.
    Product,
    /// `bench/`: kernels that are measured or compared, batch evaluation, and the peers. No package of the product depends on it.
    Bench,
}

impl Workspace {
    pub(crate) const ALL: [Self; 2] = [Self::Product, Self::Bench];

    /// Path of its manifest, relative to the project's folder.
    pub(crate) const fn manifest(self) -> &'static str {
        match self {
            Self::Product => "Cargo.toml",
            Self::Bench => "bench/Cargo.toml",
        }
    }

    /// Cargo for this workspace, with its first arguments.
    pub(crate) fn cargo<'a>(self, arguments: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = process::cargo(arguments);
        if self == Self::Bench {
            command.args(["--manifest-path", self.manifest()]);
        }
        command
    }
}

/// Suffix for the names of steps.
impl fmt::Display for Workspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Product => "",
            Self::Bench => " of bench",
        })
    }
}
