//! Studies: single runs, and their results together.
#![allow(clippy::float_cmp, reason = "the same bits are demanded")]

use crate::program::{at_its_fixtures, at_the_top, printed};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A new folder for a test's files.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep").join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Cells of a table of runs, its head first.
pub(crate) fn cells(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(path).unwrap();
    reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

/// A message whose lines were broken between words, on one line.
pub(crate) fn unbroken(error: &str) -> String {
    error.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

pub(crate) fn sweep(study: &str, out: &Path, more: &[&str]) -> String {
    printed(at_its_fixtures().arg("sweep").arg(study).arg("--out").arg(out).args(more).output().unwrap())
}

#[test]
fn a_row_is_the_run_of_a_scene_in_which_a_person_typed_the_same_values() {
    let out = folder("typed");
    sweep("tests/fixtures/study.toml", &out, &["--quiet"]);
    let rows = cells(&out.join("runs.csv"));
    let head = ["index", "plant.masses.2", "robot.joint.1.mass", "control.law", "actuators.delay"];
    let figures = ["tracking_max", "torque_peak.1", "settling_time", "end", "pass"];
    assert_eq!(rows[0], [head.as_slice(), &figures].concat());
    assert_eq!(rows.len(), 41);
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let read = |path: &str| fs::read_to_string(top.join(path)).unwrap();
    for row in &rows[1..9] {
        let replaced = |text: String, from: &str, to: &str| {
            assert_eq!(text.matches(from).count(), 1, "{from}");
            text.replace(from, to)
        };
        let robot = read("robots/planar2r.toml");
        let mass = robot.lines().find(|line| line.starts_with("mass = ")).unwrap().to_owned();
        let own: f64 = mass.split_whitespace().nth(2).unwrap().parse().unwrap();
        let factor: f64 = row[2].parse().unwrap();
        let robot = robot.replacen(&mass, &format!("mass = {:?}", own * factor), 1);
        let scene = replaced(read("scenes/planar2r_sine.toml"), "../robots/planar2r.toml", "robot.toml");
        let scene = replaced(scene, "law = \"feedforward\"", &format!("law = {:?}", row[3]));
        let scene = replaced(scene, "[model]", "duration = 0.01\n[model]");
        let plant = format!("[plant]\nmasses = [1.0, {}]\n[actuators]\ndelay = {}\n", row[1], row[4]);
        let typed = folder(&format!("typed_{}", row[0]));
        fs::write(typed.join("robot.toml"), robot).unwrap();
        fs::write(typed.join("scene.toml"), scene + &plant).unwrap();
        let mut run = at_the_top();
        run.arg("run").arg(typed.join("scene.toml")).args(["--json", "--force", "--out"]).arg(&typed);
        let summary: Value = serde_json::from_str(&printed(run.output().unwrap())).unwrap();
        let number = |value: &Value| value.as_f64().unwrap();
        let errors: Vec<f64> = summary["tracking_max"].as_array().unwrap().iter().map(number).collect();
        let cell = |at: usize| row[at].parse::<f64>().unwrap();
        assert_eq!(cell(5), errors[0].max(errors[1]), "{row:?}");
        assert_eq!(cell(6), number(&summary["torque_peak"][0]), "{row:?}");
        assert_eq!(cell(7), f64::INFINITY, "a sine has no rest: {row:?}");
        assert_eq!((row[8].as_str(), row[9].as_str()), ("complete", if cell(5) <= 0.0003 { "1" } else { "0" }));
    }
}

#[test]
fn results_count_what_the_table_holds() {
    let out = folder("results");
    let found: Value = serde_json::from_str(&sweep("tests/fixtures/study.toml", &out, &["--json"])).unwrap();
    let rows = &cells(&out.join("runs.csv"))[1..];
    let column = |at: usize| rows.iter().map(|row| row[at].parse::<f64>().unwrap()).collect::<Vec<_>>();
    let errors = column(5);
    let failed = errors.iter().filter(|x| **x > 0.0003).count();
    assert!(failed > 3 && failed < 37, "a limit that tells runs apart: {failed}");
    assert_eq!(found["failures"]["count"], failed);
    assert_eq!(found["ends"]["complete"], 40);
    let metric = &found["metrics"][0];
    let mean = errors.iter().sum::<f64>() / 40.0;
    assert!((metric["mean"].as_f64().unwrap() / mean - 1.0).abs() < 1e-12);
    let worst = (0..40).max_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap();
    assert_eq!(metric["worst"][0]["index"], worst);
    assert_eq!(metric["max"].as_f64().unwrap(), errors[worst]);
    assert_eq!(found["metrics"][2]["infinite"], 40);
    // A mass error that the controller does not know causes tracking errors. A control law is not a number, so it has no correlation.
    let of = |metric: &str, key: &str| {
        let list = found["sensitivities"].as_array().unwrap();
        list.iter().find(|it| it["metric"] == metric && it["key"] == key).map(|it| it["correlation"]["value"].as_f64())
    };
    assert!(of("tracking_max", "plant.masses.2").unwrap().unwrap() > 0.3);
    assert_eq!(of("tracking_max", "control.law"), None);
    assert_eq!(of("settling_time", "actuators.delay"), Some(None));
    let by_law = found["groups"].as_array().unwrap().iter().find(|it| it["keys"] == serde_json::json!(["control.law"]));
    let cells = by_law.unwrap()["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 3);
    assert_eq!(cells.iter().map(|cell| cell["failures"]["of"].as_u64().unwrap()).sum::<u64>(), 40);
}

#[test]
fn a_run_whose_values_make_no_scene_is_refused_alone() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/study.toml")).unwrap();
    let out = folder("refused");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("scenes");
    let text = text.replace("../../../scenes", scenes.to_str().unwrap());
    // A factor above 100 on the masses is rejected.
    let text = text.replace("uniform = [0.5, 2.0]", "list = [1.0, 101.0]");
    fs::write(out.join("some.toml"), text).unwrap();
    let done = sweep(out.join("some.toml").to_str().unwrap(), &out, &["--json", "--force"]);
    let found: Value = serde_json::from_str(&done).unwrap();
    let refused = found["refused"].as_u64().unwrap();
    assert!(refused > 5 && refused < 35, "{refused}");
    assert_eq!(found["failures"]["of"], 40 - refused);
    let first = &found["refusal"];
    let reason = first["reason"].as_str().unwrap();
    assert!(reason.contains("masses") && reason.contains("found 101") && !reason.contains(".toml"), "{reason}");
    let rows = cells(&out.join("runs.csv"));
    let expected = rows.iter().find(|row| row[8] == "refused").unwrap();
    assert_eq!(first["index"].to_string(), expected[0]);
    let shown = fs::read_to_string(out.join("results.md")).unwrap();
    assert!(shown.contains(&format!("{refused} runs, first run {} ({reason}).", expected[0])), "{shown}");
    let row = rows.iter().find(|row| row[1] == "101.0").unwrap();
    assert_eq!(row[5..], ["", "", "", "refused", ""]);
}

#[test]
fn every_shipped_study_is_read_with_its_first_run() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut count = 0;
    for entry in fs::read_dir(top.join("scenes/studies")).unwrap() {
        let path = entry.unwrap().path();
        let prepared = studies::sweep::Prepared::load(&path, None).unwrap();
        assert_eq!(path.file_stem().unwrap().to_str().unwrap(), prepared.study.name);
        count += 1;
    }
    assert_eq!(count, 3);
}
