//! Times on the desk, measured after the check that all contestants agree.

use super::build::{self, Job};
use super::contestants::{self, Computation, Family, Ours};
use super::harness::{JOINTS, folder, source};
use anyhow::{Context as _, Result, bail};
use std::io::Write as _;
use std::process::{Command, Stdio};

/// Shortest time of a contestant.
#[derive(Clone, Debug)]
pub(super) struct Time {
    pub(super) family: Family,
    pub(super) task: Computation,
    /// Compiler and options, for the report.
    pub(super) build: &'static str,
    /// Time per state, ns.
    pub(super) ns: f64,
}

/// Torques of one state from the reference.
pub(super) type Torques = [f64; JOINTS];

/// Largest allowed difference of torques from our recursion, relative to the largest torque of the state.
const TORQUE_ERROR_MAX: f64 = 1e-9;

/// The same for accelerations. Their errors are larger by the condition number of the mass matrix.
const ACCELERATION_ERROR_MAX: f64 = 1e-9;

/// Measuring time per arm, s.
const SECONDS: u32 = 20;

fn harness() -> std::path::PathBuf {
    folder().join("harness")
}

/// Builds the harness that times them.
pub(super) fn build() -> Result<()> {
    let job = Job::new("g++", harness()).words("-std=c++17 -O2 -Wall").with(source("harness.cpp"));
    build::all("harness", vec![job.output().words("-ldl")])
}

/// Checks and times all contestants; also returns the reference's torques, state by state.
pub(super) fn measure(arm: &str, ours: &Ours) -> Result<(Vec<Time>, Vec<Torques>)> {
    let mut all = vec![ours.reference(arm)];
    all.extend(contestants::all(arm, ours));
    let line = |(number, contestant): (usize, &contestants::Contestant)| {
        let answer = if contestant.task == Computation::Forward { "accelerations" } else { "torques" };
        let ours_batch = contestant.family == Family::Regrouped && contestant.task == Computation::Many;
        let layout = if ours_batch { "by-joint" } else { "by-state" };
        format!("{number} {} {} {answer} {layout}\n", contestant.library.display(), contestant.symbol)
    };
    let list: String = all.iter().enumerate().map(line).collect();
    let reference = folder().join(arm).join("torques");
    // Run on the last processor, because the first one serves interrupts.
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let mut child = Command::new(harness())
        .args([(processors - 1).to_string(), SECONDS.to_string()])
        .arg(&reference)
        .env("PEERS_ARM", contestants::numbers(arm))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start the harness")?;
    child.stdin.take().context("the harness's input is piped")?.write_all(list.as_bytes())?;
    let output = child.wait_with_output()?;
    if !output.status.success() {
        bail!("the harness gave up: {}", output.status);
    }
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut times = Vec::new();
    for (line, contestant) in said.lines().zip(&all) {
        let numbers: Vec<f64> = line.split(' ').map(str::parse).collect::<Result<_, _>>().context(said.clone())?;
        let [_, ns, error] = numbers[..] else { bail!("not three numbers: {line}") };
        let contestants::Contestant { family, task, build, .. } = *contestant;
        let allowed = if task == Computation::Forward { ACCELERATION_ERROR_MAX } else { TORQUE_ERROR_MAX };
        // NaN counts as a difference too.
        if error.is_nan() || error > allowed {
            bail!("{arm}: {} ({task:?}, {build}) differs from ours by {error:.1e} of the largest", family.name());
        }
        times.push(Time { family, task, build, ns });
    }
    if times.len() != all.len() {
        bail!("the harness measured {} of {}", times.len(), all.len());
    }
    // The reference was needed only for its torques.
    times.remove(0);
    let text = std::fs::read_to_string(&reference).with_context(|| reference.display().to_string())?;
    Ok((times, text.lines().map(torques).collect::<Result<_>>()?))
}

fn torques(line: &str) -> Result<Torques> {
    let numbers: Vec<f64> = line.split(' ').map(str::parse).collect::<Result<_, _>>()?;
    numbers.try_into().ok().with_context(|| format!("not {JOINTS} torques: {line}"))
}

/// Fastest of the times for which `wanted` is true.
pub(super) fn best(times: &[Time], wanted: impl Fn(&Time) -> bool) -> Option<&Time> {
    times.iter().filter(|time| wanted(time)).min_by(|a, b| a.ns.total_cmp(&b.ns))
}
