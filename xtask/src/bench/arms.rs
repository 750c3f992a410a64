//! `cargo xtask bench --arms`: arms that people own, with their drives simulated, beside ideal drives and beside what their makers run.

use super::{Table, write_into};
use crate::budget::variant;
use crate::process::{cargo_run, target_directory};
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use std::path::Path;

/// The arms: name, motion, and the stiffnesses of the maker's own program, where they are known.
const ARMS: [(&str, &str, Option<&str>); 2] = [
    ("I2RT YAM", "scenes/yam_move.toml", Some("[80.0, 80.0, 80.0, 10.0, 10.0, 10.0]")),
    ("Seeed reBot B601-RS", "scenes/rebot_move.toml", None),
];

/// Every link a fifth heavier than the model says.
const HEAVY: (&str, &str) = ("plant.masses", "1.2");

/// Integral action with a dead band of one step of a Damiao reply.
const INTEGRAL: (&str, &str) =
    ("integral", "{ time = 0.2, torque = [4.0, 6.0, 6.0, 2.0, 1.0, 1.0], dead_band = 4e-4 }");

/// What is run of each arm: name, and what it changes in the scene.
fn runs(makers: Option<&str>) -> Vec<(&'static str, Vec<(&'static str, &str)>)> {
    let mut runs = vec![
        ("computed torque, 1 kHz", vec![]),
        ("the same, ideal drives", vec![("actuators.ideal", "true")]),
        ("the same, each link a fifth heavier than its model", vec![HEAVY]),
        ("the same, with integral action", vec![HEAVY, INTEGRAL]),
    ];
    if let Some(stiffness) = makers {
        // A stiffness stands in the place of the frequency.
        let sprung = |law| vec![("law", law), ("natural_frequency", ""), ("stiffness", stiffness)];
        let slow = || [sprung("\"pd-gravity\""), vec![("rate", "250.0")]].concat();
        runs.extend([
            ("PD with gravity, the maker's stiffness and rate, 250 Hz", slow()),
            ("the same, each link a fifth heavier than its model", [slow(), vec![HEAVY]].concat()),
            ("impedance of that stiffness, 1 kHz", sprung("\"impedance\"")),
            ("the same, each link a fifth heavier than its model", [sprung("\"impedance\""), vec![HEAVY]].concat()),
        ]);
    }
    runs
}

/// Runs all, and writes `docs/measured/arms.md`.
pub(super) fn run() -> Result<()> {
    let mut table = Table::new(&["arm", "run", "worst joint: tracking, rms", "largest", "at rest"]);
    for (arm, scene, makers) in ARMS {
        for (number, (name, settings)) in runs(makers).into_iter().enumerate() {
            let path = variant::write(Path::new(scene), &format!("arm-{number}"), &settings)?;
            let summary = simulated(&path)?;
            let worst = |key: &str| worst(&summary, key).with_context(|| format!("{}: {key}", path.display()));
            let cells = [worst("tracking_rms")?, worst("tracking_max")?, worst("rest_error")?];
            let [rms, most, rest] = cells.map(|rad| format!("{:.2} mrad", 1e3 * rad));
            table.row(&[arm.into(), name.into(), rms, most, rest]);
        }
    }
    write_into("docs/measured/arms.md", &[("arms", table.0)])
}

fn simulated(scene: &Path) -> Result<Value> {
    let out = target_directory().join("arms");
    let mut command = cargo_run("host-sim");
    let done = command.arg("run").arg(scene).arg("--json").arg("--out").arg(&out).output()?;
    ensure!(done.status.success(), "{}: {}", scene.display(), String::from_utf8_lossy(&done.stderr));
    Ok(serde_json::from_slice(&done.stdout)?)
}

/// The largest magnitude of a list.
fn worst(summary: &Value, key: &str) -> Option<f64> {
    let values = summary.get(key)?.as_array()?.iter().map(|value| value.as_f64().map(f64::abs));
    values.collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::max)
}
