//! `newtau model linkage` as used by a person or a script.
#![allow(clippy::float_cmp, reason = "a log is the summary's numbers, to the last digit")]

use crate::program::at_its_fixtures;
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const FOUR_BAR: &str = "../robots/chapter12/four_bar.toml";
const SLIDER_CRANK: &str = "../robots/chapter12/slider_crank.toml";
const ROCKER: &str = "tests/fixtures/rocker.toml";

fn host_sim(arguments: &[&str]) -> Output {
    at_its_fixtures().args(arguments).output().unwrap()
}

/// A new folder of this name.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("linkage_{name}"));
    std::fs::remove_dir_all(&path).ok();
    path
}

fn linkage(file: &str, out: &Path, more: &[&str]) -> Output {
    let mut all = vec!["model", "linkage", file, "--out", out.to_str().unwrap()];
    all.extend(more);
    host_sim(&all)
}

/// The summary from `--json`, and the exit code.
fn summary(file: &str, name: &str, more: &[&str]) -> (Value, i32) {
    let mut all = vec!["--json"];
    all.extend(more);
    let output = linkage(file, &folder(name), &all);
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    (serde_json::from_slice(&output.stdout).unwrap(), output.status.code().unwrap())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// A log as columns with names.
struct Log {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Log {
    fn read(path: &Path) -> Self {
        let mut reader = csv::Reader::from_path(path).unwrap();
        let names = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let row =
            |row: csv::Result<csv::StringRecord>| row.unwrap().iter().map(|field| field.parse().unwrap()).collect();
        Self { names, rows: reader.records().map(row).collect() }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let index = self.names.iter().position(|known| known == name).unwrap();
        self.rows.iter().map(|row| row[index]).collect()
    }
}

fn refusal(arguments: &[&str]) -> String {
    let output = host_sim(arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(2), vec![]), "{error}");
    error
}

#[test]
fn a_turn_writes_table_log_summary_and_plots() {
    let out = folder("turn");
    let output = linkage(FOUR_BAR, &out, &["--steps", "180"]);
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
    let table = String::from_utf8(output.stdout).unwrap();
    for words in [
        "example 324: four-bar, open branch, 10 rad/s, 180 steps a turn",
        "driving moment M_0",
        "joint force F_3",
        "shaking force F_3 - F_0",
        "crank-rocker: the crank turns fully, the follower rocks",
        "crank and coupler in line, stretched out; the follower stands still",
        "transmission angle",
        "driven.csv",
    ] {
        assert!(table.contains(words), "{words} in {table}");
    }
    let log = Log::read(&out.join("driven.csv"));
    assert_eq!(log.rows.len(), 180);
    let text = std::fs::read(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&text).unwrap();
    let moment = log.column("driving_moment");
    assert_eq!(number(&summary["driving_moment"]["max"]), moment.iter().copied().fold(f64::MIN, f64::max));
    assert_eq!(number(&summary["driving_moment"]["min"]), moment.iter().copied().fold(f64::MAX, f64::min));
    // Eq. 12.47.
    for axis in ["x", "y"] {
        let (f3, f0) = (log.column(&format!("f3{axis}")), log.column(&format!("f0{axis}")));
        let shaking = log.column(&format!("shaking_force_{axis}"));
        assert!(f3.iter().zip(f0).zip(shaking).all(|((f3, f0), f)| f3 - f0 == f));
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("example 324") && page.matches(">crank angle / rad<").count() == 3, "{page}");
    assert!(["Driving moment", "Shaking force", "Shaking moment"].iter().all(|figure| page.contains(figure)), "{page}");
}

/// Gravity and inertia do no net work on a crank that ends as it began.
#[test]
fn over_a_turn_at_constant_speed_the_moment_does_no_work() {
    for (file, branch) in [(FOUR_BAR, "open"), (FOUR_BAR, "crossed"), (SLIDER_CRANK, "open"), (SLIDER_CRANK, "crossed")]
    {
        let (summary, code) = summary(file, "no_work", &["--speed", "25", "--branch", branch]);
        assert_eq!((code, summary["branch"].as_str()), (0, Some(branch)));
        let moment = &summary["driving_moment"];
        assert!(number(&moment["rms"]) > 0.1, "{moment}");
        assert!(number(&moment["mean"]).abs() < 1e-13 * number(&moment["rms"]), "{moment}");
    }
}

/// Averaged over a turn, the ground carries the weight.
#[test]
fn the_mean_shaking_force_is_the_weight() {
    let out = folder("weight");
    linkage(FOUR_BAR, &out, &[]);
    let log = Log::read(&out.join("driven.csv"));
    let mean = |name| log.column(name).iter().sum::<f64>() / 360.0;
    assert!(mean("shaking_force_x").abs() < 1e-12);
    assert!((mean("shaking_force_y") + (0.24 + 0.72 + 0.60) * 9.81).abs() < 1e-12);
}

/// Textbook formula of a piston: `x = r cos + sqrt(l^2 - r^2 sin^2)`, `F = -m x''`, `M = m x'' x' / w`.
#[test]
fn a_piston_shakes_and_loads_the_motor_as_its_formula_says() {
    let out = folder("piston");
    linkage("tests/fixtures/piston.toml", &out, &["--speed", "40"]);
    let log = Log::read(&out.join("driven.csv"));
    let (r, l, m, w) = (0.05, 0.16, 2.0, 40.0);
    let columns = ["crank_angle", "slider_position", "shaking_force_x", "driving_moment"].map(|name| log.column(name));
    for i in 0..360 {
        let [angle, position, force, moment] = [0, 1, 2, 3].map(|column: usize| columns[column][i]);
        let (sin, cos) = angle.sin_cos();
        let root = (l * l - r * r * sin * sin).sqrt();
        let first = -r * sin - r * r * sin * cos / root;
        let second = -r * cos - r * r * (cos * cos - sin * sin) / root - (r * r * sin * cos).powi(2) / root.powi(3);
        assert!((position - r * cos - root).abs() < 1e-15);
        assert!((force + m * second * w * w).abs() < 1e-12);
        assert!((moment - m * second * w * w * first).abs() < 1e-13);
    }
}

#[test]
fn a_crank_that_rocks_is_driven_where_the_loop_closes() {
    let out = folder("rocks");
    let output = linkage(ROCKER, &out, &[]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(table.contains("rocker-crank: the follower turns fully, the crank rocks"), "{table}");
    assert!(table.contains("the crank does not turn fully: dead points at 0.1452 rad, 2.0170 rad,"), "{table}");
    let (angles, steps) = (Log::read(&out.join("driven.csv")).column("crank_angle"), TAU / 360.0);
    assert_eq!(angles.len(), 214);
    assert!(table.contains("driven at 214 steps"), "{table}");
    for arc in [0.1452..2.0170, 4.2661..6.1380] {
        let inside: Vec<f64> = angles.iter().copied().filter(|angle| arc.contains(angle)).collect();
        assert_eq!(inside.len(), 107);
        assert!(inside[0] - arc.start < steps && arc.end - inside[106] < steps);
    }
    // The line has two pieces with nothing drawn between them.
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let (_, figure) = page.split_once("Driving moment").unwrap();
    let (figure, _) = figure.split_once("</svg>").unwrap();
    let (_, line) = figure.split_once("<g class=\"c0\">").unwrap();
    assert_eq!(line.split("</g>").next().unwrap().matches('M').count(), 2, "{figure}");
}

#[test]
fn a_free_linkage_keeps_the_balance_of_energy_and_work() {
    let out = folder("free");
    let output = linkage(FOUR_BAR, &out, &["--simulate", "0.8", "--duration", "2"]);
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
    let table = String::from_utf8(output.stdout).unwrap();
    for words in
        ["example 324: four-bar, open branch, 0.8 N m on the crank", "gain of energy", "of the greatest energy"]
    {
        assert!(table.contains(words), "{words} in {table}");
    }
    let log = Log::read(&out.join("free.csv"));
    assert_eq!(log.rows.len(), 20_001);
    let [kinetic, potential, work, angle] =
        ["kinetic_energy", "potential_energy", "work", "crank_angle"].map(|name| log.column(name));
    let greatest = kinetic.iter().copied().fold(0.0, f64::max);
    for i in 0..log.rows.len() {
        assert!((work[i] - 0.8 * angle[i]).abs() < 1e-12);
        let gain = kinetic[i] + potential[i] - kinetic[0] - potential[0];
        // Measured: 5.1e-8, at 122 rad/s at the end.
        assert!((gain - work[i]).abs() < 1e-7 * greatest, "{i}: {gain} {}", work[i]);
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(page.matches(">time / s<").count(), 3, "{page}");
}

/// The energy balance shows that the method is of fourth order: with half the step, the error is a sixteenth or less.
#[test]
fn the_balance_error_falls_with_the_fourth_power_of_the_step() {
    let error = |step: &str| {
        let arguments = ["--simulate", "0", "--angle", "1", "--duration", "2", "--time-step", step];
        number(&summary(SLIDER_CRANK, "order", &arguments).0["balance_error_relative"])
    };
    let (long, short) = (error("0.004"), error("0.002"));
    println!("steps of 4 ms lose {long:.1e}, of 2 ms {short:.1e}");
    assert!(long < 1e-4 && long / short > 12.0 && long / short < 70.0, "{long:e} {short:e}");
}

#[test]
fn a_flywheel_gains_speed_evenly() {
    let arguments = ["--simulate", "0.5", "--duration", "3", "--speed", "2"];
    let (summary, code) = summary("tests/fixtures/flywheel.toml", "flywheel", &arguments);
    assert_eq!(code, 0);
    // M / I = 2 rad/s^2.
    assert!((number(&summary["speed_end"]) - (2.0 + 2.0 * 3.0)).abs() < 1e-11);
    assert!((number(&summary["angle_end"]) - (2.0 * 3.0 + 9.0)).abs() < 1e-11);
    assert!((number(&summary["work"]) - 0.5 * 15.0).abs() < 1e-11);
}

#[test]
fn a_free_linkage_stops_before_a_dead_point_and_exits_with_3() {
    for branch in ["open", "crossed"] {
        let (summary, code) = summary(ROCKER, "stops", &["--simulate", "1", "--branch", branch]);
        assert_eq!(code, 3);
        assert_eq!(summary["stopped"], "a dead point is 0.02 rad away, where coupler and follower lie in line");
        // The crank started in the middle of the arc and fell to the lower end.
        assert!((number(&summary["angle_start"]) - 0.5 * (0.1452 + 2.0170)).abs() < 1e-4);
        assert!((number(&summary["angle_end"]) - 0.1452).abs() < 2e-3, "{summary}");
        assert!(number(&summary["balance_error_relative"]) < 1e-6);
    }
}

#[test]
fn json_is_the_summary_file_and_nothing_else() {
    let out = folder("json");
    let output = linkage(SLIDER_CRANK, &out, &["--json"]);
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
    assert_eq!(output.stdout, std::fs::read(out.join("summary.json")).unwrap());
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&summary["kind"], &summary["linkage"]), (&"slider-crank".into(), &"exercise 7".into()));
    assert_eq!(summary["joint_forces"].as_array().unwrap().len(), 4);
    assert!(summary.get("class").is_none() && summary.get("follower_angle").is_none());
    // The stroke ends with crank and rod in line: at the square roots of (l + r)^2 - e^2 and (l - r)^2 - e^2.
    let position = &summary["slider_position"];
    assert!((number(&position["max"]) - (0.21_f64.powi(2) - 1e-4).sqrt()).abs() < 1e-4);
    assert!((number(&position["min"]) - (0.11_f64.powi(2) - 1e-4).sqrt()).abs() < 1e-4);
}

#[test]
fn a_linkage_that_cannot_close_is_refused_in_its_line() {
    let error = refusal(&["model", "linkage", "tests/fixtures/never_closes.toml"]);
    assert!(
        error.contains(
            "tests/fixtures/never_closes.toml:3:10: offset: the loop never closes: the offset is 0.09 m longer"
        ),
        "{error}"
    );
    let error = refusal(&["model", "linkage", ROCKER, "--simulate", "1", "--angle", "0"]);
    assert!(error.contains("the linkage cannot start at a crank angle of 0 rad on the open branch"), "{error}");
    assert!(error.contains("the loop does not close: one link reaches 0.04 m past the other"), "{error}");
    assert!(error.contains("help: the crank does not turn fully: dead points at 0.1452 rad,"), "{error}");
    let error = refusal(&["model", "linkage", "tests/fixtures/nowhere.toml"]);
    assert!(error.contains("tests/fixtures/nowhere.toml: cannot be read"), "{error}");
}

#[test]
fn commands_for_arms_point_to_this_one_and_back() {
    for arguments in [
        vec!["run", FOUR_BAR],
        vec!["model", "dynamics", FOUR_BAR, "--input", "-"],
        vec!["model", "info", SLIDER_CRANK],
    ] {
        let error = refusal(&arguments);
        assert!(error.contains("kind: this file describes a closed loop"), "{error}");
        assert!(error.contains("`newtau model linkage` takes this one"), "{error}");
    }
    let error = refusal(&["model", "linkage", "tests/fixtures/planar.toml"]);
    assert!(error.contains("kind: missing") && error.contains("in a linkage file"), "{error}");
}

#[test]
fn bad_options_are_named() {
    for (arguments, words) in [
        (vec!["--speed", "nan"], "--speed NaN: expected a number up to 1e9"),
        (vec!["--simulate", "inf"], "--simulate inf: expected a number up to 1e9"),
        (vec!["--steps", "7"], "7 is not in 8..=100000"),
        (vec!["--angle", "1"], "--simulate <MOMENT>"),
        (vec!["--simulate", "1", "--steps", "90"], "cannot be used with"),
        (vec!["--simulate", "1", "--duration", "0"], "expected times in s above zero"),
        (vec!["--simulate", "1", "--duration", "1e9"], "at most 1000000 steps"),
        (vec!["--branch", "half"], "possible values: open, crossed"),
    ] {
        let mut all = vec!["model", "linkage", FOUR_BAR];
        all.extend(arguments);
        let error = refusal(&all);
        assert!(error.contains(words), "{words} in {error}");
    }
}

#[test]
fn the_help_names_the_equations() {
    let output = host_sim(&["help", "model", "linkage"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for words in ["12.44-12.46", "12.41 with m3 a3", "12.47", "12.216", "docs/theory/linkages.md"] {
        assert!(text.contains(words), "{words} in {text}");
    }
}

/// The program prints the numbers in `docs/theory/linkages.md`, to the last digit.
#[test]
fn the_documents_examples_are_real() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let text = std::fs::read_to_string(top.join("docs/theory/linkages.md")).unwrap();
    let here = folder("document");
    std::fs::create_dir_all(&here).unwrap();
    let commands: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("$ newtau ")).collect();
    assert_eq!(commands.len(), 2);
    for command in commands {
        let words = command.split(' ').map(|word| match word.strip_prefix("robots/") {
            Some(file) => top.join("robots").join(file).display().to_string(),
            None => word.to_owned(),
        });
        let output = Command::new(env!("CARGO_BIN_EXE_newtau")).current_dir(&here).args(words).output().unwrap();
        let printed = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{command}");
        let shown = text.contains(&format!("{command}\n```\n```text\n"));
        assert!(!shown || text.contains(&format!("```text\n{printed}```\n")), "{command}\n{printed}");
    }
}
