//! The README's own commands, run as they stand there.

use crate::process::{root, run};
use anyhow::{Context as _, Result, bail};
use std::process::Command;

/// Run every `cargo` line of the README's `console` blocks, but for those that would start this again.
pub(crate) fn run_commands() -> Result<()> {
    let path = root().join("README.md");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let commands = commands(&text);
    if commands.is_empty() {
        bail!("README.md has no command in a ```console block");
    }
    for line in commands {
        eprintln!("$ {line}");
        let mut words = line.split_whitespace();
        let program = words.next().unwrap_or_default();
        run(Command::new(program).args(words).current_dir(root()))?;
    }
    Ok(())
}

/// Lines that begin with `$ cargo`, without their comments.
fn commands(readme: &str) -> Vec<String> {
    let mut inside = false;
    let mut commands = Vec::new();
    for line in readme.lines() {
        if line.starts_with("```") {
            inside = line == "```console";
        } else if inside && let Some(command) = line.strip_prefix("$ ") {
            let command = command.split(" #").next().unwrap_or_default().trim();
            let again = command.starts_with("cargo xtask test");
            let needs_a_board = command.contains("flash");
            if command.starts_with("cargo ") && !again && !needs_a_board {
                commands.push(command.to_owned());
            }
        }
    }
    commands
}

#[cfg(test)]
mod tests {
    use super::commands;

    #[test]
    fn commands_are_taken_from_console_blocks_only() {
        let readme = "```console\n$ cargo sim run x   # a comment\noutput\n$ cargo xtask test\n```\n$ cargo outside\n";
        assert_eq!(commands(readme), ["cargo sim run x"]);
    }
}
