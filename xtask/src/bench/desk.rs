//! Times on the desk, measured by criterion, and the kernel compiler's run time.

use super::json::from_json;
use crate::process::{output, run, target_directory};
use crate::workspace::Workspace;
use anyhow::{Context as _, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// Number of states in one iteration (`bench::states::DESK`).
const STATES: f64 = 1024.0;

/// Nanoseconds per state, by name.
pub(crate) type Times = BTreeMap<String, f64>;

/// Measures everything in one build: the default one, or one for this machine's processor.
pub(crate) fn measure(native: bool) -> Result<Times> {
    let home = target_directory().join("bench").join(if native { "native" } else { "default" });
    // Remove the times of an earlier run, so that they are not mistaken for new ones.
    if home.exists() {
        std::fs::remove_dir_all(&home)?;
    }
    let mut command = Workspace::Bench.cargo(["bench", "--quiet", "--locked", "--package", "bench", "--bench", "desk"]);
    command.env("CRITERION_HOME", &home);
    if native {
        command.env("RUSTFLAGS", "-C target-cpu=native").env("CARGO_TARGET_DIR", target_directory().join("native"));
    }
    run(command.args(["--", "--quiet", "--noplot"]))?;
    let mut times = Times::new();
    for folder in std::fs::read_dir(&home).with_context(|| home.display().to_string())? {
        let folder = folder?.path();
        let samples = folder.join("new/sample.json");
        if samples.is_file() {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            times.insert(name, least(&samples)? / STATES);
        }
    }
    Ok(times)
}

/// The fastest sample, ns per iteration. It estimates the time on an otherwise idle machine.
fn least(samples: &Path) -> Result<f64> {
    let json = from_json(samples)?;
    let list = |name: &str| -> Vec<f64> {
        json[name].as_array().into_iter().flatten().filter_map(serde_json::Value::as_f64).collect()
    };
    let (iterations, times) = (list("iters"), list("times"));
    let each = iterations.iter().zip(&times).map(|(n, t)| t / n);
    each.reduce(f64::min).with_context(|| format!("no samples in {}", samples.display()))
}

/// Run time of the kernel compiler by level, ms. It is optimised here as in the product; for everything else in `bench` it is not.
pub(crate) fn compile_times() -> Result<BTreeMap<String, f64>> {
    let optimised = "profile.release.package.robot-compiler.opt-level=3";
    let run = [
        "run",
        "--quiet",
        "--locked",
        "--release",
        "--config",
        optimised,
        "--package",
        "bench",
        "--bin",
        "compile-time",
    ];
    let mut program = Workspace::Bench.cargo(run);
    let text = output(&mut program).with_context(|| format!("{program:?} failed"))?;
    let rows = text.lines().filter_map(|line| line.split_once(','));
    rows.map(|(level, ms)| Ok((level.to_owned(), ms.parse::<f64>()?))).collect()
}
