//! Files that commands write. An existing file is overwritten only if this program wrote it and it has not changed since, or if `--force` is given.
//!
//! A folder that this program created contains `.newtau-output.json`: names and SHA-256 of the files that it wrote there. The program does not write
//! into a folder that has other files and no such marker. A command never overwrites its own input, not even with `--force`.

use crate::failure::{Failure, in_file};
use crate::marker::{self, MARKER, Marker};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Folder of all default outputs, relative to the working directory.
const DEFAULT: &str = "out";

/// Outputs of one command. Claim them before the work, and register them after it.
#[derive(Clone, Debug, Default)]
pub struct Output {
    force: bool,
    inputs: Vec<PathBuf>,
    claimed: Vec<PathBuf>,
}

impl Output {
    /// Outputs of a command. With `force`, existing files may be overwritten.
    #[must_use]
    pub fn new(force: bool) -> Self {
        Self { force, inputs: Vec::new(), claimed: Vec::new() }
    }

    /// Adds an input of the command: a file that it never overwrites.
    #[must_use]
    pub fn reads(mut self, path: &Path) -> Self {
        self.inputs.push(path.to_owned());
        self
    }

    /// True if existing files may be overwritten.
    #[must_use]
    pub fn is_forced(&self) -> bool {
        self.force
    }

    /// Claims a file, and makes the folders above it.
    ///
    /// # Errors
    /// [`Failure::Input`]: the file is an input of the command or another output of it, or it exists and may not be overwritten.
    /// [`Failure::Output`]: a folder cannot be made.
    pub fn file(&mut self, path: &Path) -> Result<(), Failure> {
        self.may_write(path)?;
        if self.claimed.iter().any(|other| is_same(other, path)) {
            return Err(refused(path, "two outputs of this command in one file", "expected a file for each"));
        }
        self.claimed.push(path.to_owned());
        make(parent(path))
    }

    /// Claims a folder, and makes it. `names` are the files that will be written there.
    ///
    /// # Errors
    /// [`Failure::Input`]: the folder holds files and this program did not make it, or one of these files exists and may not be
    /// overwritten. [`Failure::Output`]: the folder cannot be made.
    pub fn folder(&mut self, folder: &Path, names: &[&str]) -> Result<(), Failure> {
        self.claim(folder, names, false)
    }

    /// As [`Output::folder`], for a folder that contains other files of this program, with or without a marker.
    ///
    /// # Errors
    /// As [`Output::folder`].
    pub fn known_folder(&mut self, folder: &Path, names: &[&str]) -> Result<(), Failure> {
        self.claim(folder, names, true)
    }

    fn claim(&self, folder: &Path, names: &[&str], known: bool) -> Result<(), Failure> {
        if folder.exists() && !folder.is_dir() {
            return Err(refused(folder, "is a file", "expected a folder"));
        }
        let held = entries(folder)?;
        let others: Vec<&str> = held.iter().map(String::as_str).filter(|name| !Marker::is_named(name)).collect();
        let ours = known || Marker::is_in(folder);
        if !ours && !others.is_empty() && !self.force {
            let some = others.iter().take(3).copied().collect::<Vec<_>>().join(", ");
            let more = if others.len() > 3 { format!(" and {} more", others.len() - 3) } else { String::new() };
            let found = format!("the folder holds {some}{more}, and newtau did not make it");
            return Err(refused(
                folder,
                &found,
                "expected a new or empty folder, or one that newtau made; --force writes into it",
            ));
        }
        let written = |name: &&str| names.contains(name);
        others.into_iter().filter(written).try_for_each(|name| self.may_write(&folder.join(name)))?;
        make(folder)?;
        Marker::adopt(folder)
    }

    /// Rejects an output file that is an input of the command.
    ///
    /// # Errors
    /// [`Failure::Input`]: the file is an input.
    pub fn spares(&self, path: &Path) -> Result<(), Failure> {
        if self.inputs.iter().any(|input| is_same(input, path)) {
            return Err(refused(
                path,
                "is an input of this command and is not overwritten",
                "expected another name for the output",
            ));
        }
        Ok(())
    }

