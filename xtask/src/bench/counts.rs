//! Instructions on the desk, counted by callgrind through gungraun.

use super::baseline::BaselineCounts;
use super::json::from_json;
use crate::process::{run, target_directory};
use crate::workspace::Workspace;
use anyhow::{Context as _, Result, bail};
use std::path::{Path, PathBuf};

/// Runs every counted benchmark; returns instructions by name, for all states together.
pub(crate) fn count() -> Result<BaselineCounts> {
    crate::setup::gungraun()?;
    let home = target_directory().join("gungraun");
    // Remove the counts of an earlier run, so that they are not mistaken for new ones.
    if home.exists() {
        std::fs::remove_dir_all(&home)?;
    }
    let mut command =
        Workspace::Bench.cargo(["bench", "--quiet", "--locked", "--package", "bench", "--bench", "counts"]);
    run(command
        .args(["--", "--save-summary=json", "--nosummary"])
        .env("GUNGRAUN_HOME", &home)
        .stdout(std::process::Stdio::null()))?;
    let mut files = Vec::new();
    summaries(&home, &mut files)?;
    let counts: BaselineCounts = files.iter().map(|path| read(path)).collect::<Result<_>>()?;
    if counts.is_empty() {
        bail!("gungraun left no summary in {}", home.display());
    }
    Ok(counts)
}

fn summaries(folder: &Path, found: &mut Vec<PathBuf>) -> Result<()> {
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            summaries(&path, found)?;
        } else if path.file_name().is_some_and(|name| name == "summary.json") {
            found.push(path);
        }
    }
    Ok(())
}

/// Name and instructions of one benchmark.
fn read(path: &Path) -> Result<(String, u64)> {
    let json = from_json(path)?;
    let name = json["id"].as_str().map(str::to_owned);
    let count = json["profiles"][0]["data"]["total"]["metrics"]["Ir"]["values"]["new"].as_u64();
    name.zip(count).with_context(|| format!("no name or no count in {}", path.display()))
}
