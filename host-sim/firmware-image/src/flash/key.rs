//! `firmware key write`: writes a link key to a board's key page.
//!
//! The page is the chip's last sector (`memory.x`). Writing the program does not change it, because the tool erases only the sectors that it writes.

use super::{Board, Chip, PROBE_TOOL, is_real, line, no_tool, probe_call, run_steps};
use crate::process::{which, write_for_owner};
use crate::scratch::ScratchFile;
use anyhow::Result;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Options of `firmware key write`.
#[derive(Clone, Debug, clap::Args)]
pub struct KeyOptions {
    /// The key file, made by `newtau firmware key new`
    file: PathBuf,
    /// The board that the probe is wired to
    #[arg(long, value_enum)]
    board: Board,
    /// The probe, if there are several: VID:PID or VID:PID:SERIAL, as `probe-rs list` shows it
    #[arg(long, value_name = "SELECTOR")]
    probe: Option<String>,
    /// Check the key, and print the commands without running them
    #[arg(long)]
    dry_run: bool,
}

impl KeyOptions {
    /// The key file.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Rejects a board that has no key page.
    ///
    /// # Errors
    /// [`BadInput`](crate::BadInput): the emulated board.
    pub fn check(&self) -> Result<()> {
        is_real(self.board)
    }
}

/// Writes a key page through a probe. `page` is made from the key in [`KeyOptions::file`].
///
/// # Errors
/// [`BadInput`](crate::BadInput) for an emulated board or a missing tool; a tool that fails.
pub fn write(options: &KeyOptions, page: &[u8]) -> Result<()> {
    options.check()?;
    let page = Page::of(page)?;
    let steps = steps(options.board.chip(), options.probe.as_deref(), page.0.path());
    if options.dry_run {
        steps.iter().for_each(|step| println!("$ {PROBE_TOOL} {}", line(step)));
        return Ok(());
    }
    let tool = which(PROBE_TOOL).ok_or_else(no_tool)?;
    run_steps(&tool, &steps)?;
    println!("the board has the key: `newtau doctor --port PORT --key {}` checks it", options.file.display());
    Ok(())
}

fn steps(chip: Chip, probe: Option<&str>, page: &Path) -> [Vec<OsString>; 2] {
    let place = ["--verify", "--binary-format", "bin", "--base-address", chip.key_page()];
    [probe_call(chip, "download", probe, &place, Some(page)), probe_call(chip, "reset", probe, &[], None)]
}

/// A page as a file that only its owner can read; deleted on drop.
struct Page(ScratchFile);

impl Page {
    fn of(bytes: &[u8]) -> Result<Self> {
        let page = Self(ScratchFile::new("key-page.bin")?);
        write_for_owner(page.0.path(), bytes)?;
        Ok(page)
    }
}
