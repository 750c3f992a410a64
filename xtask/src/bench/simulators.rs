//! `cargo xtask bench --simulators`: the simulator's speed, alone and side by side, beside MuJoCo's, all in one run.
//!
//! Ours is a whole loop: controller, sensors, record and figures of every tick. MuJoCo's is its step alone, in its own loop in C.

use super::{Table, write_into};
use crate::budget::variant;
use crate::process::{cargo_run, root, run as run_command, target_directory};
use crate::setup;
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const SCENE: &str = "scenes/puma560_pick.toml";
const ROBOT: &str = "robots/puma560.toml";

/// Step that both take, s, and the scene's time, s.
const STEP: f64 = 0.25e-3;
const DURATION: f64 = 2.1;

/// Runs of a study from which the cost of one is taken: the difference of the two, so that what comes once does not count.
const RUNS: [u32; 2] = [64, 320];

/// Keys of a scene and their values.
type Settings = &'static [(&'static str, &'static str)];

/// A way to integrate: name, settings of the scene, MuJoCo's name.
const METHODS: [(&str, Settings, Option<&str>); 3] = [
    ("as the scene has it: adaptive, 1e-9", &[], None),
    (
        "Runge-Kutta, 0.25 ms",
        &[("plant.integrator", "\"runge-kutta\""), ("plant.tolerance", ""), ("plant.step", "0.25e-3")],
        Some("RK4"),
    ),
    (
        "semi-implicit Euler, 0.25 ms",
        &[("plant.integrator", "\"semi-implicit-euler\""), ("plant.tolerance", ""), ("plant.step", "0.25e-3")],
        Some("Euler"),
    ),
];

/// Measures all, and writes `docs/measured/simulators.md`.
pub(super) fn run() -> Result<()> {
    let folder = target_directory().join("simulators");
    std::fs::create_dir_all(&folder)?;
    run_command(cargo_run("host-sim").arg("--version"))?;
    let peer = mujoco(&folder)?;
    let mut table = Table::new(&[
        "method",
        "friction",
        "alone",
        "side by side",
        "steps alone",
        "MuJoCo's steps alone",
        "steps alone / MuJoCo's",
    ]);
    for (name, settings, theirs) in METHODS {
        for rubs in [true, false] {
            let friction = [("plant.friction", if rubs { "true" } else { "false" })];
            let scene = scene(&format!("{}-{rubs}", name.len()), &[settings, &friction].concat())?;
            let alone = alone(&scene, &folder)?;
            let whole = side_by_side(&scene, &folder, RUNS)?;
            let together = DURATION / whole;
            // What three times as many steps again cost is the cost of the steps.
            let steps = match theirs {
                None => None,
                Some(_) => {
                    let finer = [("plant.step", "0.0625e-3")];
                    let finer =
                        self::scene(&format!("{}-{rubs}-finer", name.len()), &[settings, &friction, &finer].concat())?;
                    Some(3.0 * DURATION / (side_by_side(&finer, &folder, RUNS)? - whole))
                }
            };
            let theirs = theirs.and_then(|method| nanoseconds(&peer, method, rubs)).map(|ns| STEP / (ns * 1e-9));
            let or = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.1}"));
            let friction = if rubs { "viscous, Coulomb" } else { "none" };
            let cells = [name.into(), friction.into(), format!("{alone:.0}"), format!("{together:.0}")];
            let ratio = steps.zip(theirs).map(|(ours, theirs)| ours / theirs);
            table.row(&[cells.to_vec(), vec![or(steps), or(theirs), or(ratio)]].concat());
        }
    }
    let mut linear = Table::new(&["simulated time", "runs", "ms a run"]);
    for (duration, label) in [("0.525", "0.525 s"), ("1.05", "1.05 s"), ("2.1", "2.1 s")] {
        for runs in [[64, 192], [64, 320], [64, 576]] {
            // Steps of one length: the adaptive method takes more of them where friction turns or holds.
            let settings = [METHODS[1].1, &[(".duration", duration)]].concat();
            let scene = scene(&format!("linear-{duration}"), &settings)?;
            let cost = side_by_side(&scene, &folder, runs)?;
            linear.row(&[label.into(), (runs[1] - runs[0]).to_string(), format!("{:.2}", cost * 1e3)]);
        }
    }
    let mut agreement = Table::new(&["MuJoCo", "largest difference in position, rad"]);
    let version = peer.get("version").and_then(Value::as_str).unwrap_or("?");
    let apart = peer.get("apart").and_then(Value::as_f64).context("MuJoCo's answer has no `apart`")?;
    agreement.row(&[version.into(), format!("{apart:.1e}")]);
    write_into(
        "docs/measured/simulators.md",
        &[
            ("simulators", table.0),
            ("simulators, cost by time and runs", linear.0),
            ("simulators, agreement", agreement.0),
        ],
    )
}

/// The scene with settings, and the motion's own duration.
fn scene(name: &str, settings: &[(&str, &str)]) -> Result<PathBuf> {
    variant::write(Path::new(SCENE), &format!("simulators-{name}"), settings)
}

/// MuJoCo's steps, and its distance from a log of ours.
fn mujoco(folder: &Path) -> Result<Value> {
    let tools = root().join("xtask/bench/simulators");
    let python = setup::python(&folder.join("venv"), &tools.join("requirements.txt"))?;
    let settings = [METHODS[1].1, &[("plant.friction", "false")]].concat();
    let scene = scene("log", &settings)?;
    let out = folder.join("log");
    let done = cargo_run("host-sim").arg("run").arg(&scene).args(["--quiet", "--force", "--out"]).arg(&out).status()?;
    ensure!(done.success(), "{}: the run failed", scene.display());
    let output = Command::new(python)
        .arg(tools.join("mujoco_steps.py"))
        .args([root().join(ROBOT), root().join(SCENE)])
        .arg(STEP.to_string())
        .arg(out.join("log.csv"))
        .output()?;
    ensure!(output.status.success(), "mujoco_steps.py: {}", String::from_utf8_lossy(&output.stderr));
    Ok(serde_json::from_slice(&output.stdout)?)
}

fn nanoseconds(peer: &Value, method: &str, rubs: bool) -> Option<f64> {
    let asked = |step: &&Value| {
        step.get("method").and_then(Value::as_str) == Some(method)
            && step.get("friction").and_then(Value::as_bool) == Some(rubs)
    };
    peer.get("steps")?.as_array()?.iter().find(asked)?.get("ns")?.as_f64()
}

/// Times faster than real of one run: the best of some.
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

/// Seconds of one run of a study on one core: the best of some.
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
    // In turns: a machine that others use too is now fast, now slow.
    let mut best = [f64::INFINITY; 2];
    for _ in 0..5 {
        for (best, count) in best.iter_mut().zip(runs) {
            *best = best.min(once(count)?);
        }
    }
    Ok((best[1] - best[0]) / f64::from(runs[1] - runs[0]))
}
