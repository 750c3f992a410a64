//! HyperQueue on this machine.

use super::work::Work;
use crate::process::{output, root, run, target_directory};
use anyhow::{Context as _, Result, ensure};
use firmware_image::install;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Workers of a core each.
const WORKERS: &str = "2";

/// A virtual environment with the packages of `requirements.txt`; returns its Python.
pub(super) fn install() -> Result<PathBuf> {
    if output(Command::new("python3").args(["-c", "import ensurepip, venv"])).is_none() {
        install::apt(&["python3-venv"])?;
    }
    let folder = target_directory().join("scale-venv");
    let (python, stamp) = (folder.join("bin/python"), folder.join("requirements.txt"));
    let file = root().join("bench/scale/requirements.txt");
    let wanted = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    if python.is_file() && fs::read_to_string(&stamp).is_ok_and(|found| found == wanted) {
        return Ok(python);
    }
    eprintln!("setup: HyperQueue from PyPI, into {}", folder.display());
    run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"];
    run(Command::new(&python).args(install).arg(&file))?;
    // Last: a partial environment has none.
    fs::write(&stamp, wanted)?;
    Ok(python)
}

/// Does the shards on a cluster that is killed on the way, with its workers and what they run, and then on another. Returns the seconds of
/// both.
///
/// HyperQueue's Python package has no worker of its own process, so that the whole cluster is lost.
pub(super) fn hyperqueue(work: &Work) -> Result<f64> {
    let folder = work.submit("hyperqueue")?;
    let mut cluster = Command::new(&work.python);
    cluster.arg(root().join("bench/scale/hyperqueue.py")).arg(&folder).args([&work.shards.to_string(), WORKERS]);
    cluster.stderr(std::process::Stdio::null()).stdout(std::process::Stdio::null());
    let start = Instant::now();
    let mut first = cluster.spawn().context("HyperQueue does not start")?;
    while work.begun("hyperqueue") < work.shards as usize / 4 {
        ensure!(first.try_wait()?.is_none(), "HyperQueue ended by itself before it was killed");
        sleep(Duration::from_millis(20));
    }
    let tasks = descendants(first.id());
    first.kill()?;
    first.wait()?;
    tasks.into_iter().for_each(kill);
    let begun = work.begun("hyperqueue");
    ensure!(begun < work.shards as usize, "all shards had begun before the cluster was killed");
    eprintln!("scale: HyperQueue's cluster killed after {begun} shards had begun; another does them all");
    run(&mut cluster)?;
    Ok(start.elapsed().as_secs_f64())
}

/// Processes below a process, by `/proc`.
pub(super) fn descendants(process: u32) -> Vec<u32> {
    let threads = fs::read_dir(format!("/proc/{process}/task"));
    let of_thread = |thread: fs::DirEntry| fs::read_to_string(thread.path().join("children")).unwrap_or_default();
    let texts: Vec<String> = threads.into_iter().flatten().flatten().map(of_thread).collect();
    let own: Vec<u32> =
        texts.iter().flat_map(|text| text.split_whitespace().filter_map(|word| word.parse().ok())).collect();
    let below: Vec<u32> = own.iter().flat_map(|child| descendants(*child)).collect();
    own.into_iter().chain(below).collect()
}

/// Kills a process that this task has started; one that has ended already is no error.
pub(super) fn kill(process: u32) {
    Command::new("kill").args(["-9", &process.to_string()]).stderr(std::process::Stdio::null()).status().ok();
}
