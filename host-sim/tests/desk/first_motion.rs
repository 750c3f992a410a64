//! The first motion after homing, as a user of `connect` experiences it.

use crate::program::{at_the_top, told};
use std::path::{Path, PathBuf};

/// Runs a script of `connect` on the desk with this text as the scene. The arm is homed and armed before the script, and disarmed after it. `name` is
/// used for the files. Returns the exit code and the output.
/// files. Returns the exit code and the output.
pub(crate) fn with_an_armed_arm(name: &str, scene: &str, script: &str) -> (i32, String) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let (path, lines) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}_script.txt")));
    std::fs::write(&path, scene).unwrap();
    std::fs::write(&lines, format!("home\nconfirm\narm\n{script}quit!\n")).unwrap();
    let mut program = at_the_top();
    program.arg("connect").arg(&path).args(["--target", "desk", "--script"]).arg(&lines);
    let (code, out, error) = told(program.output().unwrap());
    assert_eq!(error, "", "{out}");
    (code, out)
}

/// Runs a script with an arm whose scene has these lines in `[safety]`. Returns the exit code and the output.
fn connect(name: &str, (robot, pose): (&str, &str), safety: &str, script: &str) -> (i32, String) {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots").join(robot);
    let scene = format!(
        "name = \"{name}\"\nrobot = \"{}\"\n[control]\nrate = 1000\nnatural_frequency = 20.0\ntunable = true\nteach = {{}}\n\
         [motion]\nkind = \"hold\"\nq = {pose}\nduration = 1.0\n[safety]\n{safety}\n",
        robot.display()
    );
    with_an_armed_arm(name, &scene, script)
}

const YAM: (&str, &str) = ("yam.toml", "[0.0, 0.6, 0.8, 0.0, 0.0, 0.0]");
const PLANAR: (&str, &str) = ("planar2r.toml", "[0.0, 0.5]");
const LIMITED: &str =
    "first motion: speed and torque beyond the weight are limited to 20 % until you enter `full-range`";

/// Largest share of a limit in the table of `full-range`, per cent, after these words, and the number of joints in it.
fn largest(out: &str, words: &str) -> (f64, usize) {
    let of = |line: &str| line.split(words).nth(1)?.split('(').nth(1)?.split(' ').next()?.parse::<f64>().ok();
    let all: Vec<f64> = out.lines().filter_map(of).collect();
    (all.iter().copied().fold(0.0, f64::max), all.len())
}

#[test]
fn who_homes_and_arms_is_told_of_the_limits_and_motions_are_slowed_until_they_are_lifted() {
    let script = "jog shoulder 0.4 0.5\nwait\nhold\nfull-range\njog shoulder -0.4 0.5\nwait\n";
    let (code, out) = connect("first", YAM, "safe_action = \"damped-stop\"", script);
    assert_eq!(code, 0, "{out}");
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[..2], ["home: homing", "confirm: idle, homed"]);
    assert!(lines[2].starts_with(&format!("{LIMITED}; motions are slowed to fit")), "{out}");
    assert_eq!(lines[3..5], ["arm: armed", LIMITED]);
    assert!(
        lines[5].starts_with("jog: running; ")
            && lines[5].contains(
                ", slowed from 0.50 s to fit the first motion (`first_motion` in [safety]; `full-range` lifts it)"
            ),
        "{out}"
    );
    assert!(lines[6].starts_with("wait: arrived"), "{out}");
    assert!(
        out.contains("since homing, so that nothing is known of them: base, elbow"),
        "joints that have not moved: {out}"
    );
    // The observations are above zero, and within the limits of the first motion.
    assert_eq!(lines[7], "hold: holding: as requested");
    assert!(lines[8].starts_with("full-range: holding"), "{out}");
    for words in ["speed at most", "torque beyond the weight at most"] {
        let (share, joints) = largest(&out, words);
        assert!(joints == 6 && share > 0.0 && share <= 20.5, "{words} {share}: {out}");
    }
    assert_eq!(out.matches("following error at most 0.0").count(), 6, "{out}");
    assert!(lines.contains(&"jog: running; 0.50 s"), "{out}");
}

#[test]
fn an_arm_without_the_limit_is_moved_as_asked_and_nobody_is_told_of_one() {
    for (name, arm, safety) in [
        ("lifted", YAM, "safe_action = \"damped-stop\"\nfirst_motion = 1"),
        // This arm has no drives, so it can only be simulated.
        ("simulated", PLANAR, ""),
    ] {
        let (code, out) = connect(name, arm, safety, "jog 2 0.4 0.5\nwait\n");
        assert_eq!(code, 0, "{out}");
        assert!(out.contains("\njog: running; 0.50 s\nwait: arrived"), "{out}");
        assert!(!out.contains("first motion") && !out.contains("slowed"), "{out}");
    }
}

#[test]
fn no_hand_leads_an_arm_in_its_first_motion() {
    let (code, out) =
        connect("guided", YAM, "safe_action = \"damped-stop\"", "teach\nfull-range\nteach\nwait 0.1\nhold\n");
    assert_eq!(code, 3, "{out}");
    let rejected = out.find("teach: rejected: in the first motion after homing (`first_motion` in [safety])").unwrap();
    assert!(out.find("teach: running; guide it by hand").is_some_and(|led| led > rejected), "{out}");
    assert_eq!(out.matches("law: teach").count(), 1, "{out}");
}

/// Changing the parameter changes the law: `set` does not bypass the checks of `teach`.
#[test]
fn set_law_is_checked_as_law_is() {
    let (code, out) =
        connect("set_law", YAM, "safe_action = \"damped-stop\"", "set law 6\nset law 0\njog 2 0.05\nwait\n");
    assert_eq!(code, 3, "{out}");
    assert!(out.contains("\nteach: rejected: in the first motion after homing"), "{out}");
    assert!(!out.contains("law teach") && !out.contains("law: teach"), "{out}");
    assert!(out.contains("\nlaw: ") && out.contains("\njog: running; "), "{out}");
}

/// Under the law `teach`, no command moves the arm before `full-range`; the message gives the alternatives.
#[test]
fn a_scene_whose_law_is_teach_says_how_its_first_motion_becomes_possible() {
    let lines = Path::new(env!("CARGO_TARGET_TMPDIR")).join("law_teach_first.txt");
    std::fs::write(
        &lines,
        "home\nconfirm\narm\njog shoulder 0.1\nrun\nteach\nfull-range\nteach\nwait 0.1\nhold\ndisarm!\n",
    )
    .unwrap();
    let mut program = at_the_top();
    program.args(["connect", "scenes/yam_teach.toml", "--target", "desk", "--script"]).arg(&lines);
    let (code, out, error) = told(program.output().unwrap());
    assert_eq!((code, error.as_str()), (3, ""), "{out}");
    for name in ["jog", "run", "teach"] {
        let line =
            out.lines().find(|line| line.starts_with(&format!("{name}: rejected: in the first motion"))).unwrap();
        assert!(line.contains("`tunable = true`") && line.contains("`full-range`"), "{line}");
        assert!(!line.contains("`jog`"), "`jog` was rejected too: {line}");
    }
    assert!(out.contains("\nfull-range: armed"), "{out}");
}
