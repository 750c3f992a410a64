//! Reading of a page: the steps in its blocks, with the comments that say how they are tested.
//!
//! A comment directly above a block, which no reader sees, says how the block is tested:
//!
//! | comment | meaning |
//! |---|---|
//! | `<!-- test: write FILE -->` | the block is the content of this file |
//! | `<!-- test: replace START in FILE -->` | the block replaces the first line of the file that starts with START |
//! | `<!-- test: insert before START in FILE -->` | the block comes before that line |
//! | `<!-- test: not run, REASON -->` | the commands are not run; the reason is one of [`REASONS`] |
//! | `<!-- test: exit CODE -->` | the last command ends with this code; without the comment, 0 is expected |
//! | `<!-- test: not compared -->` | the commands are run; their output depends on the machine |
//! | `<!-- test: typed -->` | the command runs at a terminal, and gets the lines after `> ` and the keys, such as `(Esc)`, of its `text` blocks |
//! | `<!-- test: more output -->` | the `text` block shows the next part of the output of the last `console` block |
//! | `<!-- test: run CALL -->` | the `text` block shows a part of the output of `newtau CALL`, which no reader sees |
//! | `<!-- test: no output, KIND -->` | the `text` block is no output of a command; the kind is one of [`KINDS`] |
//! | `<!-- test: after PAGE -->` | anywhere in a page: it continues in that page's folder |
//!
//! `write`, the edits and `run` may have lines of their own before `-->`: the new text, so that no block is expected, or lines that are typed at a
//! terminal before those of the block. Every `text` block, and every block without a language, is directly below a call or has such a comment.

use super::compare::ANY_LINES;
use super::step::{Console, Edit, How, Page, Step};
use anyhow::{Context as _, Result, bail, ensure};

/// Reasons for which a test cannot run a command.
pub(super) const REASONS: [&str; 7] = [
    "needs a board",
    "needs a CAN adapter",
    "needs your own file",
    "needs a cluster",
    "needs a new part of the program",
    "measures for minutes",
    "runs in real time",
];

/// Comments of a `text` block.
const MORE: &str = "more output";
const PART: &str = "part of the output";
const EXPECTED: &str =
    "put it right below its command, or `<!-- test: more output, run CALL or no output, KIND -->` above it";

/// Kinds of `text` blocks that are compared with nothing.
pub(super) const KINDS: [&str; 7] = [
    "formula",
    "diagram",
    "commands",
    "message with names in capitals",
    "packets, tested by link/tests/page.rs",
    "needs a board",
    "a record that was changed by hand",
];

/// Reads a page.
pub(super) fn of(page: &str) -> Result<Page> {
    let mut found = Page::default();
    let mut lines = page.lines().enumerate();
    // What the comment above the next block says, and whether nothing is between here and the block above.
    let (mut comment, mut follows) = (None, false);
    while let Some((number, line)) = lines.next() {
        let line = line.trim();
        let at = || format!("line {}", number + 1);
        if let Some(start) = line.strip_prefix("<!-- test: ") {
            let mut more = Vec::new();
            let words = start.strip_suffix("-->").map(str::trim);
            if words.is_none() {
                more.extend(lines.by_ref().map(|(_, line)| line).take_while(|line| line.trim() != "-->"));
            }
            let words = words.unwrap_or(start);
            match (words.strip_prefix("after "), words.strip_prefix("run ")) {
                (Some(page), _) => found.after = Some(page.to_owned()),
                (_, Some(call)) => {
                    let how = if more.is_empty() { How::Compared { exit: 0 } } else { How::Typed };
                    let typed = more.iter().flat_map(|line| [ANY_LINES, line]).chain([ANY_LINES]);
                    let (calls, shown) = (vec![call.to_owned()], vec![typed.collect::<Vec<_>>().join("\n")]);
                    found.steps.push(Step::Run(Console { line: number + 1, calls, how, shown }));
                    comment = Some(PART.to_owned());
                }
                _ if more.is_empty() => comment = Some(words.to_owned()),
                _ => found.steps.push(edited(words, &more).with_context(at)?),
            }
        } else if let Some(language) = line.strip_prefix("```") {
            let block: Vec<&str> =
                lines.by_ref().map(|(_, line)| line).take_while(|line| line.trim() != "```").collect();
            let is_text = language == "text" || language.is_empty();
            match (language, comment.take().as_deref()) {
                ("console", said) => {
                    let how = how(said).with_context(at)?;
                    let calls = calls(&block);
                    follows = !calls.is_empty();
                    found.steps.push(Step::Run(Console { line: number + 1, calls, how, shown: Vec::new() }));
                    continue;
                }
                (_, said @ (None | Some(MORE | PART))) if is_text => {
                    ensure!(follows || said.is_some(), "{}: a `text` block of no command; {EXPECTED}", at());
                    let above = found.steps.iter_mut().rev().find_map(|step| match step {
                        Step::Run(console) if !console.calls.is_empty() => Some(&mut console.shown),
                        _ => None,
                    });
                    let shown = above.with_context(|| format!("{}: no command is above", at()))?;
                    shown.push(block.join("\n"));
                    shown.extend((said == Some(PART)).then(|| ANY_LINES.to_owned()));
                }
                (_, Some(words))
                    if is_text && KINDS.iter().any(|kind| words.strip_prefix("no output, ") == Some(kind)) => {}
                (_, Some(words)) => found.steps.push(edited(words, &block).with_context(at)?),
                (_, None) => {}
            }
            follows = false;
        } else {
            ensure!(comment.is_none() || line.is_empty(), "{}: a comment `test:` is above no block", at());
            follows &= line.is_empty();
        }
    }
    Ok(found)
}

