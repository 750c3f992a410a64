//! Friction beyond viscous and Coulomb friction: the simulated joint has it, identification finds it in a log, and the controller compensates it.

use crate::program::{at_the_top, new, told};
use robot_compiler::{Breakaway, JointFriction};
use serde_json::Value;
use std::path::{Path, PathBuf};

const SCENE: &str = "scenes/examples/yam_friction.toml";
const ROBOT: &str = "robots/yam.toml";
const SHOULDER: usize = 1;

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("friction");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn done(arguments: &[&str]) -> String {
    let mut command = at_the_top();
    command.args(arguments);
    let (code, out, error) = told(command.output().unwrap());
    assert_eq!(code, 0, "{arguments:?}: {error}");
    out
}

/// A log of slow sweeps of the simulated arm, and its file.
fn recorded(name: &str, speed: &str, swing: &str) -> String {
    let (motion, run) = (folder().join(format!("{name}.toml")), folder().join(name));
    let (motion, run) = (motion.to_str().unwrap(), run.to_str().unwrap());
    let sweeps =
        ["identify", "excite", SCENE, "--friction", "--centre", "0,0.65,0.8,0,0,0", "--speed", speed, "--swing", swing];
    let found: Value = serde_json::from_str(&done(&[&sweeps[..], &["--out", motion, "--json"]].concat())).unwrap();
    let seconds = found["duration"].as_f64().unwrap().to_string();
    done(&["run", SCENE, "--motion", motion, "--duration", &seconds, "--out", run, "--quiet"]);
    format!("{run}/log.csv")
}

/// The scene with this robot file.
fn scene_of(robot: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(SCENE);
    let text = std::fs::read_to_string(path).unwrap().replace("../../robots/yam.toml", robot);
    let scene = folder().join(format!("scene_{}", Path::new(robot).file_name().unwrap().to_str().unwrap()));
    std::fs::write(&scene, text).unwrap();
    scene
}

/// Root mean square of the shoulder's tracking error with the numbers of this robot file, rad.
fn tracking(robot: &str) -> f64 {
    let (scene, out) = (scene_of(robot), format!("{robot}.run"));
    done(&["run", scene.to_str().unwrap(), "--out", &out, "--quiet"]);
    let text = std::fs::read_to_string(format!("{out}/summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    assert!(summary["stopped"].is_null(), "{summary}");
    summary["tracking_rms"][SHOULDER].as_f64().unwrap()
}

#[test]
fn a_shoulder_with_stiction_follows_five_times_better_with_what_a_log_tells_of_it() {
    new(&folder());
    let (slow, fast) = (recorded("slow", "0.05", "0.1"), recorded("fast", "0.4", "0.5"));
    let robot = |name: &str| folder().join(name).to_str().unwrap().to_owned();
    let (plain, full) = (robot("plain.toml"), robot("full.toml"));
    // There is no delay, so it is given: searching for it would take longer than everything else.
    let identify = ["identify", ROBOT, "--log", &slow, &fast, "--delay", "0", "--json", "--out"];
    // Viscous and Coulomb friction do not explain this log well, so the model is doubtful.
    done(&[&identify[..], &[&plain, "--plain-friction", "--accept-doubtful"]].concat());
    let found: Value = serde_json::from_str(&done(&[&identify[..], &[&full]].concat())).unwrap();

    // The simulated shoulder has a breakaway torque of 2.8 N m plus a tenth of a load of 1 to 4 N m, 0.7 N m when sliding, and a Stribeck speed of
    // 0.1 rad/s.
    let of_joint = |joint: usize| found["links"][joint]["friction"].clone();
    let (shoulder, elbow) = (of_joint(SHOULDER), of_joint(2));
    let number = |key: &str| shoulder[key]["value"].as_f64().unwrap_or_else(|| panic!("{key} in {shoulder}"));
    assert!((2.7..3.5).contains(&number("breakaway")), "{shoulder}");
    assert!((0.5..1.0).contains(&number("coulomb")), "{shoulder}");
    assert!((0.07..0.13).contains(&number("stribeck_speed")), "{shoulder}");
    assert!((0.0..0.5).contains(&shoulder["breakaway"]["deviation"].as_f64().unwrap()), "{shoulder}");
    assert!(elbow["breakaway"].is_null(), "the elbow has no rise: {elbow}");

    let (before, after) = (tracking(&plain), tracking(&full));
    assert!(before > 5.0 * after, "{before} rad with viscous and Coulomb friction, {after} rad with all terms");

    // The effect of the breakaway term on this motion, and its cost.
    let scene = scene_of(&full);
    let explained: Value = serde_json::from_str(&done(&["explain", scene.to_str().unwrap(), "--json"])).unwrap();
    let terms = explained["friction"].as_array().unwrap();
    let rise = terms.iter().find(|term| term["term"] == "breakaway").unwrap();
    let worth = rise["torque"]["max"][SHOULDER].as_f64().unwrap();
    // The excess of breakaway over Coulomb friction, and a sign that changes over a fifth of the default speed.
    assert!((2.0..3.5).contains(&worth), "{rise}");
    assert!(rise["operations"]["mul"].as_i64().unwrap() >= 10, "{rise}");
    let without = rise["tracking"]["rms"][SHOULDER].as_f64().unwrap();
    assert!(without > 3.0 * after, "{rise}");
}

#[test]
fn an_arm_without_such_terms_has_none_explained() {
    let text = done(&["explain", "scenes/puma560_pick.toml", "--json"]);
    let explained: Value = serde_json::from_str(&text).unwrap();
    assert!(explained.get("friction").is_none());
}

#[test]
fn the_simulated_joint_has_every_term_of_its_friction() {
    let plain = JointFriction::new(0.3, 0.7);
    let fast = |friction: &JointFriction, drive: f64, qd: f64| friction.torque_under(drive, qd) - 0.3 * qd;
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    // Growth with the load: of Coulomb friction, and of the excess up to breakaway.
    let loaded = JointFriction { coulomb_load: 0.05, ..plain };
    close(fast(&loaded, -10.0, 1.0), 0.7 + 0.5);
    close(fast(&loaded, 10.0, -1.0), -0.7 - 0.5);
    let risen = JointFriction { breakaway: Some(Breakaway { torque: 2.8, speed: 0.1, load: 0.2 }), ..loaded };
    let e = (-1.0_f64).exp();
    close(fast(&risen, 10.0, 0.1), 1.2 + (2.8 + 2.0 - 1.2) * e);
    // Friction is greater in one direction than in the other, and the offset acts at rest too.
    let uneven = JointFriction { asymmetry: 0.2, offset: -0.1, ..plain };
    close(fast(&uneven, 0.0, 1.0), 0.9 - 0.1);
    close(fast(&uneven, 0.0, -1.0), -0.5 - 0.1);
    close(fast(&uneven, 0.0, 0.0), -0.1);
    close(fast(&plain, 10.0, 0.0), 0.0);
}
