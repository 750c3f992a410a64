//! `cargo xtask bench --peers`: compares the speed of other projects' dynamics with ours, on the desk and on the chip.
//!
//! | module | holds |
//! |---|---|
//! | [`harness`] | arms and file locations of the harness |
//! | [`install`] | the peers' packages, from PyPI and Debian |
//! | [`build`] | parallel compiler runs |
//! | [`contestants`] | the contestants and their builds |
//! | [`desk`] | times, and the check that all torques agree |
//! | [`chip`] | instructions in the emulator |
//! | [`report`] | ratios and tables of `docs/measured/peers.md` |
//!
//! The harness is C and C++ in `bench/peers`; our side of it is the crate `bench-peers`. Every contestant is the same C function over the same
//! states. The peers get their model from the robot file by `bench/peers/arm.py`, which shares nothing with our reader. If a torque differs, the run
//! ends without a result.

mod build;
mod chip;
mod contestants;
mod desk;
mod harness;
mod install;
mod report;

use crate::measured;
use crate::process::root;
use anyhow::Result;
use harness::ARMS;
use report::PLACE;
use robot_compiler::emit::page::Page;

/// The page with the tables.
const DOCUMENT: &str = "docs/measured/peers.md";

/// Installs, builds, checks, measures, and reports: on the terminal and in the documentation.
pub(crate) fn run() -> Result<()> {
    // Check first that the page has the markers for its tables, because the run takes an hour.
    let mut page = Page::read(root().join(DOCUMENT), &[PLACE])?;
    let python = install::all()?;
    let ours = contestants::Ours::build()?;
    contestants::generate(&python)?;
    desk::build()?;
    let mut measured = Vec::new();
    for arm in ARMS {
        eprintln!("peers: measuring the {arm}");
        let (desk, torques) = desk::measure(arm, &ours)?;
        let chip = chip::measure(arm, &ours, &torques)?;
        measured.push(report::PeerMeasurements { arm, desk, chip });
    }
    let tables = report::markdown(&measured)?;
    println!("{tables}");
    measured::fill(&mut page, DOCUMENT, &[(PLACE, tables)])?;
    Ok(page.write()?)
}
