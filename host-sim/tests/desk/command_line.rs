//! The program as used by a person or a script.

use crate::compare_output;
use crate::program::at_its_fixtures;
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Exit code and standard error; asserts that standard output is empty.
fn refusal(arguments: &[&str], input: &str) -> String {
    let output = with_input(arguments, input);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.stdout, b"", "{error}");
    format!("exit code {}\n{error}", output.status.code().unwrap())
}

fn with_input(arguments: &[&str], input: &str) -> Output {
    let mut child = at_its_fixtures()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that rejects its options does not read its input.
    child.stdin.take().unwrap().write_all(input.as_bytes()).ok();
    child.wait_with_output().unwrap()
}

/// A new folder of this name.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::remove_dir_all(&path).ok();
    path
}

fn run(scene: &str, out: &Path, more: &[&str]) -> Output {
    at_its_fixtures().args(["run", scene, "--out"]).arg(out).args(more).output().unwrap()
}

const ROBOT: &str = "tests/fixtures/planar.toml";
const SCENE: &str = "tests/fixtures/swing.toml";

#[test]
fn run_writes_table_log_summary_and_plots() {
    let out = folder("everything");
    let output = run(SCENE, &out, &[]);
    assert!(output.status.success());
    let table = String::from_utf8(output.stdout).unwrap();
    for word in
        ["swing: planar, computed-torque, desk, f64", "shoulder", "elbow", "faults              none", "log.csv"]
    {
        assert!(table.contains(word), "{word} in {table}");
    }
    // Standard error is not a terminal, so there is no progress bar.
    assert_eq!(output.stderr, b"");

    let mut log = csv::Reader::from_path(out.join("log.csv")).unwrap();
    let header: Vec<String> = log.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(header[..7], ["t", "q1_reference", "q1", "qd1_reference", "qd1", "tau1", "limits1"]);
    assert_eq!(header.len(), 1 + 2 * 6 + 1);
    let rows: Vec<Vec<f64>> =
        log.records().map(|row| row.unwrap().iter().map(|field| field.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 1000);
    assert!(rows.iter().all(|row| row.len() == header.len()));

    // The summary agrees with the log.
    let summary: Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    let max = rows.iter().map(|row| (row[1] - row[2]).abs()).fold(0.0, f64::max);
    assert_eq!(summary["tracking_max"][0], max);
    let peak = rows.iter().map(|row| row[11].abs()).fold(0.0, f64::max);
    assert_eq!(summary["torque_peak"][1], peak);
}

/// A planar arm with drives that are too weak for its motion.
#[test]
fn the_summary_tells_where_the_reference_was_lost() {
    let out = folder("weak");
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(SCENE)).unwrap();
    let robot = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(ROBOT)).unwrap();
    std::fs::create_dir_all(&out).unwrap();
    let strong = ["torque = 120.0", "torque = 60.0"];
    assert!(strong.iter().all(|limit| robot.contains(limit)), "{robot}");
    std::fs::write(
        out.join("planar.toml"),
        robot.replace(strong[0], "torque = 35.0").replace(strong[1], "torque = 8.0"),
    )
    .unwrap();
    std::fs::write(out.join("weak.toml"), format!("{text}\n[actuators]\nsaturation = true\n")).unwrap();
    let scene = out.join("weak.toml");
    let output = run(scene.to_str().unwrap(), &out, &["--json", "--force"]);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let far = &summary["supervision"]["out_of_reach"];
    assert_eq!(summary["supervision"]["state_machine"], false);
    let (tick, joint) = (far["tick"].as_u64().unwrap() as usize, far["joint"].as_u64().unwrap() as usize);

    // It is the first tick of the log in which a joint is more than 0.2 rad from its reference.
    let mut log = csv::Reader::from_path(out.join("log.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        log.records().map(|row| row.unwrap().iter().map(|field| field.parse().unwrap()).collect()).collect();
    let off = |row: &Vec<f64>, joint: usize| (row[1 + 6 * (joint - 1)] - row[2 + 6 * (joint - 1)]).abs() > 0.2;
    assert_eq!(rows.iter().position(|row| off(row, 1) || off(row, 2)), Some(tick));
    assert!(off(&rows[tick], joint));
    let table = String::from_utf8(run(scene.to_str().unwrap(), &out, &[]).stdout).unwrap();
    let line = format!("no state machine; the firmware would have held at tick {tick} (");
    assert!(table.contains(&line) && table.contains("): reach, "), "{table}");

    let chatter = summary["torque_chatter"][0].as_f64().unwrap();
    let changes: Vec<f64> = rows.windows(2).map(|pair| pair[1][5] - pair[0][5]).collect();
    let rms = (changes.iter().map(|x| x * x).sum::<f64>() / changes.len() as f64).sqrt();
    assert!((chatter / rms - 1.0).abs() < 1e-12, "{chatter} {rms}");

    let ideal = folder("strong");
    let table = String::from_utf8(run(SCENE, &ideal, &[]).stdout).unwrap();
    assert!(table.contains("safety              no state machine; no joint left its reach"), "{table}");
}

#[test]
fn json_prints_the_summary_alone() {
    let output = run(SCENE, &folder("json"), &["--json", "--duration", "0.1", "--law", "pd", "--scalar", "f32"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(output.stderr, b"");
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["scene"], "swing");
    assert_eq!(
        (&summary["law"], &summary["scalar"], &summary["target"]),
        (&"pd".into(), &"f32".into(), &"desk".into())
    );
    assert_eq!(summary["ticks"], 100);
    for list in [
        "tracking_rms",
        "tracking_max",
        "torque_rms",
        "torque_peak",
        "torque_chatter",
        "rest_error",
        "settling_time",
        "limits",
    ] {
        assert_eq!(summary[list].as_array().unwrap().len(), 2, "{list}");
    }
    assert_eq!(summary["faults"], Value::Array(vec![]));
    assert!(summary["realtime_factor"].as_f64().unwrap() > 0.0);
    assert!(summary["seconds_per_tick"].as_f64().unwrap() > 0.0);
    assert!(summary.get("parity").is_none(), "only the chip has a parity");
}

#[test]
fn the_same_seed_writes_the_same_log() {
    let (first, second) = (folder("first"), folder("second"));
    for out in [&first, &second] {
        assert!(run("tests/fixtures/noisy.toml", out, &["--quiet"]).status.success());
    }
    let read = |out: &Path| std::fs::read(out.join("log.csv")).unwrap();
    assert!(!read(&first).is_empty());
    assert!(read(&first) == read(&second));
}

#[test]
fn a_run_that_ends_in_a_fault_says_so_and_exits_with_3() {
    let output = run("tests/fixtures/stale.toml", &folder("stale"), &["--json"]);
    assert_eq!(output.status.code(), Some(3));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = serde_json::json!([
        { "tick": 3, "code": 3, "joint": null, "message": "fault 3: measurement is stale" }
    ]);
    assert_eq!(summary["faults"], expected);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_run_cleanly_with_130() {
    use std::time::{Duration, Instant};
    let out = folder("interrupted");
    // Long enough to be interrupted in the middle on any machine.
    let child = at_its_fixtures()
        .args(["run", SCENE, "--json", "--duration", "5000", "--out"])
        .arg(&out)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // The program creates the folder after it sets the handler and before it starts the loop.
    let start = Instant::now();
    while !out.exists() && start.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(100));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["stopped"], "interrupted");
    let rows = csv::Reader::from_path(out.join("log.csv")).unwrap().records().count();
    assert!(rows > 0 && summary["ticks"] == rows, "{rows} rows");
}

#[test]
fn dynamics_answers_in_order_and_reads_back_exactly() {
    let input =
        "{\"q\":[0.1,0.2]}\n\n{\"q\":[0.1,0.2],\"qd\":[1,2],\"qdd\":[3,4],\"tau\":[5,6],\"gravity\":[0,-9.81,0]}\r\n";
    let output = with_input(&["model", "dynamics", ROBOT, "--input", "-"], input);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    assert_eq!(lines[0]["tau"], lines[0]["gravity"]);
    assert!(lines[0].get("qdd").is_none() && lines[1].get("qdd").is_some());
    // tau = D qdd + C qd + G, all with 17 digits.
    let number = |value: &Value| value.as_f64().unwrap();
    let row = &lines[1];
    let sum = number(&row["mass_matrix"][0][0]) * 3.0
        + number(&row["mass_matrix"][0][1]) * 4.0
        + number(&row["coriolis_qd"][0])
        + number(&row["gravity"][0]);
    assert!((sum - number(&row["tau"][0])).abs() < 1e-13);
    let across = 0.1_f64.cos() + 0.8 * 0.3_f64.cos();
    assert!((number(&row["tip"]["position"][0]) - across).abs() < 1e-15);
}

#[test]
fn lines_before_a_bad_one_are_answered() {
    let output =
        with_input(&["model", "dynamics", ROBOT, "--input", "-"], "{\"q\":[0,0]}\n{\"q\":[0]}\n{\"q\":[0,0]}\n");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 1);
    assert!(String::from_utf8(output.stderr).unwrap().contains("standard input, line 2: `q` has 1 number;"));
}