    fn may_write(&self, path: &Path) -> Result<(), Failure> {
        self.spares(path)?;
        let Ok(data) = fs::metadata(path) else { return Ok(()) };
        if data.is_dir() {
            return Err(refused(path, "is a folder", "expected a file"));
        }
        // A terminal, a pipe or /dev/null: writing destroys no data.
        if self.force || !data.is_file() {
            return Ok(());
        }
        let marker = Marker::read(parent(path));
        let known = marker.digest(path);
        let expected = "expected another name, or --force to overwrite it";
        match known {
            Some(known) if marker::digest(path).is_ok_and(|now| now == known) => Ok(()),
            Some(_) => Err(refused(path, "the file was changed since newtau wrote it", expected)),
            None => Err(refused(path, "the file exists", expected)),
        }
    }

    /// Registers files that were written, so that the next command may replace them. Files in folders that newtau did not create are not registered.
    ///
    /// # Errors
    /// [`Failure::Output`]: a marker cannot be written.
    pub fn written(&self, files: &[PathBuf]) -> Result<(), Failure> {
        let mut folders: Vec<&Path> = files.iter().map(|file| parent(file)).collect();
        folders.sort_unstable();
        folders.dedup();
        for folder in folders {
            let in_default = folder.is_relative() && folder.starts_with(DEFAULT);
            if !in_default && !Marker::is_in(folder) {
                continue;
            }
            let mut marker = Marker::read(folder);
            for file in files.iter().filter(|file| parent(file) == folder && file.is_file()) {
                marker.set(file).map_err(|error| in_file(file, &error))?;
            }
            marker.write(folder).map_err(|error| in_file(&folder.join(MARKER), &error))?;
        }
        Ok(())
    }

    /// Registers all claimed files that exist.
    ///
    /// # Errors
    /// As [`Output::written`].
    pub fn finish(&self) -> Result<(), Failure> {
        self.written(&self.claimed)
    }

    /// Claims a file, writes it and registers it.
    ///
    /// # Errors
    /// As [`Output::file`]; [`Failure::Output`]: the file cannot be written.
    pub fn write(&mut self, path: &Path, text: impl AsRef<[u8]>) -> Result<(), Failure> {
        self.file(path)?;
        fs::write(path, text).map_err(|error| in_file(path, &error))?;
        self.written(&[path.to_owned()])
    }
}

fn refused(path: &Path, found: &str, expected: &str) -> Failure {
    Failure::Input(miette::miette!(help = expected.to_owned(), "{}: {found}", path.display()))
}

fn parent(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// True if both paths are the same file: equal paths, or links to the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    if a == b {
        return true;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let id = |path: &Path| fs::metadata(path).ok().map(|data| (data.dev(), data.ino()));
        if let (Some(a), Some(b)) = (id(a), id(b)) {
            return a == b;
        }
    }
    let whole = |path: &Path| {
        let folder = fs::canonicalize(parent(path)).ok()?;
        Some(folder.join(path.file_name()?))
    };
    whole(a).is_some_and(|a| whole(b) == Some(a))
}

/// Names in a folder; none if it does not exist.
fn entries(folder: &Path) -> Result<Vec<String>, Failure> {
    let read = || -> io::Result<Vec<String>> {
        fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
    };
    match read() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(in_file(folder, &error)),
        Ok(mut names) => {
            names.sort();
            Ok(names)
        }
    }
}

/// Creates a folder and the missing ones above it, each with a marker.
fn make(folder: &Path) -> Result<(), Failure> {
    if folder.is_dir() {
        return Ok(());
    }
    make(parent(folder)).and_then(|()| match fs::create_dir(folder) {
        // Another process has just created the folder, and marks it.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => Ok(()),
        Err(error) => Err(in_file(folder, &error)),
        Ok(()) => Marker::adopt(folder),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests;