/// The step of a comment that writes or changes a file.
fn edited(words: &str, block: &[&str]) -> Result<Step> {
    let text: String = block.iter().flat_map(|line| [line, "\n"]).collect();
    if let Some(file) = words.strip_prefix("write ") {
        return Ok(Step::Write { file: file.to_owned(), text });
    }
    let (keeps_the_line, rest) = match (words.strip_prefix("replace "), words.strip_prefix("insert before ")) {
        (Some(rest), _) => (false, rest),
        (None, Some(rest)) => (true, rest),
        (None, None) => bail!("unknown comment `test: {words}`; kinds of blocks that are no output are {KINDS:?}"),
    };
    let (start, file) = rest.rsplit_once(" in ").context("expected `START in FILE`")?;
    Ok(Step::Edit(Edit { file: file.to_owned(), start: start.to_owned(), text, keeps_the_line }))
}

fn how(said: Option<&str>) -> Result<How> {
    Ok(match said {
        None => How::Compared { exit: 0 },
        Some("typed") => How::Typed,
        Some("not compared") => How::NotCompared,
        Some(words) => match (words.strip_prefix("not run, "), words.strip_prefix("exit ")) {
            (Some(reason), _) if REASONS.contains(&reason) => How::NotRun,
            (None, Some(code)) => How::Compared { exit: code.parse()? },
            _ => bail!("unknown comment `test: {words}`; reasons not to run a command are {REASONS:?}"),
        },
    })
}

/// Calls of the program in a `console` block.
fn calls(block: &[&str]) -> Vec<String> {
    let joined = block.join("\n").replace("\\\n", " ");
    let calls = joined.lines().filter_map(|line| {
        let line = line.trim().trim_start_matches("$ ");
        let call = line.strip_prefix("cargo newtau ").or_else(|| line.strip_prefix("newtau "))?;
        Some(call.split(" #").next().unwrap_or_default().trim().to_owned())
    });
    calls.collect()
}

#[cfg(test)]
mod tests {
    use super::{Console, Edit, How, Page, Step, of};

    fn console(line: usize, calls: &[&str], how: How, shown: &[&str]) -> Step {
        let owned = |texts: &[&str]| texts.iter().map(|&text| text.to_owned()).collect();
        Step::Run(Console { line, calls: owned(calls), how, shown: owned(shown) })
    }

    fn steps(page: &str) -> Vec<Step> {
        of(page).unwrap().steps
    }

    const OK: How = How::Compared { exit: 0 };

    #[test]
    fn calls_are_taken_from_console_blocks_only() {
        let page = "```console\n$ cargo newtau run x   # a comment\n$ cargo xtask test\n   newtau sweep \\\n  y\n```\n\
                    $ cargo newtau outside\n```rust\nnewtau inside\n```\n";
        assert_eq!(steps(page), [console(1, &["run x", "sweep    y"], OK, &[])]);
    }

