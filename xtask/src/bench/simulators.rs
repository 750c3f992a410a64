//! `cargo xtask bench --simulators`: compares the simulator's speed with MuJoCo's, for one run and for many runs at the same time.
//!
//! Our time is that of the whole loop: controller, sensors, record and figures of every tick. MuJoCo's time is that of its step alone, in a C loop of
//! its own.

mod errors;
mod setup;

use crate::measured::write_into;
use crate::process::{cargo_run, root, run as run_command, target_directory};
use crate::table::Table;
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use setup::{SCENE, STEP, Settings, scene};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

const ROBOT: &str = "robots/puma560.toml";

/// Simulated time of the scene, s.
const DURATION: f64 = 2.1;

/// Run counts of two studies. Their difference in time is the cost of the additional runs, without start-up costs.
const RUNS: [u32; 2] = [64, 320];

/// Integration methods: name, settings of the scene, MuJoCo's name.
const METHODS: [(&str, Settings, Option<&str>); 5] = [
    ("adaptive, tolerance 1e-9 (the scene's own)", &[], None),
    ("adaptive, tolerance 1e-6", &[("plant.tolerance", "1e-6")], None),
    ("adaptive, tolerance 1e-3", &[("plant.tolerance", "1e-3")], None),
    (
        "Runge-Kutta, step 0.25 ms",
        &[("plant.integrator", "\"runge-kutta\""), ("plant.tolerance", ""), ("plant.step", "0.25e-3")],
        Some("RK4"),
    ),
    (
        "semi-implicit Euler, step 0.25 ms",
        &[("plant.integrator", "\"semi-implicit-euler\""), ("plant.tolerance", ""), ("plant.step", "0.25e-3")],
        Some("Euler"),
    ),
];

/// Measures all, and writes `docs/measured/simulators.md`.
pub(super) fn run() -> Result<()> {
    let folder = target_directory().join("simulators");
    std::fs::create_dir_all(&folder)?;
    run_command(cargo_run("host-sim").arg("--version"))?;
    let truth = [errors::Truth::new(true, &folder)?, errors::Truth::new(false, &folder)?];
    let peer = mujoco(&folder, &truth)?;
    let mut table = Table::new(&[
        "integrator",
        "friction",
        "threads",
        "error, rad",
        "alone",
        "side by side",
        "steps alone",
        "MuJoCo: error, rad",
        "steps alone",
        "ours / MuJoCo's",
    ]);
    let mut at_quarter = Vec::new();
    for (number, (name, settings, theirs)) in METHODS.into_iter().enumerate() {
        for (with_friction, truth) in [true, false].into_iter().zip(&truth) {
            let friction = [("plant.friction", if with_friction { "true" } else { "false" })];
            let scene = scene(&format!("{number}-{with_friction}"), &[settings, &friction].concat())?;
            let alone = alone(&scene, &folder)?;
            let whole = side_by_side(&scene, &folder, RUNS)?;
            let together = DURATION / whole;
            // Run again with a step a quarter as long: the difference is the time of three times as many additional steps.
            let steps = match theirs {
                None => None,
                Some(_) => {
                    let finer = [("plant.step", "0.0625e-3")];
                    let finer = setup::scene(
                        &format!("{number}-{with_friction}-finer"),
                        &[settings, &friction, &finer].concat(),
                    )?;
                    Some(3.0 * DURATION / (side_by_side(&finer, &folder, RUNS)? - whole))
                }
            };
            let error = truth.error(settings, &folder)?;
            let rival = theirs.map(|method| errors::of_mujoco(&peer, method, with_friction)).transpose()?;
            let pace = rival.as_ref().map(|rival| STEP / (rival.ns * 1e-9));
            if let (Some(ours), Some(pace), Some(method)) = (steps, pace, theirs) {
                at_quarter.push(errors::Pace { method, with_friction, ours, mujoco: pace });
            }
            let or = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.1}"));
            let their_error = rival.and_then(|rival| rival.error(STEP)).map_or("-".to_owned(), errors::short);
            table.row(&[
                name.into(),
                (if with_friction { "viscous, Coulomb" } else { "none" }).into(),
                "1".into(),
                errors::short(error),
                format!("{alone:.0}"),
                format!("{together:.0}"),
                or(steps),
                their_error,
                or(pace),
                or(steps.zip(pace).map(|(ours, theirs)| ours / theirs)),
            ]);
        }
    }
    let equal = errors::at_equal_error(&at_quarter, &truth, &peer, &folder)?;
    let mut linear = Table::new(&["simulated time", "runs", "ms a run"]);
    for (duration, label) in [("0.525", "0.525 s"), ("1.05", "1.05 s"), ("2.1", "2.1 s")] {
        for runs in [[64, 192], [64, 320], [64, 576]] {
            // A fixed-step method: the adaptive method needs more steps where friction reverses or holds.
            let settings = [METHODS[3].1, &[(".duration", duration)]].concat();
            let scene = scene(&format!("linear-{duration}"), &settings)?;
            let cost = side_by_side(&scene, &folder, runs)?;
            linear.row(&[label.into(), (runs[1] - runs[0]).to_string(), format!("{:.2}", cost * 1e3)]);
        }
    }
    let mut agreement = Table::new(&["MuJoCo", "friction", "largest difference in position, rad"]);
    let version = peer.get("version").and_then(Value::as_str).unwrap_or("?");
    for (with_friction, label) in [(false, "none"), (true, "viscous, Coulomb")] {
        let apart = errors::apart(&peer, with_friction)?;
        agreement.row(&[version.into(), label.into(), errors::short(apart)]);
    }
    write_into(
        "docs/measured/simulators.md",
        &[
            ("simulators", table.0),
            ("simulators, equal error", equal.0),
            ("simulators, cost by time and runs", linear.0),
            ("simulators, agreement", agreement.0),
        ],
    )
}

