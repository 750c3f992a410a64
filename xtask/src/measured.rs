//! `cargo xtask measured`: reports which pages of docs/measured are current, and renews the others.
//!
//! A measured block of a page ends with a stamp: the command, the commit on which it ran, the machine, and a hash of each artefact that was measured.
//! A test recomputes the hashes. If an artefact has changed since, the test fails and names the command.
//!
//! | module | holds |
//! |---|---|
//! | [`blocks`] | every measured block: its page, its command, its artefacts |
//! | [`artefact`] | artefacts, and their hashes |
//! | [`tokens`] | Rust source without comments, layout and tests, which change no program |
//! | [`stamp`] | the line at the end of a block |

mod artefact;
mod blocks;
mod stamp;
mod tokens;

use crate::process::{root, run as run_command};
use anyhow::{Context as _, Result, bail};
#[cfg(test)]
pub(crate) use artefact::program;
use artefact::{Artefact, Hashes};
use blocks::{BLOCKS, MeasuredBlock};
use firmware_image::BadInput;
use robot_compiler::emit::page::Page;
use stamp::Stamp;
use std::process::Command;

const EXAMPLES: &str = "\
Examples:
  cargo xtask measured                     each block: current, or which artefact has changed, and the command that renews it
  cargo xtask measured --renew             run the commands of all blocks that are not current
  cargo xtask measured --renew --page cycles --page 'campaign, desk'
  cargo xtask measured --mark              say on the pages which blocks are not current
  cargo xtask measured --stamp --page calibration
                                           after a measurement by hand: stamp the page, with the hashes of its sources";

/// Options of `measured`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct MeasuredOptions {
    /// Only these pages of docs/measured, or blocks of pages, by name; with --renew also those that are current
    #[arg(long = "page", value_name = "NAME")]
    pages: Vec<String>,
    /// Measure again everything that is not current
    #[arg(long, conflicts_with = "stamp")]
    renew: bool,
    /// Stamp these pages as measured now, after a measurement by hand
    #[arg(long, requires = "pages")]
    stamp: bool,
    /// Mark every page that is not current, if measuring takes too long now
    #[arg(long, conflicts_with_all = ["stamp", "renew"])]
    mark: bool,
}

/// Shows, renews, stamps or marks. Fails if a block is not current, unless it is renewed or marked.
pub(crate) fn run(options: &MeasuredOptions) -> Result<()> {
    for name in &options.pages {
        if !BLOCKS.iter().any(|block| block.is_called(name)) {
            let mut known: Vec<_> = BLOCKS.iter().map(|block| block.page).collect();
            known.dedup();
            return Err(BadInput(format!("--page {name}: expected a block, or one of {}", known.join(", "))).into());
        }
    }
    let asked =
        |block: &&MeasuredBlock| options.pages.is_empty() || options.pages.iter().any(|name| block.is_called(name));
    let blocks: Vec<&MeasuredBlock> = BLOCKS.iter().filter(asked).collect();
    let mut hashes = Hashes::default();
    if options.stamp {
        return blocks.into_iter().try_for_each(|block| put(block, &Stamp::now(block, &mut hashes)?.to_string()));
    }
    let mut done: Vec<&str> = Vec::new();
    let mut stale = 0;
    for block in blocks {
        let found = state(block, &mut hashes)?;
        if options.renew && (found.is_some() || !options.pages.is_empty()) {
            // Some commands write several blocks.
            if !done.contains(&block.command) {
                renew(block)?;
                done.push(block.command);
            }
            if stamped(block)?.0.is_none() {
                put(block, &Stamp::now(block, &mut hashes)?.to_string())?;
            }
            continue;
        }
        match &found {
            None => println!("{}: current", block.place()),
            Some(why) => println!("{}: {why}; measure it again: {}", block.place(), block.command),
        }
        if options.mark {
            mark(block, found.as_deref())?;
        } else {
            stale += usize::from(found.is_some());
        }
    }
    if stale > 0 { bail!("{stale} measured blocks are not of the present state") } else { Ok(()) }
}

/// Prints tables, and puts them into a document, each between the markers of its name.
pub(crate) fn write_into(document: &str, tables: &[(&str, String)]) -> Result<()> {
    let places: Vec<_> = tables.iter().map(|(name, _)| *name).collect();
    let mut page = Page::read(root().join(document), &places)?;
    for (name, table) in tables {
        println!("{name}\n{table}");
    }
    fill(&mut page, document, tables)?;
    page.write()?;
    println!("written to {document}");
    Ok(())
}

/// Runs the command of a block.
fn renew(block: &MeasuredBlock) -> Result<()> {
    eprintln!("measured: {}: {}", block.place(), block.command);
    let mut words = block.command.split_whitespace();
    let mut command = match words.next() {
        Some("cargo") => Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())),
        Some(script) if script.starts_with("bench/") => Command::new(root().join(script)),
        _ => bail!("{} is measured by hand: {}", block.place(), block.command),
    };
    run_command(command.current_dir(root()).args(words.flat_map(spread)))
}

/// Expands a word of a command as a shell does: `robots/*.toml` becomes every robot file.
fn spread(word: &str) -> Vec<String> {
    let Some((folder, ending)) = word.split_once("/*") else { return vec![word.to_owned()] };
    let entries = std::fs::read_dir(root().join(folder)).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.ends_with(ending))
        .collect();
    names.sort();
    names.into_iter().map(|name| format!("{folder}/{name}")).collect()
}

