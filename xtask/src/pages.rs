//! Check of the pages: their commands are run as a reader would run them, and their output is compared with the output shown below them.
//!
//! | module | holds |
//! |---|---|
//! | [`step`] | commands of a page, the output shown for them, and files that the reader writes |
//! | [`blocks`] | reading of these steps from the blocks of a page |
//! | [`compare`] | comparison of shown and printed output, with times masked |
//! | [`program`] | the program, run in a folder or at a terminal |

mod blocks;
mod compare;
mod program;
mod step;

use crate::budget;
use crate::process::root;
use anyhow::{Context as _, Result, bail, ensure};
use compare::Masked;
use firmware_image::BadInput;
use program::Program;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use step::{Console, Edit, How, Page, Step};

/// Fewest commands that are run: a mistake in the reading of pages cannot leave out most of them.
const AT_LEAST: usize = 60;

/// Runs every call of `newtau` in the `console` blocks of the README and of the pages below `docs`, except those that a comment excludes. Compares the
/// output with the `text` block that follows.
///
/// Each page starts in an empty folder with the project's robots and scenes, as a reader does. The files that a page tells the reader to write are
/// written there.
///
/// With `only`, these pages alone, and those in whose folders they continue.
pub(crate) fn run_commands(only: &[String]) -> Result<()> {
    let mut pages = read_all()?;
    if let Some(unknown) = only.iter().find(|&page| !pages.contains_key(page)) {
        bail!(BadInput(format!("{unknown} is no page; expected README.md or a page below docs")));
    }
    let before: Vec<_> = only.iter().filter_map(|page| pages[page].after.clone()).collect();
    pages.retain(|name, _| only.is_empty() || only.contains(name) || before.contains(name));
    let masked = if budget::is_of_this_compiler()? { Masked::Times } else { Masked::TimesAndInstructions };
    let mut run = Run { program: Program::build()?, masked, commands: 0, not_run: 0, wrong: Vec::new() };
    // Pages that continue in the folder of another one come after it.
    let (later, first): (Vec<_>, Vec<_>) = pages.iter().partition(|(_, page)| page.after.is_some());
    for (name, page) in first.into_iter().chain(later) {
        let folder = folder(page.after.as_deref().unwrap_or(name));
        if page.after.is_none() {
            fresh(&folder)?;
        }
        ensure!(folder.is_dir(), "{name} continues in the folder of a page that has none: {:?}", page.after);
        run.page(name, page, &folder).with_context(|| name.clone())?;
    }
    let Run { commands, not_run, wrong, .. } = run;
    eprintln!("{commands} commands of the pages were run, {not_run} were not");
    ensure!(
        !only.is_empty() || commands >= AT_LEAST,
        "{commands} commands of the pages were run, expected {AT_LEAST} or more"
    );
    ensure!(wrong.is_empty(), "pages show something else than their commands print\n{}", wrong.join("\n"));
    Ok(())
}

/// The README and all pages below `docs`, by their path.
fn read_all() -> Result<BTreeMap<String, Page>> {
    let mut names = vec!["README.md".to_owned()];
    let mut folders = vec![root().join("docs")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                names.push(path.strip_prefix(root())?.to_string_lossy().into_owned());
            }
        }
    }
    let read = |name: String| {
        let page = blocks::of(&fs::read_to_string(root().join(&name))?).with_context(|| name.clone())?;
        Ok((name, page))
    };
    names.into_iter().map(read).collect()
}

/// Folder in which the commands of a page are run.
fn folder(page: &str) -> PathBuf {
    crate::process::target_directory().join("pages").join(page.trim_end_matches(".md"))
}

/// Makes an empty folder with the project's robots and scenes, which are linked.
fn fresh(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)?;
    for inputs in ["robots", "scenes"] {
        std::os::unix::fs::symlink(root().join(inputs), folder.join(inputs))?;
    }
    Ok(())
}

/// The commands of all pages.
struct Run {
    program: Program,
    masked: Masked,
    commands: usize,
    not_run: usize,
    wrong: Vec<String>,
}

impl Run {
    /// Does what a page says.
    fn page(&mut self, name: &str, page: &Page, folder: &Path) -> Result<()> {
        for step in &page.steps {
            match step {
                Step::Write { file, text } => {
                    let path = folder.join(file);
                    fs::create_dir_all(path.parent().unwrap_or(folder))?;
                    fs::write(&path, text)?;
                }
                Step::Edit(edit) => edited(edit, folder)?,
                Step::Run(console) if console.how == How::NotRun => self.not_run += console.calls.len(),
                Step::Run(console) => self.console(name, console, folder)?,
            }
        }
        Ok(())
    }

    /// Runs the commands of a block, and compares their output.
    fn console(&mut self, page: &str, console: &Console, folder: &Path) -> Result<()> {
        let mut printed = String::new();
        let mut last = 0;
        for (index, call) in console.calls.iter().enumerate() {
            eprintln!("{page}:{}: newtau {call}", console.line);
            let is_last = index + 1 == console.calls.len();
            let output = match console.how {
                How::Typed => self.program.typed(call, folder, &console.shown)?,
                _ => self.program.run(call, folder)?,
            };
            let expected = match console.how {
                How::Compared { exit } if is_last => exit,
                _ => 0,
            };
            // `doctor` reports with code 2 what a machine lacks.
            let lacks = call.starts_with("doctor") && console.how == How::NotCompared && output.code == Some(2);
            if output.code != Some(expected) && !lacks {
                let end: Vec<_> = output.printed.lines().rev().take(6).collect();
                let end: Vec<_> = end.into_iter().rev().collect();
                self.wrong.push(format!(
                    "{page}:{}: newtau {call}\n  exit code {:?}, expected {expected}\n{}",
                    console.line,
                    output.code,
                    end.join("\n")
                ));
            }
            printed += &output.printed;
            last = index;
            self.commands += 1;
        }
        if console.how == How::NotCompared || console.shown.is_empty() || console.calls.is_empty() {
            return Ok(());
        }
        let shown = console.shown.join("\n");
        let difference = match console.how {
            How::Typed => {
                // Without a simulated link, time passes only while a command needs it, not by the clock.
                let paced = console.calls[last].contains("--simulate-link");
                let difference = compare::difference_typed(&shown, &printed, paced);
                difference.map(|at| format!("{at}\n  the whole session:\n{printed}"))
            }
            _ => compare::difference(&shown, &printed, self.masked),
        };
        if let Some(at) = difference {
            self.wrong.push(format!("{page}:{}: newtau {}\n{at}", console.line, console.calls[last]));
        }
        Ok(())
    }
}

/// Changes a file as the page tells the reader to.
fn edited(edit: &Edit, folder: &Path) -> Result<()> {
    let path = folder.join(&edit.file);
    let before = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let line = before.lines().find(|line| line.starts_with(&edit.start));
    let line = line.with_context(|| format!("{} has no line that starts with {:?}", edit.file, edit.start))?;
    let kept = if edit.keeps_the_line { format!("{line}\n") } else { String::new() };
    // The found line is the first that starts so, but its text could be part of an earlier one.
    let mut done = false;
    let after = before.lines().map(|one| {
        if !done && one == line {
            done = true;
            format!("{}{kept}", edit.text)
        } else {
            format!("{one}\n")
        }
    });
    fs::write(&path, after.collect::<String>())?;
    Ok(())
}
