//! The study that every engine does.

use crate::process::{root, run};
use anyhow::{Context as _, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The study on its way through the engines.
pub(super) struct Work {
    pub(super) program: PathBuf,
    pub(super) folder: PathBuf,
    pub(super) python: PathBuf,
    pub(super) runs: u64,
    pub(super) shards: u64,
}

impl Work {
    /// `newtau sweep` of the study.
    pub(super) fn sweep(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.arg("sweep").arg(root().join("bench/scale/study.toml"));
        command.args(["--quiet", "--runs", &self.runs.to_string()]);
        command
    }

    /// Writes what an engine takes; returns its folder.
    pub(super) fn submit(&self, engine: &str) -> Result<PathBuf> {
        let folder = self.folder.join(engine);
        run(self.sweep().args(["--submit", engine, "--shards", &self.shards.to_string(), "--out"]).arg(&folder))?;
        Ok(folder)
    }

    /// Merges an engine's shards, and compares every byte with what one process wrote.
    pub(super) fn same(&self, engine: &str) -> Result<()> {
        let folder = self.folder.join(engine);
        run(Command::new(folder.join("merge.sh")).stdout(std::process::Stdio::null()))?;
        for name in ["runs.csv", "manifest.json", "results.json", "results.md"] {
            let read = |path: &Path| std::fs::read(path).with_context(|| path.display().to_string());
            let same = read(&folder.join("whole").join(name))? == read(&self.folder.join("whole").join(name))?;
            ensure!(same, "{engine}: {name} is not what one process writes");
        }
        eprintln!("scale: {engine}: {} runs in {} shards, every byte the same", self.runs, self.shards);
        Ok(())
    }

    /// Number of shards that have begun to write.
    pub(super) fn begun(&self, engine: &str) -> usize {
        let entries = std::fs::read_dir(self.folder.join(engine).join("shards"));
        entries
            .map_or(0, |entries| entries.flatten().filter(|entry| entry.path().join("manifest.json").exists()).count())
    }
}
