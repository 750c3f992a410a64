//! Writing of a study's rows into a folder, block by block.

use super::manifest::replace;
use super::{Manifest, RUNS, Shard};
use crate::sweep::Prepared;
use crate::sweep::prepared::hexadecimal;
use sha2::{Digest as _, Sha256};
use sim::failure::{Failure, in_file};
use sim::parallel::Jobs;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Part to write, and settings for the work.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Part of the study.
    pub shard: Shard,
    /// Threads to use.
    pub jobs: &'a Jobs,
    /// Stops the work after the last whole block.
    pub stop: &'a AtomicBool,
    /// Called with the number of rows after each block.
    pub after_block: &'a dyn Fn(u64),
}

/// Result of the work.
#[derive(Clone, Debug)]
pub struct Done {
    /// State of the table.
    pub manifest: Manifest,
    /// Number of rows that already existed.
    pub found: u64,
    /// Time for the other rows.
    pub time: Duration,
}

/// Duration of a block: the work that a killed process can lose.
const BLOCK: Duration = Duration::from_millis(500);
/// Largest number of rows in a block; these are in memory together.
const BLOCK_MAX: u64 = 16_384;

/// Does the runs of a shard that the folder does not have yet, and saves each block as soon as it is done.
///
/// # Errors
/// [`Failure::Input`]: the folder contains another study or shard. [`Failure::Target`]: another process writes there. [`Failure::Interrupted`] after
/// `stop`: all blocks until then are kept.
pub fn write(prepared: &Prepared, folder: &Path, progress: &Progress<'_>) -> Result<Done, Failure> {
    fs::create_dir_all(folder).map_err(|error| in_file(folder, &error))?;
    let first_run = first_run(prepared, progress)?;
    let fresh = Manifest::new(prepared, &first_run, progress.shard);
    let known = Manifest::read(folder)?;
    match &known {
        Some(known) => fits(known, &fresh, folder)?,
        None => prepared.may_lie_in(folder)?,
    }
    let path = folder.join(RUNS);
    let failed = |error: std::io::Error| in_file(&path, &error);
    let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
    let mut file = options.map_err(failed)?;
    lock(&file, &path)?;
    // Read it again now that the lock excludes other writers.
    let known = Manifest::read(folder)?;
    match &known {
        Some(known) => fits(known, &fresh, folder)?,
        // Before anything is in the table, because a table without a manifest is a stranger's file: after a kill it could not be continued.
        None if file.metadata().is_ok_and(|file| file.len() == 0) => fresh.write(folder)?,
        None => {}
    }
    let known = known.filter(|known| known.rows > 0);
    let (mut manifest, mut hash) = match known {
        Some(known) => match sure(&mut file, &known).map_err(failed)? {
            Some(hash) => (known, hash),
            None => {
                eprintln!("{}: not what its manifest says; all its runs are done again", path.display());
                (fresh, Sha256::new())
            }
        },
        None => (fresh, Sha256::new()),
    };
    for (name, text) in &prepared.files {
        replace(&folder.join(name), text.as_bytes())?;
    }
    file.set_len(manifest.bytes).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed)?;
    let found = manifest.rows;
    let start = Instant::now();
    let mut block = progress.jobs.count() as u64;
    (progress.after_block)(manifest.rows);
    let mut keep = |manifest: &mut Manifest, rows: u64, bytes: &[u8]| -> Result<(), Failure> {
        hash.update(bytes);
        file.write_all(bytes).and_then(|()| file.sync_data()).map_err(failed)?;
        manifest.rows += rows;
        manifest.bytes += bytes.len() as u64;
        manifest.sha256 = hexadecimal(&hash.clone().finalize());
        manifest.write(folder)
    };
    if manifest.bytes == 0 {
        keep(&mut manifest, 0, &lines(&[prepared.columns()])?)?;
    }
    while !manifest.is_complete() {
        let before = Instant::now();
        let next = manifest.from + manifest.rows;
        let end = manifest.to.min(next + block);
        let rows = prepared.outcomes(next..end, progress.jobs, progress.stop)?;
        keep(&mut manifest, end - next, &lines(&rows)?)?;
        (progress.after_block)(manifest.rows);
        if before.elapsed() < BLOCK / 2 {
            block = (block * 2).min(BLOCK_MAX);
        } else if before.elapsed() > BLOCK * 2 {
            block = (block / 2).max(progress.jobs.count() as u64);
        }
    }
    Ok(Done { manifest, found, time: start.elapsed() })
}

/// Hash of the study's first run.
fn first_run(prepared: &Prepared, progress: &Progress<'_>) -> Result<String, Failure> {
    let rows = prepared.outcomes(0..1, progress.jobs, progress.stop)?;
    Ok(hexadecimal(&Sha256::digest(lines(&rows)?)))
}

/// Rejects a folder that contains another study or shard.
fn fits(known: &Manifest, wanted: &Manifest, folder: &Path) -> Result<(), Failure> {
    let shard = || format!("shard {}/{}, not {}/{}", known.shard[0], known.shard[1], wanted.shard[0], wanted.shard[1]);
    let differs = known.differs(wanted).or_else(|| (known.shard != wanted.shard).then(shard));
    differs.map_or(Ok(()), |problem| {
        Err(Failure::Input(miette::miette!(
            help = "expected an empty folder, or one with a part of the same study: the same command continues it",
            "{}: holds {problem}",
            folder.display()
        )))
    })
}

fn lock(file: &File, path: &Path) -> Result<(), Failure> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            let problem = miette::miette!("{}: another process writes here", path.display());
            Err(Failure::Target(problem))
        }
        // The file system has no locks. The files for engines give each shard a separate folder.
        Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// Hash of the bytes that the manifest guarantees; `None` if the file does not contain them.
fn sure(file: &mut File, manifest: &Manifest) -> std::io::Result<Option<Sha256>> {
    let mut hash = Sha256::new();
    let mut left = manifest.bytes;
    let mut buffer = vec![0; 1 << 16];
    file.seek(SeekFrom::Start(0))?;
    while left > 0 {
        let wanted = buffer.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        let read = file.read(&mut buffer[..wanted])?;
        if read == 0 {
            return Ok(None);
        }
        hash.update(&buffer[..read]);
        left -= read as u64;
    }
    Ok((hexadecimal(&hash.clone().finalize()) == manifest.sha256).then_some(hash))
}

/// Formats rows as lines of a CSV file.
fn lines(rows: &[Vec<String>]) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let written = rows.iter().try_for_each(|row| writer.write_record(row));
    written.map_err(|error| Failure::Output(error.into()))?;
    writer.into_inner().map_err(|error| Failure::Output(std::io::Error::other(error.to_string())))
}
