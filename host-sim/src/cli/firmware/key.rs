//! `firmware key`: the key that a host and a board share.

use super::failure::failure;
use board::key::{self, KeyError};
use clap::{Args, Subcommand};
use firmware_image::flash;
use link::{Key, key_page};
use sim::failure::Failure;
use std::path::{Path, PathBuf};

/// Arguments of `firmware key`.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Example:\n  newtau firmware key new arm.key")]
pub struct KeyArgs {
    /// The task.
    #[command(subcommand)]
    pub action: KeyAction,
}

/// A task with a key.
#[derive(Clone, Debug, Subcommand)]
pub enum KeyAction {
    /// Make a new key of 32 random bytes, in a file that only its owner can read.
    #[command(after_help = "Example:\n  newtau firmware key new arm.key")]
    New {
        /// The file; it must not exist.
        file: PathBuf,
    },
    /// Write the bytes of a board's key page, for a tool that writes flash.
    #[command(after_help = "Example:\n  newtau firmware key page arm.key --out out/page.bin")]
    Page {
        /// The key file.
        file: PathBuf,
        /// The new file for the page.
        #[arg(long)]
        out: PathBuf,
    },
    /// Write a key to a real board's key page with probe-rs; the program stays as it is.
    #[command(after_help = "Example:\n  newtau firmware key write arm.key --board f405-can --dry-run")]
    Write(flash::key::KeyOptions),
}

/// Loads the key of a `--key` option, if there is one.
///
/// # Errors
/// The file does not contain a key, or others can read it.
pub(crate) fn given(file: Option<&Path>) -> Result<Option<Key>, Failure> {
    file.map(key::load).transpose().map_err(bad)
}

fn bad(error: KeyError) -> Failure {
    Failure::Input(miette::miette!("{error}"))
}

/// Creates a key, or a key page.
///
/// # Errors
/// A file that exists, cannot be written, or does not contain a key.
pub fn run(args: &KeyArgs) -> Result<u8, Failure> {
    match &args.action {
        KeyAction::New { file } => make(file),
        KeyAction::Page { file, out } => page(file, out),
        KeyAction::Write(options) => return to_board(options),
    }
    .map_err(bad)
}

fn page(file: &Path, out: &Path) -> Result<u8, KeyError> {
    key::write_for_owner(out, &key::page(&key::load(file)?)?)?;
    println!("page        {}, for {:#x}", out.display(), key_page::ADDRESS);
    Ok(0)
}

fn to_board(options: &flash::key::KeyOptions) -> Result<u8, Failure> {
    options.check().map_err(failure)?;
    let page = key::load(options.file()).and_then(|key| key::page(&key)).map_err(bad)?;
    flash::key::write(options, &page).map_err(failure)?;
    Ok(0)
}

fn make(file: &Path) -> Result<u8, KeyError> {
    key::save(&key::new()?, file)?;
    println!("key         {}, readable for its owner alone", file.display());
    println!("to a board  newtau firmware key write {} --board BOARD", file.display());
    println!("to connect  newtau connect SCENE --port PORT --key {}", file.display());
    Ok(0)
}