    #[test]
    fn output_belongs_to_the_block_right_above_it() {
        let page = "```console\n$ newtau a\n```\n\n```text\none\n\ntwo\n```\n\
                    ```console\n$ newtau b\n```\nwords\n<!-- test: more output -->\n```text\nof b\n```\n```rust\n```console\n```\n";
        assert_eq!(steps(page), [console(1, &["a"], OK, &["one\n\ntwo"]), console(10, &["b"], OK, &["of b"])]);
    }

    #[test]
    fn a_typed_session_goes_on_in_further_blocks() {
        let more = "words\n<!-- test: more output -->\n```text\n> arm\n(Esc)\n```\n";
        let page = format!("<!-- test: typed -->\n```console\nnewtau a\n```\n{more}{more}");
        assert_eq!(steps(&page), [console(2, &["a"], How::Typed, &["> arm\n(Esc)"; 2])]);
    }

    #[test]
    fn a_command_may_be_hidden_from_the_reader() {
        let page = "<!-- test: run a b -->\n```text\nx\n```\n<!-- test: run c\n> arm\n-->\n```text\n> run\n```\n";
        let typed = ["...\n> arm\n...", "> run", "..."];
        assert_eq!(
            steps(page),
            [console(1, &["a b"], OK, &["...", "x", "..."]), console(5, &["c"], How::Typed, &typed)]
        );
    }

    #[test]
    fn every_text_block_is_compared_or_says_why_not() {
        let above = |comment: &str, fence: &str| of(&format!("words\n{comment}\n```{fence}\na = b\n```\n"));
        for fence in ["text", ""] {
            assert!(above("<!-- test: no output, formula -->", fence).unwrap().steps.is_empty());
            let error = above("", fence).unwrap_err().to_string();
            assert!(error.starts_with("line 3: a `text` block of no command"), "{error}");
            for wrong in ["no output, no time", "no output", "more output"] {
                assert!(above(&format!("<!-- test: {wrong} -->"), fence).is_err(), "{wrong}");
            }
        }
        let prose_between = "```console\nnewtau a\n```\nwords\n```text\nof nobody\n```\n";
        let second = "```console\nnewtau a\n```\n```text\none\n```\n```text\ntwo\n```\n";
        let of_another = "```console\ncargo test\n```\n```text\nok\n```\n";
        assert!([prose_between, second, of_another].iter().all(|page| of(page).is_err()) && above("", "toml").is_ok());
        assert!(above("<!-- test: no output, formula -->", "toml").is_err(), "only of text");
    }

    #[test]
    fn a_comment_says_how_a_block_is_tested() {
        let of_comment = |comment: &str| of(&format!("<!-- test: {comment} -->\n\n```console\nnewtau a\n```\n"));
        for (comment, how) in [
            ("not run, needs a board", How::NotRun),
            ("exit 3", How::Compared { exit: 3 }),
            ("not compared", How::NotCompared),
        ] {
            assert_eq!(of_comment(comment).unwrap().steps, [console(3, &["a"], how, &[])]);
        }
        for wrong in ["not run, no time", "exit early", "hidden"] {
            assert!(of_comment(wrong).is_err(), "{wrong}");
        }
        assert!(of("<!-- test: exit 3 -->\nwords\n```console\n```\n").is_err(), "above no block");
        let Page { steps, after } = of("<!-- test: after docs/a.md -->\nwords\n").unwrap();
        assert_eq!((steps.len(), after.as_deref()), (0, Some("docs/a.md")));
    }

    #[test]
    fn files_are_written_and_edited() {
        let page = "<!-- test: write a/b.toml -->\n```toml\nx = 1\n```\n\
                    <!-- test: replace x = in a/b.toml\nx = 2\n-->\n\
                    <!-- test: insert before [[joint]] in a/b.toml -->\n```toml\ny = 3\n```\n";
        let edit = |start: &str, text: &str, keeps_the_line| {
            Step::Edit(Edit { file: "a/b.toml".into(), start: start.into(), text: text.into(), keeps_the_line })
        };
        let write = Step::Write { file: "a/b.toml".into(), text: "x = 1\n".into() };
        assert_eq!(steps(page), [write, edit("x =", "x = 2\n", false), edit("[[joint]]", "y = 3\n", true)]);
    }
}
