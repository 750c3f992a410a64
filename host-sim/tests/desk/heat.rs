//! The heat of motors on the operator's screen.

use crate::first_motion::with_an_armed_arm;
use crate::program::{at_the_top, told};
use console::strip_ansi_codes;
use std::path::{Path, PathBuf};

/// A session with a YAM whose elbow motor has these thermal data, near its rest pose.
fn connect(name: &str, heat: &str, script: &str) -> (i32, String) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let yam = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/yam.toml")).unwrap();
    assert!(yam.contains("name = \"elbow\"\n"));
    let robot = folder.join(format!("{name}_robot.toml"));
    std::fs::write(&robot, yam.replace("name = \"elbow\"\n", &format!("name = \"elbow\"\n{heat}\n"))).unwrap();
    let scene = format!(
        "name = \"{name}\"\nrobot = \"{}\"\n[control]\nrate = 1000\nnatural_frequency = 20.0\n[motion]\nkind = \"hold\"\n\
         q = [0.0, 0.6, 0.8, 0.0, 0.0, 0.0]\nduration = 1.0\n[safety]\nsafe_action = \"damped-stop\"\n",
        robot.display()
    );
    let (code, out) = with_an_armed_arm(name, &scene, script);
    (code, strip_ansi_codes(&out).into_owned())
}

/// The ends of a joint's lines in the printed statuses, from the word `heat` on.
fn heats(out: &str, joint: &str) -> Vec<String> {
    let of = |line: &str| line.trim_start().starts_with(joint).then(|| line.split("  heat ").nth(1).map(str::to_owned));
    out.lines().filter(|line| line.contains(" rad ")).filter_map(of).flatten().collect()
}

/// The elbow holds 6.17 N m. With a rated torque of 6.5 N m that is a final heat of 0.90, and 0.57 after one time constant of 1 s.
#[test]
fn a_motor_that_holds_its_joint_gets_warm_on_the_screen_and_one_of_unknown_numbers_stays_unknown() {
    let heat = "heat = { rated = 6.5, time_constant = 1.0 }";
    let (code, out) = connect("warm", heat, "wait 1\nstatus\nwait 3\nstatus\nget elbow heat\nget base heat\n");
    assert_eq!(code, 0, "{out}");
    let elbow = heats(&out, "elbow");
    let [early, late] = elbow.as_slice() else { panic!("{out}") };
    let percent = |text: &str| text.split(" %").next().and_then(|number| number.parse::<f64>().ok()).unwrap();
    // The value is at most half a second old.
    assert!((35.0..=58.0).contains(&percent(early)) && !early.contains("WARM"), "{early}: {out}");
    assert!((84.0..=90.0).contains(&percent(late)) && late.contains("WARM"), "{late}: {out}");
    assert!(out.contains("limited: heat"), "the board's own flag: {out}");
    assert!(out.contains("get: elbow heat ") && out.contains("get: base heat unknown"), "{out}");
    assert_eq!(heats(&out, "base"), ["unknown", "unknown"]);
}

#[test]
fn an_arm_whose_motors_are_unknown_says_so_and_one_without_drives_says_nothing() {
    let (code, out) = connect("cold", "", "wait 1\nstatus\n");
    assert_eq!(code, 0, "{out}");
    assert_eq!(out.matches("heat unknown").count(), 6, "{out}");
    let lines = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("no_drives.txt");
    std::fs::write(&lines, "home\nconfirm\narm\nstatus\n").unwrap();
    let mut program = at_the_top();
    program.args(["connect", "scenes/planar2r_swing.toml", "--target", "desk", "--script"]).arg(&lines);
    let (code, out, _) = told(program.output().unwrap());
    assert!(code == 0 && out.contains("shoulder") && !out.contains("heat"), "{out}");
}
