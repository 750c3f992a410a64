//! `firmware key`: a link key into a board's key page.
//!
//! The page is the chip's last sector (`memory.x`), which writing the program does not touch: the tool erases the sectors that it
//! writes, and no others.

use super::{Board, Chip, PROBE_TOOL, is_real, line, no_tool, probe_call, run_steps};
use crate::bad_input::BadInput;
use crate::process::{cargo_run, which};
use anyhow::Result;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Options of `firmware key`.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// The key file, made by `newtau firmware key new`
    file: PathBuf,
    /// The board that the probe is wired to
    #[arg(long, value_enum)]
    board: Board,
    /// Which probe, where there are several: VID:PID or VID:PID:SERIAL as `probe-rs list` shows them
    #[arg(long, value_name = "SELECTOR")]
    probe: Option<String>,
    /// Check the key, print the commands, and run none
    #[arg(long)]
    dry_run: bool,
}

/// Write the key's page through a probe.
///
/// # Errors
/// [`BadInput`] for an emulated board, a file that is no key, or a missing tool; a tool that fails.
pub(crate) fn write(options: &Options) -> Result<()> {
    is_real(options.board)?;
    let page = Page::of(&options.file)?;
    let steps = steps(options.board.chip(), options.probe.as_deref(), &page.0);
    if options.dry_run {
        steps.iter().for_each(|step| println!("$ {PROBE_TOOL} {}", line(step)));
        return Ok(());
    }
    let tool = which(PROBE_TOOL).ok_or_else(no_tool)?;
    run_steps(&tool, &steps)?;
    println!("the board has the key: `cargo newtau doctor --port PORT --key {}` checks it", options.file.display());
    Ok(())
}

fn steps(chip: Chip, probe: Option<&str>, page: &Path) -> [Vec<OsString>; 2] {
    let place = ["--verify", "--binary-format", "bin", "--base-address", chip.key_page()];
    [probe_call(chip, "download", probe, &place, Some(page)), probe_call(chip, "reset", probe, &[], None)]
}

/// A page as a file that only its owner can read; deleted on drop.
struct Page(PathBuf);

impl Page {
    fn of(key: &Path) -> Result<Self> {
        let key = std::path::absolute(key)?;
        let page = Self(std::env::temp_dir().join(format!("newtau-key-page-{}.bin", std::process::id())));
        // Left over from a killed process with the same id.
        std::fs::remove_file(&page.0).ok();
        let made =
            cargo_run("host-sim").args(["firmware", "key", "page"]).arg(&key).arg("--out").arg(&page.0).output()?;
        if made.status.success() {
            return Ok(page);
        }
        let complaint = String::from_utf8_lossy(&made.stderr);
        // The simulator's report marks its message; warnings of a compiler may come before.
        let why = complaint.rsplit_once("× ").map_or(complaint.trim(), |(_, why)| why.trim());
        Err(BadInput(why.to_owned()).into())
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}
