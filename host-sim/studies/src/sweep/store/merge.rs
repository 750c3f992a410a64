//! Merging of the folders of all shards into one folder.

use super::manifest::replace;
use super::{MANIFEST, Manifest, RUNS, STUDY, Shard};
use crate::sweep::Prepared;
use crate::sweep::prepared::hexadecimal;
use crate::sweep::results::FILES;
use sha2::{Digest as _, Sha256};
use sim::failure::{Failure, in_file};
use sim::output::Output;
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};

/// Finds the folders of shards among these; a folder without a manifest is replaced by the folders in it.
///
/// # Errors
/// [`Failure::Input`]: a folder cannot be read.
pub fn shards(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut found = Vec::with_capacity(folders.len());
    for folder in folders {
        let below = if folder.join(MANIFEST).exists() { Vec::new() } else { below(folder)? };
        // A folder without subfolders stays, so that it is rejected under its own name.
        if below.is_empty() { found.push(folder.clone()) } else { found.extend(below) }
    }
    Ok(found)
}

/// Folders in a folder, sorted by name; none if the folder does not exist.
pub(in crate::sweep) fn below(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |error: std::io::Error| Failure::Input(miette::miette!("{}: {error}", folder.display()));
    let mut found = match fs::read_dir(folder) {
        Ok(entries) => entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>().map_err(unreadable)?,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        Err(error) => return Err(unreadable(error)),
    };
    found.retain(|path| path.is_dir());
    found.sort();
    Ok(found)
}

/// Merges shards into a folder, with the same bytes that a single process would write. One shard is open at a time, and none is held in memory.
///
/// # Errors
/// [`Failure::Input`]: a folder without a manifest or with an incomplete one; shards of different studies, versions or builds; a gap or an overlap
/// between them; or a table that differs from its manifest.
pub fn merge(
    folders: &[PathBuf],
    out: &Path,
    output: &mut Output,
    after_shard: &dyn Fn(u64),
) -> Result<(Prepared, Manifest), Failure> {
    let shards = in_order(folders)?;
    let Some((first_folder, first)) = shards.first() else {
        return Err(Failure::Input(miette::miette!("no folder to merge: expected those of all shards")));
    };
    let prepared = Prepared::load(&first_folder.join(STUDY), None)?;
    let mut whole = Manifest::new(&prepared, &first.first_run, Shard::WHOLE);
    if let Some(problem) = first.differs(&whole) {
        return Err(refused(
            first_folder,
            problem,
            "expected shards of this version of the program, their files unchanged",
        ));
    }
    if !output.is_forced() {
        if out.join(MANIFEST).exists() {
            return Err(refused(out, "holds runs already".to_owned(), "expected a new folder, or --force"));
        }
        prepared.may_lie_in(out)?;
    }
    output.folder(out, &[FILES, &[RUNS, MANIFEST]].concat())?;
    let beside = out.join("runs.new");
    if let Err(error) = put_together(&shards, &mut whole, &beside, after_shard) {
        // The original failure is reported; if the temporary file cannot be removed, it stays.
        fs::remove_file(&beside).ok();
        return Err(error);
    }
    fs::rename(&beside, out.join(RUNS)).map_err(|error| in_file(&beside, &error))?;
    for (name, text) in &prepared.files {
        replace(&out.join(name), text.as_bytes())?;
    }
    whole.write(out)?;
    Ok((prepared, whole))
}

/// Writes the tables of the shards one after another, and updates the manifest of the whole.
fn put_together(
    shards: &[(PathBuf, Manifest)],
    whole: &mut Manifest,
    path: &Path,
    after_shard: &dyn Fn(u64),
) -> Result<(), Failure> {
    let failed = |error: std::io::Error| in_file(path, &error);
    let mut file = File::create(path).map_err(failed)?;
    let mut hash = Sha256::new();
    for (order, (folder, manifest)) in shards.iter().enumerate() {
        append(folder, manifest, order == 0, |bytes| {
            hash.update(bytes);
            whole.bytes += bytes.len() as u64;
            file.write_all(bytes).map_err(failed)
        })?;
        whole.rows += manifest.rows;
        after_shard(order as u64 + 1);
    }
    whole.sha256 = hexadecimal(&hash.finalize());
    file.sync_data().map_err(failed)
}

