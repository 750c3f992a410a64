//! `motors check` and `drive` with motors whose stored ranges are not those of the robot file.

use crate::can_adapter::{Adapter, Kind};
use crate::drive::{drive, file, scene};
use crate::program::{at_the_top, told};
use std::path::{Path, PathBuf};

/// The scene with a robot file in which the base's motor has another torque range.
fn other(name: &str) -> PathBuf {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let robot = std::fs::read_to_string(top.join("robots/yam.toml")).unwrap();
    let robot = robot.replacen("actuator = \"DM4340\"\n", "actuator = \"DM4340\"\ntorque = [-56.0, 56.0]\n", 1);
    let path = file(&format!("motors_check_{name}_robot.toml"));
    std::fs::write(&path, robot).unwrap();
    let scene = scene(&format!("motors_check_{name}"));
    let text = std::fs::read_to_string(&scene).unwrap();
    let own = top.join("robots/yam.toml").display().to_string();
    assert!(text.contains(&own), "{text}");
    std::fs::write(&scene, text.replace(&own, &path.display().to_string())).unwrap();
    scene
}

fn check(scene: &Path, adapter: &str, more: &[&str]) -> (i32, String, String) {
    told(at_the_top().args(["motors", "check"]).arg(scene).args(["--can", adapter]).args(more).output().unwrap())
}

const WRONG: &str = "torque: found a range of ±28 in the motor and [-56, 56] in the robot file: it would give 0.500 times the commanded torque";

#[test]
fn motors_are_compared_with_the_robot_file_and_a_session_with_others_does_not_begin() {
    let fits = scene("motors_check");
    let adapter = Adapter::new(Kind::Slcan, &fits);
    let (code, out, error) = check(&fits, &adapter.name, &[]);
    assert_eq!((code, error.as_str()), (0, ""), "{out}");
    assert!(out.contains(": all 6 motors fit "), "{out}");
    let wrong = other("wrong");
    let (code, out, error) = check(&wrong, &adapter.name, &[]);
    assert_eq!((code, error.as_str()), (3, ""), "{out}");
    assert!(out.contains(&format!("joint 1: motor 1: {WRONG}")) && out.contains("motors set-limits"), "{out}");
    let (code, out, _) = check(&wrong, &adapter.name, &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &json["motors"][0]["mismatches"][0]), (3, &WRONG.into()), "{out}");
    assert_eq!(
        (json["motors"].as_array().unwrap().len(), &json["motors"][1]["mismatches"]),
        (6, &serde_json::json!([]))
    );

    let (code, out, error) = told(drive(&wrong, &adapter.name, "home\nconfirm\narm\n").output().unwrap());
    assert_eq!(code, 2, "{out}{error}");
    assert!(error.contains("nothing was enabled") && error.contains("0.500 times"), "{error}");
    // The enable frame of a Damiao.
    assert!(adapter.first(0xFC).is_none(), "no drive was enabled");
}

#[test]
fn a_bus_without_drives_and_drives_without_such_settings_are_said() {
    let fits = scene("motors_check_bus");
    let adapter = Adapter::new(Kind::Slcan, &fits);
    let (code, _, error) = check(&fits, &adapter.name, &["--bus", "3"]);
    assert!(code == 2 && error.contains("no drive on bus 3"), "{code}: {error}");
    let no_range = at_the_top().args(["motors", "set-limits", "3", "--can", &adapter.name]).output().unwrap();
    assert_eq!(told(no_range).0, 2, "a range is required");
    let (code, _, error) = check(Path::new("scenes/rebot_move.toml"), &adapter.name, &[]);
    assert!(code == 2 && error.contains("robstride"), "{code}: {error}");
    let (code, _, error) = check(Path::new("scenes/puma560_pick.toml"), &adapter.name, &[]);
    assert!(code == 2 && error.contains("expected a drive on CAN at every joint"), "{code}: {error}");
}
