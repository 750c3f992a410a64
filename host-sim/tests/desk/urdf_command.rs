//! Commands with an arm that is a chain of a URDF with branches.

use crate::program::{at_its_fixtures, printed, told};
use crate::reference::relative;
use robot_compiler::Ends;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use studies::trade::baseline::Baseline;

/// Six joints and a gripper with two fingers.
const GRIPPER: &str = "../robot-compiler/tests/data/gripper.urdf";
const Q: &str = "0.4,-0.5,1.2,0.7,-0.9,1.5";

fn simulator(arguments: &[&str]) -> Command {
    let mut command = at_its_fixtures();
    command.args(arguments);
    command
}

/// A path in this test program's folder at which there is no file yet.
fn new_file(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::remove_file(&path).ok();
    path
}

/// A file with this text.
fn file(name: &str, text: &str) -> String {
    let path = new_file(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Every command for a robot, with its other arguments.
fn commands(robot: &str) -> Vec<Vec<String>> {
    let states = file("urdf_states.jsonl", &format!("{{\"q\":[{Q}],\"qd\":[1,-1,2,0.5,-2,3]}}\n"));
    [
        vec!["model", "info", robot],
        vec!["model", "dynamics", robot, "--input", &states],
        vec!["model", "terms", robot, "--q", Q, "--json"],
        vec!["model", "statics", robot, "--q", Q, "--json"],
        vec!["model", "kernel", robot, "--json"],
        vec!["choose", "bound", robot, "--samples", "100", "--boxes", "20", "--json"],
        vec!["import", robot],
    ]
    .map(|list| list.into_iter().map(str::to_owned).collect())
    .into()
}

#[test]
fn every_command_on_a_robot_cuts_a_urdf() {
    for command in commands(GRIPPER) {
        let whole: Vec<&str> = command.iter().map(String::as_str).collect();
        let (code, out, error) = told(simulator(&whole).output().unwrap());
        assert_eq!((code, out.as_str()), (2, ""), "{whole:?}");
        assert!(error.contains("`--tip LINK`") && error.contains("palm (6 joints)"), "{error}");
        // The search for a bound is slow, and faster with one joint.
        let ends: &[&str] =
            if command[1] == "bound" { &["--base", "link5", "--tip", "palm"] } else { &["--tip", "palm"] };
        let (code, cut, note) = told(simulator(&whole).args(ends).output().unwrap());
        assert!(code == 0 && !cut.is_empty(), "{whole:?}: {note}");
        // Link 5 is rotated relative to the root's frame, so gravity is rotated too.
        let turned = ends.contains(&"link5");
        assert_eq!(note.starts_with("note: the base is turned"), turned, "{note}");
        assert!(turned || note.is_empty(), "{note}");
        let (code, _, error) = told(simulator(&whole).args(["--tip", "pam"]).output().unwrap());
        assert_eq!(code, 2);
        assert!(error.contains("did you mean `palm`?"), "{error}");
        let based = simulator(&whole).args(["--base", "finger_left", "--tip", "palm"]).output().unwrap();
        assert!(told(based).2.contains("is not on the way from the root to the tip"), "{whole:?}");
    }
    for command in commands("../robots/ur5.toml").iter().filter(|command| command[0] != "import") {
        let (code, out, error) = told(simulator(&[]).args(command).args(["--tip", "palm"]).output().unwrap());
        assert_eq!((code, out.as_str()), (2, ""), "{command:?}");
        assert!(error.contains("ur5.toml: tip: given for a TOML robot, which has one chain only"), "{error}");
    }
}

#[test]
fn an_imported_robot_answers_as_its_urdf() {
    let imported = new_file("imported.toml");
    let path = imported.to_str().unwrap();
    let text = printed(simulator(&["import", GRIPPER, "--tip", "palm"]).output().unwrap());
    assert_eq!(printed(simulator(&["import", GRIPPER, "--tip", "palm", "--out", path]).output().unwrap()), "");
    assert_eq!(std::fs::read_to_string(&imported).unwrap(), text);
    let of = |arguments: &[&str]| serde_json::from_str(&printed(simulator(arguments).output().unwrap())).unwrap();
    let flat = |json: &Value| -> Vec<f64> {
        let rows = json["mass_matrix"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap());
        rows.chain(json["gravity"].as_array().unwrap()).map(|number| number.as_f64().unwrap()).collect()
    };
    let urdf: Value = of(&["model", "terms", GRIPPER, "--tip", "palm", "--q", Q, "--json"]);
    let toml: Value = of(&["model", "terms", path, "--q", Q, "--json"]);
    let off = relative(&flat(&toml), &flat(&urdf));
    assert!(off < 1e-14, "{off:e}");
    // Values that the user has filled in are not lost.
    let again = told(simulator(&["import", GRIPPER, "--tip", "palm", "--out", path]).output().unwrap());
    assert_eq!(again.0, 2);
    assert!(again.2.contains("imported.toml: the file exists"), "{}", again.2);
    let toml = told(simulator(&["import", path]).output().unwrap());
    assert_eq!(toml.0, 2);
    assert!(toml.2.contains("a robot file in TOML") && toml.2.contains("expected a URDF file"), "{}", toml.2);
}

#[test]
fn import_writes_a_first_scene_that_runs_and_loses_no_file_for_it() {
    for (name, urdf, tip) in [("gripper", GRIPPER, "palm"), ("crane", "../robot-compiler/tests/data/crane.urdf", "")] {
        let [arm, scene] = ["toml", "scene.toml"].map(|end| new_file(&format!("first_{name}.{end}")));
        let [arm_path, scene_path] = [&arm, &scene].map(|path| path.to_str().unwrap());
        let mut import = vec!["import", urdf, "--out", arm_path, "--scene", scene_path];
        if !tip.is_empty() {
            import.extend(["--tip", tip]);
        }
        assert_eq!(told(simulator(&import).output().unwrap()), (0, String::new(), String::new()));
        let report = new_file(&format!("first_{name}_run"));
        let (code, out, error) =
            told(simulator(&["run", scene_path, "--out", report.to_str().unwrap()]).output().unwrap());
        assert_eq!(code, 0, "{out}{error}");
        std::fs::remove_file(&arm).unwrap();
        let again = told(simulator(&import).output().unwrap());
        assert!(again.0 == 2 && again.2.contains("the file exists"), "{}", again.2);
        assert!(!arm.exists(), "nothing is written if one of the two cannot be");
    }
    let (code, _, error) = told(simulator(&["run", GRIPPER]).output().unwrap());
    assert_eq!(code, 2);
    assert!(error.contains("found XML") && error.contains("newtau import ARM.urdf --out arm.toml"), "{error}");
}

/// A scene refers to the URDF by another path than the command line does.
#[test]
fn a_scene_is_about_the_same_cut_of_the_urdf() {
    let absolute = Path::new(env!("CARGO_MANIFEST_DIR")).join(GRIPPER);
    let scene = |ends: &str| {
        format!(
            "name = \"cut\"\nrobot = {absolute:?}\n{ends}\n[model]\npayload = {{ mass = 1.0, com = [0, 0, 0] }}\n\
             [motion]\nkind = \"hold\"\nq = [0, 0, 0, 0, 0, 0]\nduration = 1\n"
        )
    };
    let same = file("same_cut.toml", &scene("tip = \"palm\""));
    let other = file("other_cut.toml", &scene("tip = \"flange\"\nbase = \"stand\""));
    let terms = |scene: &str| {
        simulator(&["model", "terms", GRIPPER, "--tip", "palm", "--q", Q, "--scene", scene]).output().unwrap()
    };
    assert!(!printed(terms(&same)).is_empty());
    assert!(told(terms(&other)).2.contains("is a scene of another robot"));
    // A scene specifies its own ends of the chain.
    let bound = told(simulator(&["choose", "bound", &same, "--tip", "palm"]).output().unwrap());
    assert_eq!(bound.0, 2);
    assert!(bound.2.contains("`--tip` is given for a scene"), "{}", bound.2);
}

#[test]
fn the_scenes_of_a_trade_off_name_the_ends() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(GRIPPER);
    let base = Baseline::load(&path, Ends { base: Some("stand"), tip: Some("palm") }).unwrap();
    assert_eq!(base.file.robot.dof(), 6);
    let text = base.with(&base.own());
    assert!(text.contains("tip = \"palm\"") && text.contains("base = \"stand\""), "{text}");
    assert_eq!(base.read(&text, Path::new("made_up.toml")).unwrap().robot.joints, base.file.robot.joints);
}
