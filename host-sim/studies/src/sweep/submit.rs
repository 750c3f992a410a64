//! Files for engines that distribute a study's shards to machines. The engine handles queueing and retries.

use super::Prepared;
use super::store::{self, Manifest, STUDY};
use robot_compiler::names::Named;
use sim::failure::{Failure, in_file};
use sim::output::Output;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// An engine that runs shards on several machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// HyperQueue, with an array of tasks.
    HyperQueue,
    /// Slurm, with an array of jobs.
    Slurm,
}

impl Named for Engine {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("hyperqueue", "An array of tasks for HyperQueue", Self::HyperQueue),
        ("slurm", "An array of jobs for Slurm", Self::Slurm),
    ];
}

/// Division of a study into shards.
#[derive(Clone, Debug)]
pub struct Submission {
    /// The engine.
    pub engine: Engine,
    /// Number of shards.
    pub shards: u64,
    /// Number of threads per shard.
    pub threads: usize,
    /// Path of this program on the machines.
    pub program: PathBuf,
}

/// Name of the folder that contains the shards' folders.
const SHARDS: &str = "shards";
/// Number of times that an engine restarts a killed shard.
const RETRIES: u32 = 10;

/// Writes copies of the study's files, `shard.sh`, `merge.sh` and the engine's files; returns their paths, the engine's last.
///
/// # Errors
/// [`Failure::Input`] for more shards than runs, or a folder with a shard of a different division. [`Failure::Output`] if a file cannot be written.
pub fn write(
    prepared: &Prepared,
    submission: &Submission,
    folder: &Path,
    output: &mut Output,
) -> Result<Vec<PathBuf>, Failure> {
    let Submission { engine, shards, .. } = *submission;
    if shards > prepared.count {
        let runs = prepared.count;
        return Err(Failure::Input(miette::miette!(
            "--shards {shards}: expected at most one for each of the {runs} runs"
        )));
    }
    prepared.may_lie_in(folder)?;
    begun_as(shards, folder)?;
    output.folder(folder, &["shard.sh", "merge.sh", "submit.sh", "submit.sbatch"])?;
    fs::create_dir_all(folder.join("logs")).map_err(|error| in_file(folder, &error))?;
    let name = name(&prepared.study.name);
    let own = match engine {
        Engine::HyperQueue => ("submit.sh", hyperqueue(submission, &name)),
        Engine::Slurm => ("submit.sbatch", slurm(submission, &name)),
    };
    let scripts = [("shard.sh", shard(submission)), ("merge.sh", merge(submission)), own];
    let copies = prepared.files.iter().map(|(name, text)| (name.as_str(), text.clone()));
    let written: Result<Vec<PathBuf>, Failure> = copies
        .chain(scripts)
        .map(|(name, text)| {
            let path = folder.join(name);
            let written = fs::write(&path, text).and_then(|()| executable(&path));
            written.map_err(|error| in_file(&path, &error)).map(|()| path)
        })
        .collect();
    let written = written?;
    output.written(&written)?;
    Ok(written)
}

/// Checks that existing shards in a folder have the same number of parts.
fn begun_as(shards: u64, folder: &Path) -> Result<(), Failure> {
    for shard in store::below(&folder.join(SHARDS))? {
        let other = Manifest::read(&shard)?.filter(|manifest| manifest.shard[1] != shards);
        if let Some([number, of]) = other.map(|manifest| manifest.shard) {
            return Err(Failure::Input(miette::miette!(
                help = format!("expected --shards {of}, or another folder"),
                "--shards {shards}: {} holds shard {number}/{of}",
                shard.display()
            )));
        }
    }
    Ok(())
}

/// Makes a script executable.
fn executable(path: &Path) -> io::Result<()> {
    #[cfg(unix)]
    if path.extension().is_some_and(|extension| extension == "sh") {
        use std::os::unix::fs::PermissionsExt as _;
        fs::set_permissions(path, fs::Permissions::from_mode(0o755))?;
    }
    Ok(())
}

/// Converts a name to one that every engine accepts: lower-case letters, digits and hyphens.
fn name(study: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let name: String = study.chars().take(50).map(plain).collect();
    format!("sweep-{}", name.trim_matches('-'))
}

/// Quotes a word for a shell script.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// Line of a script that sets the program, which an environment variable of the machine may override.
fn program(submission: &Submission) -> String {
    format!(
        "program=${{NEWTAU:-}}\n[ -n \"$program\" ] || program={}\n",
        quoted(&submission.program.display().to_string())
    )
}

fn shard(submission: &Submission) -> String {
    let Submission { shards, threads, .. } = submission;
    format!(
        "#!/bin/sh\n\
         # One shard of the study: its number, counted from 1. Begun again after a kill, it goes on where it was.\n\
         set -eu\n\
         cd \"$(dirname \"$0\")\"\n\
         {}exec \"$program\" sweep {STUDY} --shard \"$1/{shards}\" --jobs {threads} --out \"{SHARDS}/$1\" --quiet\n",
        program(submission)
    )
}

fn merge(submission: &Submission) -> String {
    format!(
        "#!/bin/sh\n\
         # All shards are done: put them together.\n\
         set -eu\n\
         cd \"$(dirname \"$0\")\"\n\
         {}exec \"$program\" sweep merge {SHARDS} --out whole\n",
        program(submission)
    )
}

fn hyperqueue(submission: &Submission, name: &str) -> String {
    let Submission { shards, threads, .. } = submission;
    format!(
        "#!/bin/sh\n\
         # A task for each shard. A shard whose worker is lost is begun again, {RETRIES} times at most.\n\
         # Afterwards: ./merge.sh\n\
         set -eu\n\
         cd \"$(dirname \"$0\")\"\n\
         exec hq submit --name {name} --array 1-{shards} --cpus {threads} --crash-limit {RETRIES} \\\n    \
         --stdout 'logs/%{{TASK_ID}}.log' --stderr 'logs/%{{TASK_ID}}.log' \"$@\" -- \\\n    \
         sh -c 'exec ./shard.sh \"$HQ_TASK_ID\"'\n"
    )
}

fn slurm(submission: &Submission, name: &str) -> String {
    let Submission { shards, threads, .. } = submission;
    format!(
        "#!/bin/sh\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --array=1-{shards}\n\
         #SBATCH --cpus-per-task={threads}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --output=logs/%a.log\n\
         # In this folder: sbatch submit.sbatch. A shard whose node is lost is queued again.\n\
         # Slurm's MaxArraySize must be above the number of shards (1001 where nobody changed it).\n\
         # Afterwards: ./merge.sh\n\
         exec ./shard.sh \"$SLURM_ARRAY_TASK_ID\"\n"
    )
}

#[cfg(test)]
mod tests {
    use super::{name, quoted};

    #[test]
    fn names_and_paths_are_safe_in_scripts() {
        assert_eq!(name("Pick & Place_2"), "sweep-pick---place-2");
        assert_eq!(quoted("/a b/it's"), "'/a b/it'\\''s'");
    }
}