fn refused(folder: &Path, problem: String, expected: &str) -> Failure {
    Failure::Input(miette::miette!(help = expected.to_owned(), "{}: {problem}", folder.display()))
}

/// Reads the shards and sorts them by their position in the study.
fn in_order(folders: &[PathBuf]) -> Result<Vec<(PathBuf, Manifest)>, Failure> {
    let mut shards = Vec::with_capacity(folders.len());
    for folder in folders {
        let manifest = Manifest::read(folder)?.ok_or_else(|| {
            refused(folder, format!("has no {MANIFEST}"), "expected the folder of a shard, as `newtau sweep` writes it")
        })?;
        if !manifest.is_complete() {
            let problem = format!("has {} of its {} runs", manifest.rows, manifest.to - manifest.from);
            return Err(refused(folder, problem, "expected all: the command that began the shard continues it"));
        }
        shards.push((folder.clone(), manifest));
    }
    // An empty shard comes before the one that begins at the same index.
    shards.sort_by_key(|(_, manifest)| (manifest.from, manifest.to));
    let mut next = 0;
    let same = |manifest: &Manifest| shards.first().and_then(|(_, first)| manifest.differs(first));
    for (folder, manifest) in &shards {
        if let Some(problem) = same(manifest) {
            let first = shards.first().map_or(String::new(), |(first, _)| first.display().to_string());
            return Err(refused(folder, problem, &format!("expected the study of {first}")));
        }
        if manifest.from != next {
            let problem = if manifest.from > next { "no shard has" } else { "two shards have" };
            let (a, b) = (manifest.from.min(next), manifest.from.max(next));
            let expected = format!("expected runs from {next} on, each in one shard");
            return Err(refused(folder, format!("{problem} the runs from {a} to {}", b - 1), &expected));
        }
        next = manifest.to;
    }
    match shards.last() {
        Some((folder, manifest)) if next != manifest.runs => {
            let problem = format!("no shard has the runs from {next} to {}", manifest.runs - 1);
            Err(refused(folder, problem, "expected all shards of the study"))
        }
        _ => Ok(shards),
    }
}

/// Passes the table of a shard to `hand_on`, with its head only if `head`.
fn append(
    folder: &Path,
    manifest: &Manifest,
    head: bool,
    mut hand_on: impl FnMut(&[u8]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let path = folder.join(RUNS);
    let unreadable = |error: std::io::Error| Failure::Input(miette::miette!("{}: {error}", path.display()));
    let mut reader = BufReader::with_capacity(1 << 20, File::open(&path).map_err(unreadable)?);
    let mut hash = Sha256::new();
    let mut title = Vec::new();
    // A head is short; a file without a line end is not a table.
    (&mut reader).take(1 << 16).read_until(b'\n', &mut title).map_err(unreadable)?;
    hash.update(&title);
    let mut bytes = title.len() as u64;
    if head {
        hand_on(&title)?;
    }
    loop {
        let read = reader.fill_buf().map_err(unreadable)?;
        if read.is_empty() {
            break;
        }
        let count = read.len();
        hash.update(read);
        hand_on(read)?;
        bytes += count as u64;
        reader.consume(count);
    }
    if bytes == manifest.bytes && hexadecimal(&hash.finalize()) == manifest.sha256 {
        return Ok(());
    }
    let problem = format!("{RUNS} is not what {MANIFEST} says: damaged or changed");
    Err(refused(folder, problem, "expected the table as it was written; remove the folder and do the shard again"))
}
