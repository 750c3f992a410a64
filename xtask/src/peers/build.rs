//! Compiler runs: as many at a time as there are processors, and only after a change.

use super::harness::source;
use anyhow::{Context as _, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::SystemTime;

/// One run of a compiler or a generator.
pub(super) struct Job {
    /// The output file; for a generator, the file that it writes last.
    pub(super) product: PathBuf,
    /// Input files, besides the headers of the harness.
    pub(super) sources: Vec<PathBuf>,
    /// The command; the path of the product is part of it.
    pub(super) command: Command,
}

impl Job {
    /// A run of `program` that makes `product`.
    pub(super) fn new(program: impl AsRef<std::ffi::OsStr>, product: PathBuf) -> Self {
        Self { product, sources: Vec::new(), command: Command::new(program) }
    }

    /// Adds these arguments, split at blanks.
    pub(super) fn words(mut self, words: &str) -> Self {
        self.command.args(words.split_whitespace());
        self
    }

    /// Adds this argument.
    pub(super) fn with(mut self, argument: impl AsRef<std::ffi::OsStr>) -> Self {
        self.command.arg(argument);
        self
    }

    /// Adds this file as an argument and as a source.
    pub(super) fn from(mut self, file: &Path) -> Self {
        self.command.arg(file);
        self.depends_on(file)
    }

    /// Adds a source that is not an argument.
    pub(super) fn depends_on(mut self, file: &Path) -> Self {
        self.sources.push(file.to_owned());
        self
    }

    /// Adds the option that makes a compiler write to the product.
    pub(super) fn output(mut self) -> Self {
        self.command.arg("-o").arg(&self.product);
        self
    }

    /// Path of the file with the command line of the last successful run.
    fn stamp(&self) -> PathBuf {
        let mut name = self.product.clone().into_os_string();
        name.push(".command");
        PathBuf::from(name)
    }

    fn is_fresh(&self, headers: SystemTime) -> bool {
        let Some(made) = modified(&self.stamp()) else { return false };
        let same = std::fs::read_to_string(self.stamp()).is_ok_and(|line| line == format!("{:?}", self.command));
        let newer = |file: &PathBuf| modified(file).is_none_or(|time| time > made);
        same && self.product.is_file() && headers <= made && !self.sources.iter().any(newer)
    }

    fn run(mut self) -> Result<()> {
        if let Some(folder) = self.product.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let output = self.command.output().with_context(|| format!("cannot start {:?}", self.command))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            bail!("{:?} failed: {}\n{said}", self.command, output.status);
        }
        if !self.product.is_file() {
            bail!("{:?} succeeded, but there is no {}", self.command, self.product.display());
        }
        std::fs::write(self.stamp(), format!("{:?}", self.command))?;
        Ok(())
    }
}

/// Runs the jobs whose products are missing or older than their sources.
pub(super) fn all(what: &str, jobs: Vec<Job>) -> Result<()> {
    let headers = newest_header(&source(""))?;
    let (total, mut stale) = (jobs.len(), jobs);
    stale.retain(|job| !job.is_fresh(headers));
    if stale.is_empty() {
        return Ok(());
    }
    eprintln!("peers: {what}: {} of {total} to be built", stale.len());
    stale.reverse();
    let queue = Mutex::new(stale);
    let next = || queue.lock().ok().and_then(|mut jobs| jobs.pop());
    let worker = || -> Result<()> { std::iter::from_fn(next).try_for_each(Job::run) };
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let started: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        started.into_iter().try_for_each(|thread| thread.join().map_err(|_| anyhow!("a build thread stopped"))?)
    })
}

/// Time of the last change of any header; each job names its other files itself.
fn newest_header(folder: &Path) -> Result<SystemTime> {
    let mut newest = SystemTime::UNIX_EPOCH;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "h" || extension == "hpp") {
            newest = newest.max(modified(&path).unwrap_or(newest));
        }
    }
    Ok(newest)
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|data| data.modified()).ok()
}
