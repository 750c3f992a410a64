//! Logs that `identify` reads from files of this program, and its messages about faulty logs.

use crate::program::{at_the_top, new, told};
use identification::log::Log;
use nalgebra::Vector3;
use robot_compiler::Ends;
use serde_json::Value;
use sim::run::mcap_file::messages::Text;
use sim::run::mcap_file::writer::Writer;
use std::fs;
use std::path::{Path, PathBuf};
use studies::identify::{LogOptions, Subject};

const ROBOT: &str = "robots/planar2r.toml";

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("identify_logs").join(test);
    fs::create_dir_all(new(&folder)).unwrap();
    folder
}

/// A run of two joints with both of its files.
fn recorded(folder: &Path) -> (PathBuf, PathBuf) {
    let (run, mcap) = (folder.join("run"), folder.join("run.mcap"));
    let mut command = at_the_top();
    command.args(["run", "scenes/planar2r_sine.toml", "--duration", "2", "--quiet", "--no-report", "--out"]).arg(&run);
    assert_eq!(told(command.arg("--mcap").arg(&mcap).output().unwrap()).0, 0);
    (run.join("log.csv"), mcap)
}

fn read(path: &Path) -> Log {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(ROBOT);
    let subject = Subject::load(&robot, Ends::default(), Vector3::new(0.0, -9.81, 0.0), 0.1).unwrap();
    let mut notes = Vec::new();
    let log = subject.log(path, &LogOptions { may_rest: true, ..LogOptions::default() }, &mut notes).unwrap();
    assert_eq!(notes, Vec::<String>::new());
    log
}

#[test]
fn the_mcap_file_of_a_run_is_the_same_log_as_its_table() {
    let (table, mcap) = recorded(&folder("mcap"));
    let (a, b) = (read(&table), read(&mcap));
    assert_eq!((&a.q, &a.qd, &a.tau), (&b.q, &b.qd, &b.tau));
    assert!(a.time.len() > 1000 && a.q[1].iter().any(|q| q.abs() > 0.1));
    assert!(a.time.iter().zip(&b.time).all(|(a, b)| (a - b).abs() < 1e-9));
}

#[test]
fn an_mcap_file_without_joint_states_and_one_of_another_arm_are_refused_with_what_is_in_them() {
    let folder = folder("others");
    let other = folder.join("text.mcap");
    let mut file = Writer::new(fs::File::create(&other).unwrap()).unwrap();
    let channel = file.channel::<Text>("/chatter").unwrap();
    file.write(&channel, 0, &Text { data: "hello".to_owned() }).unwrap();
    file.finish().unwrap();
    let (_, mcap) = recorded(&folder);
    for (robot, log, words) in [
        (ROBOT, &other, "no messages of the schema foxglove.JointStates; it holds /chatter (std_msgs/String)"),
        ("robots/yam.toml", &mcap, "joint_states/shoulder/position"),
    ] {
        let identify = at_the_top().args(["identify", robot, "--log"]).arg(log).output().unwrap();
        let (code, _, error) = told(identify);
        assert!(code == 2 && error.contains(words), "{error}");
    }
}

#[test]
fn validation_on_the_log_itself_is_not_called_held_out() {
    let folder = folder("same");
    let (log, _) = recorded(&folder);
    let (copy, other) = (folder.join("copy.csv"), folder.join("other.csv"));
    fs::copy(&log, &copy).unwrap();
    // Only the first second, which makes another log.
    let text = fs::read_to_string(&log).unwrap();
    fs::write(&other, text.lines().take(1501).collect::<Vec<_>>().join("\n") + "\n").unwrap();
    let identified = |validate: &Path| -> Value {
        let mut command = at_the_top();
        command.args(["identify", ROBOT, "--gravity", "0,-9.81,0", "--json", "--log"]).arg(&log);
        serde_json::from_str(&told(command.arg("--validate").arg(validate).output().unwrap()).1).unwrap()
    };
    for same in [&log, &copy] {
        let found = identified(same);
        assert_eq!(found["held_out"], false, "{found}");
        assert!(found["notes"][0].as_str().unwrap().contains("it is not held out"), "{}", found["notes"]);
    }
    let found = identified(&other);
    assert_eq!((&found["held_out"], &found["notes"]), (&Value::Bool(true), &serde_json::json!([])));
}
