//! Cost of a report for one minute of motion, for `docs/measured/report.md`.

use crate::measured::write_into;
use crate::process::{cargo_run, run as run_command, target_directory};
use crate::table::Table;
use anyhow::{Context as _, Result, ensure};
use std::fs;
use std::time::Instant;

/// A scene with six joints; its report contains the terms of the model.
const SCENE: &str = "scenes/puma560_pick.toml";
/// Simulated time, s.
const DURATION: &str = "60";
/// Number of runs with and without a report, alternating; the shortest of each counts.
const RUNS: usize = 5;

/// Runs one minute of motion with and without a report, and writes the difference.
pub(super) fn run() -> Result<()> {
    let folder = target_directory().join("report/time");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    // Build before timing starts.
    run_command(cargo_run("host-sim").arg("--version"))?;
    let once = |report: &str| -> Result<f64> {
        let mut command = cargo_run("host-sim");
        command.args(["run", SCENE, "--duration", DURATION, "--quiet", "--force", report, "--out"]).arg(&folder);
        let began = Instant::now();
        let done = command.output()?;
        ensure!(done.status.success(), "{SCENE}: {}", String::from_utf8_lossy(&done.stderr));
        Ok(began.elapsed().as_secs_f64())
    };
    let (mut without, mut with) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..RUNS {
        without = without.min(once("--no-report")?);
        with = with.min(once("--report")?);
    }
    let page = folder.join("report.html");
    let bytes = fs::metadata(&page).with_context(|| page.display().to_string())?.len();
    let mut table = Table::new(&["run without, s", "run with, s", "the report, s", "the page, MB"]);
    let seconds = [without, with, with - without].map(|time| format!("{time:.2}"));
    table.row(&[seconds.to_vec(), vec![format!("{:.2}", bytes as f64 / 1e6)]].concat());
    write_into("docs/measured/report.md", &[("report", table.0)])
}
