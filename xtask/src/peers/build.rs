//! Parallel compiler runs, one for each processor.

use anyhow::{Context as _, Result, anyhow, bail};
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;

/// One run of a compiler or a generator.
pub(super) struct Job {
    /// The output file. For a generator, the file that it writes last.
    pub(super) product: PathBuf,
    /// The command; its arguments include the path of the product.
    pub(super) command: Command,
}

impl Job {
    /// A run of `program` that makes `product`.
    pub(super) fn new(program: impl AsRef<std::ffi::OsStr>, product: PathBuf) -> Self {
        Self { product, command: Command::new(program) }
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

    /// Adds the option `-o` with the path of the product.
    pub(super) fn output(mut self) -> Self {
        self.command.arg("-o").arg(&self.product);
        self
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
        Ok(())
    }
}

/// Runs the jobs, in parallel.
pub(super) fn all(what: &str, mut jobs: Vec<Job>) -> Result<()> {
    eprintln!("peers: {what}: {} to be built", jobs.len());
    // Workers take jobs from the end.
    jobs.reverse();
    let queue = Mutex::new(jobs);
    let next = || queue.lock().ok().and_then(|mut jobs| jobs.pop());
    let worker = || -> Result<()> { std::iter::from_fn(next).try_for_each(Job::run) };
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let started: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        started.into_iter().try_for_each(|thread| thread.join().map_err(|_| anyhow!("a build thread stopped"))?)
    })
}
