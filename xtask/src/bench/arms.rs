//! `cargo xtask bench --arms`: commercially available arms in simulation, with simulated drives, with ideal drives, and with the control law of the
//! maker's own program.

use crate::budget::variant;
use crate::measured::write_into;
use crate::process::{cargo_run, target_directory};
use crate::table::Table;
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use std::path::Path;

/// The arms: name, scene, and the stiffnesses of the maker's own program if they are known.
const ARMS: [(&str, &str, Option<&str>); 2] = [
    ("I2RT YAM", "scenes/yam_move.toml", Some("[80.0, 80.0, 80.0, 10.0, 10.0, 10.0]")),
    ("Seeed reBot B601-RS", "scenes/rebot_move.toml", None),
];

/// Every link 20 % heavier than the model.
const HEAVY: (&str, &str) = ("plant.masses", "1.2");

/// Integral action with a dead band of half a step of a reply.
const INTEGRAL: (&str, &str) =
    ("integral", "{ time = 0.2, torque = [4.0, 6.0, 6.0, 2.0, 1.0, 1.0], dead_band = 2e-4 }");

/// The drives' own position loops, with twice the natural frequency that computed torque has here.
const SPLIT: (&str, &str) = ("law", "\"split\"");
const STIFFER: (&str, &str) = ("natural_frequency", "40.0");

/// Long enough for the integral action to settle.
const LONG: (&str, &str) = (".duration", "12.0");

/// Runs of each arm: name, and changes to the scene.
fn runs(makers: Option<&str>) -> Vec<(&'static str, Vec<(&'static str, &str)>)> {
    let mut runs = vec![
        ("computed torque, 1 kHz", vec![]),
        ("the same, ideal drives", vec![("actuators.ideal", "true")]),
        ("the same, each link a fifth heavier than its model", vec![HEAVY]),
        ("the same, with integral action", vec![HEAVY, INTEGRAL]),
        ("the same, and 8 s more", vec![HEAVY, INTEGRAL, LONG]),
        ("split, 1 kHz", vec![SPLIT, STIFFER]),
        ("the same, with integral action", vec![SPLIT, STIFFER, INTEGRAL]),
        ("the same, each link a fifth heavier than its model", vec![SPLIT, STIFFER, INTEGRAL, HEAVY]),
        ("the same, and 8 s more", vec![SPLIT, STIFFER, INTEGRAL, HEAVY, LONG]),
    ];
    if let Some(stiffness) = makers {
        // A stiffness replaces the natural frequency.
        let sprung = |law| vec![("law", law), ("natural_frequency", ""), ("stiffness", stiffness)];
        let slow = || [sprung("\"pd-gravity\""), vec![("rate", "250.0")]].concat();
        let stiff = |law| {
            let stiffness = ("stiffness", "[240.0, 240.0, 240.0, 30.0, 30.0, 30.0]");
            vec![("law", law), ("natural_frequency", ""), stiffness, ("rate", "250.0")]
        };
        runs.extend([
            ("PD with gravity, the maker's stiffness and rate, 250 Hz", slow()),
            ("the same, each link a fifth heavier than its model", [slow(), vec![HEAVY]].concat()),
            ("impedance of that stiffness, 1 kHz", sprung("\"impedance\"")),
            ("the same, each link a fifth heavier than its model", [sprung("\"impedance\""), vec![HEAVY]].concat()),
            ("impedance, three times that stiffness, 250 Hz", stiff("\"impedance\"")),
            ("split, three times that stiffness, 250 Hz", stiff("\"split\"")),
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
            let cells = match fault(&summary) {
                // A run that ended with a fault has no tracking error.
                Some(fault) => [fault, "-".into(), "-".into()],
                None => [worst("tracking_rms")?, worst("tracking_max")?, worst("rest_error")?]
                    .map(|rad| format!("{:.2} mrad", 1e3 * rad)),
            };
            let [rms, most, rest] = cells;
            table.row(&[arm.into(), name.into(), rms, most, rest]);
        }
    }
    let mut outside = Table::new(&["arm", "run", "torque from outside that nobody exerts, rms, joint by joint, N m"]);
    for (arm, scene, _) in ARMS {
        for (number, (name, settings)) in estimates().into_iter().enumerate() {
            let path = variant::write(Path::new(scene), &format!("outside-{number}"), &settings)?;
            let summary = simulated(&path)?;
            let noise =
                summary.get("external_rms").and_then(Value::as_array).with_context(|| path.display().to_string())?;
            let noise: Vec<String> = noise.iter().filter_map(Value::as_f64).map(|x| format!("{x:.3}")).collect();
            outside.row(&[arm.into(), name.into(), noise.join(", ")]);
        }
    }
    write_into("docs/measured/arms.md", &[("arms", table.0), ("arms, torque from outside", outside.0)])
}

/// Runs for the estimate of external torques.
fn estimates() -> Vec<(&'static str, Vec<(&'static str, &'static str)>)> {
    const REPORT: (&str, &str) = ("collision.reaction", "\"report\"");
    vec![
        ("computed torque, 1 kHz", vec![REPORT]),
        ("the same, ideal drives", vec![REPORT, ("actuators.ideal", "true")]),
        ("each link a fifth heavier than its model", vec![REPORT, HEAVY]),
        ("split, 1 kHz", vec![REPORT, SPLIT, STIFFER]),
    ]
}

/// Message of a run's first fault.
fn fault(summary: &Value) -> Option<String> {
    let fault = summary.get("faults")?.as_array()?.first()?;
    Some(format!("swings: {}", fault.get("message")?.as_str()?))
}

fn simulated(scene: &Path) -> Result<Value> {
    let out = target_directory().join("arms");
    let mut command = cargo_run("host-sim");
    let done = command.arg("run").arg(scene).args(["--json", "--force", "--out"]).arg(&out).output()?;
    // A run that ends with a fault is a valid result.
    ensure!(
        matches!(done.status.code(), Some(0 | 3)),
        "{}: {}",
        scene.display(),
        String::from_utf8_lossy(&done.stderr)
    );
    Ok(serde_json::from_slice(&done.stdout)?)
}

/// Largest magnitude of a list; `None` if a value is missing.
fn worst(summary: &Value, key: &str) -> Option<f64> {
    let values = summary.get(key)?.as_array()?.iter().map(|value| value.as_f64().map(f64::abs));
    values.collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::max)
}
