//! The command that repeats one run of a study.

use sim::run::files::shell_word;
use std::path::Path;

/// Returns the command that repeats the run with this index of a study file.
#[must_use]
pub fn repeat_command(study: &Path, index: u64) -> String {
    format!("newtau sweep {} --replay {index} --out out/run_{index}", shell_word(study))
}