/// MuJoCo's times and errors.
fn mujoco(folder: &Path, truth: &[errors::Truth; 2]) -> Result<Value> {
    let tools = root().join("bench/simulators");
    let python = crate::setup::python(&folder.join("venv"), &tools.join("requirements.txt"))?;
    let output = Command::new(python)
        .arg(tools.join("mujoco_steps.py"))
        .args([root().join(ROBOT), root().join(SCENE)])
        .args(truth.iter().map(|truth| &truth.log))
        .output()?;
    ensure!(output.status.success(), "mujoco_steps.py: {}", String::from_utf8_lossy(&output.stderr));
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// Ratio of simulated to real time for one run: the best of five.
fn alone(scene: &Path, folder: &Path) -> Result<f64> {
    let mut best = 0.0_f64;
    for _ in 0..5 {
        let mut command = cargo_run("host-sim");
        let done =
            command.arg("run").arg(scene).args(["--json", "--force", "--out"]).arg(folder.join("alone")).output()?;
        ensure!(done.status.success(), "{}: {}", scene.display(), String::from_utf8_lossy(&done.stderr));
        let summary: Value = serde_json::from_slice(&done.stdout)?;
        best = best.max(summary.get("realtime_factor").and_then(Value::as_f64).context("no `realtime_factor`")?);
    }
    Ok(best)
}

/// Time per run of a study on one core, s: the best of five.
fn side_by_side(scene: &Path, folder: &Path, runs: [u32; 2]) -> Result<f64> {
    let study = folder.join("study.toml");
    let text = format!(
        "name = \"simulators\"\nscene = \"{}\"\n[runs]\ncount = {}\nseed = 1\n[[vary]]\nkey = \"robot.joint.*.mass\"\n\
         uniform = [0.95, 1.05]\nrelative = \"factor\"\n[[metric]]\nname = \"tracking_max\"\n",
        scene.display(),
        runs[1]
    );
    std::fs::write(&study, text)?;
    let once = |count: u32| -> Result<f64> {
        let out = folder.join("runs");
        std::fs::remove_dir_all(&out).ok();
        let mut command = cargo_run("host-sim");
        command.arg("sweep").arg(&study).args(["--jobs", "1", "--quiet", "--runs", &count.to_string(), "--out"]);
        let began = Instant::now();
        let done = command.arg(&out).output()?;
        ensure!(done.status.success(), "{}: {}", study.display(), String::from_utf8_lossy(&done.stderr));
        Ok(began.elapsed().as_secs_f64())
    };
    // The two studies alternate, because the speed of a shared machine varies.
    let mut best = [f64::INFINITY; 2];
    for _ in 0..5 {
        for (best, count) in best.iter_mut().zip(runs) {
            *best = best.min(once(count)?);
        }
    }
    Ok((best[1] - best[0]) / f64::from(runs[1] - runs[0]))
}
