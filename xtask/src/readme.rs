//! Check of the README's commands: they are run as written, and their output is compared with the output shown below them.
//!
//! | module | holds |
//! |---|---|
//! | [`blocks`] | commands of a page, and the output shown for them |
//! | [`compare`] | comparison of shown and printed output, with times masked |

mod blocks;
mod compare;

use crate::budget;
use crate::process::root;
use anyhow::{Context as _, Result, bail, ensure};
use blocks::ConsoleBlock;
use compare::Masked;
use std::process::{Command, Stdio};

/// Runs every `cargo` line of the README's `console` blocks, except those that would start this task again. Compares the output with the `text` block
/// that follows.
pub(crate) fn run_commands() -> Result<()> {
    let path = root().join("README.md");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let blocks = blocks::of(&text);
    if blocks.iter().all(|block| block.commands.is_empty()) {
        bail!("README.md has no command in a ```console block");
    }
    let masked = if budget::is_of_this_compiler()? { Masked::Times } else { Masked::TimesAndInstructions };
    let mut wrong = Vec::new();
    for ConsoleBlock { commands, shown } in &blocks {
        let mut printed = String::new();
        for line in commands {
            printed += &stdout(line)?;
        }
        if let (Some(shown), false) = (shown, commands.is_empty()) {
            wrong.extend(
                compare::difference(shown, &printed, masked).map(|at| format!("{}:\n{at}", commands.join("\n"))),
            );
        }
    }
    ensure!(wrong.is_empty(), "README.md shows something else than its commands print\n{}", wrong.join("\n"));
    Ok(())
}

/// Returns the standard output of a command that must succeed, and prints it.
fn stdout(line: &str) -> Result<String> {
    eprintln!("$ {line}");
    let mut words = line.split_whitespace();
    let program = words.next().unwrap_or_default();
    let output = Command::new(program)
        .args(words)
        .current_dir(root())
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start {line}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    eprint!("{text}");
    ensure!(output.status.success(), "{line} failed: {}", output.status);
    Ok(text)
}
