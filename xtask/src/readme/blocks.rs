//! Commands of a page, and the output shown for them.

/// A `console` block.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct ConsoleBlock {
    /// Its `cargo` lines that can run here, without their comments.
    pub(super) commands: Vec<String>,
    /// The `text` block directly below it.
    pub(super) shown: Option<String>,
}

/// Kind of the text in which a line is.
enum Place {
    Prose,
    Console,
    Text,
    OtherCode,
}

/// All `console` blocks of a page, in order.
pub(super) fn of(page: &str) -> Vec<ConsoleBlock> {
    let mut blocks: Vec<ConsoleBlock> = Vec::new();
    let mut place = Place::Prose;
    // A `text` block belongs to a `console` block only if nothing is between the two.
    let mut follows = false;
    for line in page.lines() {
        let last = blocks.last_mut();
        place = match (place, line) {
            (Place::Prose, "```console") => {
                blocks.push(ConsoleBlock::default());
                Place::Console
            }
            (Place::Prose, "```text") if follows => {
                last.into_iter().for_each(|block| block.shown = Some(String::new()));
                Place::Text
            }
            (Place::Prose, line) if line.starts_with("```") => Place::OtherCode,
            (Place::Prose, line) => {
                follows &= line.is_empty();
                Place::Prose
            }
            (ended, "```") => {
                follows = matches!(ended, Place::Console);
                Place::Prose
            }
            (Place::Console, line) => {
                last.into_iter().for_each(|block| block.commands.extend(command(line)));
                Place::Console
            }
            (Place::Text, line) => {
                if let Some(shown) = last.and_then(|block| block.shown.as_mut()) {
                    *shown += line;
                    shown.push('\n');
                }
                Place::Text
            }
            (Place::OtherCode, _) => Place::OtherCode,
        };
    }
    blocks
}

/// The command of a line `$ cargo ..`, unless it would start this task again or needs a board.
fn command(line: &str) -> Option<String> {
    let command = line.strip_prefix("$ ")?.split(" #").next().unwrap_or_default().trim();
    let again = command.starts_with("cargo xtask test");
    let needs_a_board = command.contains("flash");
    (command.starts_with("cargo ") && !again && !needs_a_board).then(|| command.to_owned())
}

#[cfg(test)]
mod tests {
    use super::{ConsoleBlock, of};

    fn block(commands: &[&str], shown: Option<&str>) -> ConsoleBlock {
        ConsoleBlock {
            commands: commands.iter().map(|&line| line.to_owned()).collect(),
            shown: shown.map(str::to_owned),
        }
    }

    #[test]
    fn commands_are_taken_from_console_blocks_only() {
        let page = "```console\n$ cargo newtau run x   # a comment\noutput\n$ cargo xtask test\n```\n$ cargo outside\n";
        assert_eq!(of(page), [block(&["cargo newtau run x"], None)]);
    }

    #[test]
    fn output_belongs_to_the_block_right_above_it() {
        let page = "```console\n$ cargo a\n```\n```text\none\n\ntwo\n```\n```text\nof nobody\n```\n\
                    ```console\n$ cargo b\n```\nwords\n```text\nof nobody\n```\n```rust\n```console\n```\n";
        assert_eq!(of(page), [block(&["cargo a"], Some("one\n\ntwo\n")), block(&["cargo b"], None)]);
    }
}