#[test]
fn bad_lines_are_named_with_what_was_found_and_expected() {
    let cases = [
        ("not_json", "q = [0, 0]"),
        ("no_q", r#"{"qd":[0,0]}"#),
        ("q_too_short", r#"{"q":[0]}"#),
        ("q_too_long", r#"{"q":[0,0,0]}"#),
        ("unknown_key", r#"{"q":[0,0],"qddd":[0,0]}"#),
        ("duplicate_key", r#"{"q":[0,0],"q":[0,0]}"#),
        ("nan", r#"{"q":[0,NaN]}"#),
        ("overflow", r#"{"q":[0,1e999]}"#),
        ("text_for_number", r#"{"q":[0,"1"]}"#),
        ("number_for_list", r#"{"q":0}"#),
        ("cut_off", r#"{"q":[0,0]"#),
        ("two_documents", r#"{"q":[0,0]} {"q":[0,0]}"#),
        ("list_instead_of_object", "[0,0]"),
        ("wrench_of_five", r#"{"q":[0,0],"wrench_tip":[1,2,3,4,5]}"#),
        ("gravity_of_two", r#"{"q":[0,0],"gravity":[0,-9.81]}"#),
        ("tau_of_three", r#"{"q":[0,0],"tau":[1,2,3]}"#),
        ("result_overflows", r#"{"q":[0,0],"qdd":[1e308,1e308]}"#),
    ];
    let refused = cases.map(|(name, line)| {
        format!("{name}: {line}\n{}", refusal(&["model", "dynamics", ROBOT, "--input", "-"], line))
    });
    compare_output("bad_lines_are_named_with_what_was_found_and_expected", refused.join("\n"));
}

#[test]
fn bad_single_precision_lines_are_named() {
    let refused =
        refusal(&["model", "dynamics", ROBOT, "--input", "-", "--scalar", "f32"], r#"{"q":[0,0],"qd":[1e39,0]}"#);
    assert!(refused.starts_with("exit code 2"), "{refused}");
    assert!(refused.contains("line 1: entry 1 of `qd`, 1e39, is too large for the scalar"), "{refused}");
}

#[test]
fn a_byte_order_mark_begins_a_file_and_no_later_line() {
    let mark = "\u{feff}";
    let output =
        with_input(&["model", "dynamics", ROBOT, "--input", "-"], &format!("{mark}{{\"q\":[0,0]}}\n{{\"q\":[0,0]}}\n"));
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
    let output =
        with_input(&["model", "dynamics", ROBOT, "--input", "-"], &format!("{{\"q\":[0,0]}}\n{mark}{{\"q\":[0,0]}}\n"));
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn what_a_line_says_is_not_printed_whole_and_commands_no_terminal() {
    let dynamics = |line: &str| refusal(&["model", "dynamics", ROBOT, "--input", "-"], line);
    let said = dynamics(&format!("{{\"q\":[0,0],\"{}\":1}}", "x".repeat(50_000)));
    assert!(said.contains("line 1: unknown field `xxx") && said.len() < 1000, "{said}");
    assert!(dynamics(&format!("{{\"q\":[{}]}}", "0,".repeat(50_000))).contains("line 1: longer than 65536 bytes"));
    let said = dynamics("{\"q\":[0,0],\"\\u001b[31m\":1}");
    assert!(!said.contains('\u{1b}') && said.contains("\\u{1b}[31m"), "{said}");
    let said = refusal(&["run", SCENE, "--duration", "1e300"], "");
    assert!(said.contains("a duration of 1e300 s makes 1e303 ticks") && said.len() < 300, "{said}");
    // Above 8192 rad there is no sine in single precision; in double precision there is.
    let line = r#"{"q":[0,1e7]}"#;
    let said = refusal(&["model", "dynamics", ROBOT, "--input", "-", "--scalar", "f32"], line);
    assert!(said.contains("line 1: entry 2 of `q`, 1e7 rad, is too large for the scalar's sine and cosine"), "{said}");
    assert!(with_input(&["model", "dynamics", ROBOT, "--input", "-"], line).status.success());
}

#[test]
fn bad_options_and_files_are_named() {
    let cases: [&[&str]; 13] = [
        &[],
        &["walk"],
        &["run"],
        &["run", "tests/fixtures/nowhere.toml"],
        &["run", ROBOT],
        &["run", SCENE, "--law", "magic"],
        &["run", SCENE, "--scalar", "f16"],
        &["run", SCENE, "--duration", "0"],
        &["run", SCENE, "--duration", "1e9"],
        &["run", SCENE, "--target", "qemu", "--scalar", "f64"],
        &["model", "dynamics", "tests/fixtures/nowhere.toml", "--input", "-"],
        &["model", "dynamics", ROBOT, "--input", "tests/fixtures/nowhere.jsonl"],
        &["model", "info", SCENE],
    ];
    let out = folder("refused");
    let refused = cases.map(|arguments| {
        let mut all = arguments.to_vec();
        if arguments.len() > 1 && arguments[0] == "run" {
            all.extend(["--out", out.to_str().unwrap()]);
        }
        format!("{}\n{}", arguments.join(" "), refusal(&all, ""))
    });
    compare_output("bad_options_and_files_are_named", refused.join("\n"));
}

#[test]
fn a_log_that_cannot_be_written_is_an_outside_failure() {
    // A file exists at the path of the folder.
    let output = run(SCENE, &Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("Cargo.toml: is a file"));
    let output = run(SCENE, &Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml/out"), &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stderr).unwrap().contains("cannot be written"));
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let line = "{\"q\":[0,0]}\n";
    let mut child = at_its_fixtures()
        .args(["model", "dynamics", ROBOT, "--input", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    child.stdin.take().unwrap().write_all(line.repeat(2000).as_bytes()).ok();
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
}

#[test]
fn info_shows_every_joint() {
    let output = at_its_fixtures().args(["model", "info", ROBOT]).output().unwrap();
    assert!(output.status.success());
    compare_output("info_shows_every_joint", String::from_utf8(output.stdout).unwrap());
}
