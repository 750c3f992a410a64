//! The stamp at the end of a measured block: command, commit, machine, day, and the hashes of the artefacts.

use super::artefact::Hashes;
use super::blocks::MeasuredBlock;
use crate::machine::{cores, processor, today};
use crate::process::{output, root};
use anyhow::{Context as _, Result};
use std::fmt;
use std::process::Command;

/// Beginning of a stamp's line.
pub(super) const BEGIN: &str = "Measured by `";

/// A measurement's command, commit, machine, day and artefacts.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Stamp {
    command: String,
    /// The commit that was checked out.
    commit: String,
    machine: String,
    day: String,
    /// Names of the artefacts, and the beginnings of their hashes.
    artefacts: Vec<(String, String)>,
}

impl Stamp {
    /// Creates the stamp of a measurement made now on this machine.
    pub(super) fn now(block: &MeasuredBlock, hashes: &mut Hashes) -> Result<Self> {
        let git = |words: &[&str]| output(Command::new("git").current_dir(root()).args(words));
        let commit = git(&["rev-parse", "--short=7", "HEAD"]).unwrap_or_else(|| "no commit".to_owned());
        let hash = |artefact: &super::Artefact| Ok((artefact.name(), hashes.of(*artefact)?));
        let artefacts = block.artefacts.iter().map(hash).collect::<Result<_>>()?;
        Ok(Self { command: block.command.to_owned(), commit, machine: machine(), day: today(), artefacts })
    }

    /// The hash of an artefact.
    pub(super) fn hash(&self, artefact: &str) -> Option<&str> {
        self.artefacts.iter().find(|(name, _)| name == artefact).map(|(_, hash)| hash.as_str())
    }

    /// Reads a line; `None` if it is not a stamp.
    pub(super) fn parse(line: &str) -> Option<Result<Self>> {
        let rest = line.strip_prefix(BEGIN)?;
        let read = || {
            let (command, rest) = rest.split_once("` at commit ")?;
            let (commit, rest) = rest.split_once(", ")?;
            let (day, rest) = rest.split_once(", on ")?;
            let (machine, rest) = rest.split_once(". SHA-256 of what was measured: ")?;
            let pair = |text: &str| text.rsplit_once(' ').map(|(name, hash)| (name.to_owned(), hash.to_owned()));
            let artefacts = rest.strip_suffix('.')?.split("; ").map(pair).collect::<Option<_>>()?;
            let [command, commit, day, machine] = [command, commit, day, machine].map(str::to_owned);
            Some(Self { command, commit, machine, day, artefacts })
        };
        Some(read().with_context(|| {
            format!("`{line}`: expected `{BEGIN}COMMAND` at commit COMMIT, DAY, on MACHINE. SHA-256 of what was measured: NAME HASH; NAME HASH.`")
        }))
    }
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { command, commit, machine, day, artefacts } = self;
        let list: Vec<String> = artefacts.iter().map(|(name, hash)| format!("{name} {hash}")).collect();
        let list = list.join("; ");
        write!(f, "{BEGIN}{command}` at commit {commit}, {day}, on {machine}. SHA-256 of what was measured: {list}.")
    }
}

/// Processor, cores, compiler.
fn machine() -> String {
    let rustc = output(Command::new("rustc").arg("--version")).unwrap_or_default();
    let rustc = rustc.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
    format!("{}, {} cores, {rustc}", processor(), cores())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::Stamp;

    fn stamp() -> Stamp {
        let artefacts = [("programs of puma560_pick", "0123456789ab"), ("estimator", "fedcba987654")];
        Stamp {
            command: "cargo xtask cycles --write".to_owned(),
            commit: "e5b5086".to_owned(),
            machine: "AMD EPYC, 2 cores, rustc 1.95.0".to_owned(),
            day: "2026-11-26".to_owned(),
            artefacts: artefacts.map(|(name, hash)| (name.to_owned(), hash.to_owned())).into(),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let line = stamp().to_string();
        assert_eq!(Stamp::parse(&line).unwrap().unwrap(), stamp());
        assert_eq!(stamp().hash("estimator"), Some("fedcba987654"));
        assert_eq!(stamp().hash("kernels"), None);
    }

    #[test]
    fn another_line_is_none_and_a_broken_one_an_error_that_says_so() {
        assert!(Stamp::parse("| a table |").is_none());
        let broken = stamp().to_string().replace(", on ", " ");
        let error = Stamp::parse(&broken).unwrap().unwrap_err().to_string();
        assert!(error.contains("expected") && error.contains("e5b5086"), "{error}");
    }
}