/// Reason why a block is not current; `None` if it is current.
fn state(block: &MeasuredBlock, hashes: &mut Hashes) -> Result<Option<String>> {
    let (Some(stamp), _) = stamped(block)? else {
        return Ok(Some("it does not say what was measured".to_owned()));
    };
    let mut changed = Vec::new();
    for artefact in block.artefacts {
        if stamp.hash(&artefact.name()) != Some(&hashes.of(*artefact)?) {
            changed.push(artefact.name());
        }
    }
    Ok((!changed.is_empty()).then(|| format!("changed since it was measured: {}", changed.join("; "))))
}

/// Beginning of the line that marks a block as not current.
const MARK: &str = "**Not of the present state**: ";

/// The text of a block.
fn text_of(block: &MeasuredBlock) -> Result<String> {
    let path = root().join(block.path());
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let (begin, end) = (format!("<!-- measured: {} -->", block.name), format!("<!-- end measured: {} -->", block.name));
    let inside =
        text.split_once(&begin).and_then(|(_, rest)| rest.split_once(&end)).map(|(inside, _)| inside.to_owned());
    inside.with_context(|| format!("{}: no lines `{begin}` and `{end}`", block.path()))
}

/// The stamp of a block; true if the block is marked as not current.
fn stamped(block: &MeasuredBlock) -> Result<(Option<Stamp>, bool)> {
    let text = text_of(block)?;
    let stamp = text.lines().find_map(Stamp::parse).transpose().with_context(|| block.place())?;
    Ok((stamp, text.lines().any(|line| line.starts_with(MARK))))
}

/// Marks a block as not current, or removes the mark if `why` is `None`.
fn mark(block: &MeasuredBlock, why: Option<&str>) -> Result<()> {
    let stamp = stamped(block)?.0.map(|stamp| stamp.to_string());
    let mark = why.map(|why| format!("{MARK}{why}. Measure it again: `{}`.", block.command));
    put(block, &mark.into_iter().chain(stamp).collect::<Vec<_>>().join("\n\n"))
}

/// Replaces the stamp and the mark of a block by these last lines.
fn put(block: &MeasuredBlock, last: &str) -> Result<()> {
    let own = |line: &&str| !line.starts_with(stamp::BEGIN) && !line.starts_with(MARK);
    let kept = text_of(block)?.lines().filter(own).collect::<Vec<_>>().join("\n");
    let mut page = Page::read(root().join(block.path()), &[])?;
    page.put(block.name, &format!("{}\n\n{last}", kept.trim()))?;
    Ok(page.write()?)
}

/// Puts texts into the blocks of a document, each between the markers of its name. Blocks of docs/measured get their stamps.
pub(crate) fn fill(page: &mut Page, document: &str, texts: &[(&str, String)]) -> Result<()> {
    let mut hashes = Hashes::default();
    for (name, text) in texts {
        let block = BLOCKS.iter().find(|block| block.path() == document && block.name == *name);
        let stamp = block.map(|block| Stamp::now(block, &mut hashes)).transpose()?;
        page.put(name, &stamp.map_or_else(|| text.clone(), |stamp| format!("{}\n\n{stamp}", text.trim_end())))?;
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::artefact::Hashes;
    use super::blocks::BLOCKS;
    use super::{root, spread, stamped, state};
    use std::collections::BTreeSet;

    /// A page that a separate test compares with its measurement.
    const OWN_TEST: &str = "extremes";

    /// Every block that a page of docs/measured marks is in the list, and every block in the list is marked on a page.
    #[test]
    fn every_measured_block_is_known() {
        let mut found = BTreeSet::new();
        for entry in std::fs::read_dir(root().join("docs/measured")).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "md") {
                continue;
            }
            let page = path.file_stem().unwrap().to_str().unwrap().to_owned();
            let text = std::fs::read_to_string(&path).unwrap();
            let marked: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("<!-- measured: ")).collect();
            assert!(!marked.is_empty() || page == OWN_TEST, "{page} has no measured block");
            found.extend(marked.iter().map(|name| (page.clone(), name.trim_end_matches(" -->").to_owned())));
        }
        let known = BLOCKS.iter().map(|block| (block.page.to_owned(), block.name.to_owned())).collect();
        assert_eq!(found, known);
    }

    #[test]
    fn every_measured_page_is_of_the_present_state_or_says_that_it_is_not() {
        let mut hashes = Hashes::default();
        let mut wrong = Vec::new();
        for block in BLOCKS {
            let place = block.place();
            match (state(block, &mut hashes).unwrap(), stamped(block).unwrap().1) {
                (None, false) | (Some(_), true) => {}
                (None, true) => {
                    wrong.push(format!("{place}: is current, and says that it is not: cargo xtask measured --mark"))
                }
                (Some(why), false) => wrong.push(format!("{place}: {why}; measure it again: {}", block.command)),
            }
        }
        assert!(
            wrong.is_empty(),
            "`cargo xtask measured --renew` measures all of these again; `--mark` says on the pages that they are not current\n{}",
            wrong.join("\n")
        );
    }

    #[test]
    fn a_pattern_is_every_file_that_fits_it() {
        assert_eq!(spread("--write"), ["--write"]);
        let robots = spread("robots/*.toml");
        assert!(robots.len() > 5 && robots.contains(&"robots/ur5.toml".to_owned()), "{robots:?}");
    }
}
