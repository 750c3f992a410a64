//! Repetition of one run of a study, with full output.

use super::Prepared;
use super::prepared::replace_nothing;
use super::store::{MANIFEST, STUDY};
use indicatif::ProgressBar;
use sim::failure::{Failure, in_file};
use sim::output::Output;
use sim::run::files::{write, write_report};
use sim::run::simulate::Run;
use sim::run::simulation;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// A repeated run, and its files.
#[derive(Debug)]
pub struct Replayed {
    /// The run.
    pub run: Run,
    /// `scene.toml` and `robot.toml` with the run's values, log, summary and report.
    pub files: Vec<PathBuf>,
}

/// Repeats the run with this index, and writes everything that `newtau run` writes, and the scene that it uses.
///
/// # Errors
/// [`Failure::Input`]: the study has no such run, the run's values make no valid scene, or the folder contains a study or another run's files.
/// [`Failure::Output`]: a file cannot be written.
pub fn replay(
    prepared: &Prepared,
    index: u64,
    folder: &Path,
    output: &mut Output,
    stop: &AtomicBool,
    progress: &ProgressBar,
) -> Result<Replayed, Failure> {
    let wrong = |problem: String| Failure::Input(miette::miette!("--replay {index}: {problem}"));
    if index >= prepared.count {
        return Err(wrong(format!("expected a run from 0 to {}", prepared.count - 1)));
    }
    let runs = &prepared.runs;
    // Remaining shards still read the study's files, so those must not be overwritten.
    if [MANIFEST, STUDY].iter().any(|name| folder.join(name).exists()) {
        return Err(wrong(format!("{} holds a study; expected another folder by --out", folder.display())));
    }
    let (scene, robot) = runs.texts(index);
    // The study's copies refer to each other by name; the run's own texts replace them.
    let alone = prepared.stand_alone(&scene, robot.as_deref())?;
    alone.iter().try_for_each(|(name, _)| output.spares(&folder.join(name)))?;
    if !output.is_forced() {
        replace_nothing(
            &alone,
            folder,
            "expected another folder by --out, or one that the same run wrote; or --force",
        )?;
    }
    output.folder(folder, &["log.csv", "summary.json", "report.html"])?;
    let mut files = Vec::new();
    for (name, text) in alone {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|error| in_file(&path, &error))?;
        files.push(path);
    }
    let scene = runs.scene(index)?;
    let run = simulation::run(&scene, stop, progress)?;
    files.extend(write(&run, folder)?);
    files.push(write_report(&run, &scene, &folder.join("report.html"))?);
    output.written(&files)?;
    Ok(Replayed { run, files })
}
