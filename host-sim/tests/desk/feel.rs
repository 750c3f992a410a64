//! `connect` with an arm for which law, stiffness and payload change while it is armed; with wrong torque units; and with drives that report faults.

use crate::program::{at_the_top, new, told};
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Runs a script with a YAM scene that is tunable at run time and contains these additional lines.
fn connect(name: &str, more: &str, script: &str) -> (i32, String) {
    connect_with(name, more, script, &[])
}

/// As [`connect`], with more options.
fn connect_with(name: &str, more: &str, script: &str, options: &[&str]) -> (i32, String) {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/yam.toml");
    let scene = format!(
        r#"
name = "{name}"
robot = "{}"
[model]
payload = "live"
[control]
rate = 1000
law = "impedance"
stiffness = [80.0, 80.0, 80.0, 10.0, 10.0, 10.0]
tunable = true
teach = {{}}
[collision]
reaction = "report"
[motion]
kind = "quintic"
points = [
    {{ q = [0.0, 0.6, 0.8, 0.0, 0.0, 0.0] }},
    {{ q = [0.3, 0.9, 1.0, 0.1, 0.0, 0.2], duration = 1.0 }},
]
[safety]
safe_action = "damped-stop"
# The first motion has tests of its own.
first_motion = 1
{more}
"#,
        robot.display()
    );
    let (path, lines) = (file(&format!("{name}.toml")), file(&format!("{name}_feel.txt")));
    std::fs::write(&path, scene).unwrap();
    std::fs::write(&lines, format!("home\nconfirm\narm\n{script}quit!\n")).unwrap();
    let (code, out, error) = told(
        at_the_top()
            .arg("connect")
            .arg(&path)
            .args(["--target", "desk", "--script"])
            .arg(&lines)
            .args(options)
            .output()
            .unwrap(),
    );
    assert_eq!(error, "", "{out}");
    (code, out)
}

/// The torque of each joint in the last status that was printed, N m.
fn torques(out: &str) -> Vec<f64> {
    let last = out.rsplit("tick ").next().unwrap();
    last.lines().filter_map(|line| line.split("rad").nth(1)?.split("N m").next()?.trim().parse().ok()).collect()
}

#[test]
fn law_and_stiffness_change_without_a_jump_of_torque_and_a_hand_can_lead_the_arm_in_between() {
    let script = "wait 0.2\nstatus\nsoft\nget 2 position gain\nstiff\nlaw computed-torque\nstatus\nlaw impedance\nstiffness 1\nstatus\n\
                  teach\nwait 0.3\nhold\nlaw impedance\nrun\nwait\nlaw pd\n";
    let (code, out) = connect("feel", "", script);
    assert_eq!(code, 3, "{out}");
    for line in [
        "stiffness: 0.25 of the scene's",
        "stiffness: 4 of the scene's",
        "law: computed-torque",
        "stiffness: 1 of the scene's",
        "law: teach",
        "teach: running; guide it by hand, then `hold`",
        "hold: holding: as requested",
        "run: running; ",
        "wait: arrived; ",
    ] {
        assert!(out.contains(line), "{line}: {out}");
    }
    // The law without gravity compensation would drop the arm. So the arm is stopped first, and the law is rejected.
    let last: Vec<&str> = out.lines().rev().take(4).collect();
    assert!(out.contains("law: rejected: the torque of joint "), "{last:?}");
    let gain = out.split("position gain ").nth(1).unwrap().split(' ').next().unwrap();
    let bounds = out.split("1/s^2 (").nth(1).unwrap().split(" to ").next().unwrap();
    assert_eq!(gain, bounds, "the softest is the lower bound: {out}");
    // At rest, every law holds the arm with the same torques, except for the part that friction hides: 0.3 N m.
    let statuses: Vec<Vec<f64>> =
        out.split("armed; homed").skip(1).map(|part| torques(&format!("tick {part}"))).collect();
    assert!(statuses.len() >= 3, "{out}");
    for other in &statuses[1..] {
        let far = statuses[0].iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(statuses[0].len() == 6 && far < 0.3, "{statuses:?}");
    }
}

#[test]
fn a_payload_is_taken_up_in_parts_where_all_at_once_would_jump() {
    // A kilogram at the tip causes several newton metres at the shoulder. In one tick, 2 of them may be added.
    let (code, out) = connect("feel_payload", "", "payload 1.5 0 0 0.1\nstatus\npayload 0\n");
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("payload: 1.5 kg at 0.000 0.000 0.100 m in the tip frame (0 to "), "{out}");
    assert!(out.contains("payload: 0 kg (0 to ") && out.matches("shoulder +0.00 N m").count() == 0, "{out}");
}

#[test]
fn what_the_arm_holds_is_weighed_and_told_and_the_arm_no_longer_sags() {
    let held = "[plant]\npayload = { mass = 0.8, com = [0.0, 0.0, 0.05] }\n";
    let (code, out) = connect("weigh", held, "wait 0.3\nweigh\nstatus\n");
    assert_eq!(code, 0, "{out}");
    let said = out.split("weigh: ").nth(1).unwrap();
    let mass: f64 = said.split(" kg").next().unwrap().parse().unwrap();
    assert!((mass - 0.8).abs() < 0.06, "{out}");
    let interval: Vec<f64> = said
        .split("95 %: ")
        .nth(1)
        .unwrap()
        .split(',')
        .next()
        .unwrap()
        .split(" to ")
        .map(|x| x.parse().unwrap())
        .collect();
    assert!(interval[0] < 0.8 && 0.8 < interval[1], "{out}");
    assert!(out.contains("weigh: 0.") && out.contains("torque to hold the arm changes by base "), "{out}");
    let centre: Vec<f64> = said
        .split(" at ")
        .nth(1)
        .unwrap()
        .split(" m in the tip frame")
        .next()
        .unwrap()
        .split(' ')
        .map(|x| x.parse().unwrap())
        .collect();
    assert!(centre.iter().zip([0.0, 0.0, 0.05]).all(|(found, put)| (found - put).abs() < 0.02), "{centre:?}: {out}");
    // Without a payload, no payload is sent.
    let (code, out) = connect("weigh_nothing", "", "wait 0.3\nweigh\n");
    assert!(code == 0 && (out.contains("nothing that can be told") || out.contains("weigh: 0.0")), "{out}");
}

#[test]
fn a_torque_unit_that_is_wrong_is_named_before_anything_moves() {
    // Right units: there is no warning, and the factor of the elbow is near 1.
    let (code, out) = connect("units", "", "check-torque elbow\njog 2 0.1\nwait\n");
    assert_eq!(code, 0, "{out}");
    assert!(!out.contains("torque of elbow") && !out.contains("WRONG"), "{out}");
    let factor: f64 = out.split("elbow ").nth(1).unwrap().trim().split(' ').next().unwrap().parse().unwrap();
    assert!((factor - 1.0).abs() < 0.06, "{out}");

    // Factor 1.3: there is a warning, and the arm may move.
    let (code, out) =
        connect("units_more", "[actuators]\ntorque_factor = 1.3\n", "jog 2 0.1\nwait\ncheck-torque elbow\n");
    assert_eq!(code, 0, "{out}");
    let said = out.find("is 1.").unwrap_or_else(|| panic!("{out}"));
    assert!(said < out.find("jog: running").unwrap() && out.contains("N m by the model"), "{out}");
    let factor: f64 = out.split("  elbow ").nth(1).unwrap().trim().split(' ').next().unwrap().parse().unwrap();
    assert!((factor - 1.3).abs() < 0.08 && out.contains("WRONG"), "{out}");

    // Factor 4: no motion begins. Factor 1/4: the arm sinks, is stopped, and the reason is named.
    let (code, out) = connect("units_four", "[actuators]\ntorque_factor = 4.0\n", "jog 2 0.1\n");
    assert!(
        code == 3
            && out.contains("is 3.")
            && out.contains("motion rejected")
            && out.contains("likely cause: ")
            && !out.contains("jog: running"),
        "{out}"
    );
    let (code, out) = connect("units_quarter", "[actuators]\ntorque_factor = 0.25\n", "wait 0.3\n");
    assert!(
        code == 3
            && out.contains("fault 15")
            && out.contains("torque of elbow is 0.2")
            && out.contains("likely cause: "),
        "{out}"
    );
}

#[test]
fn a_drive_says_in_its_own_words_what_is_wrong() {
    let failure = "[actuators]\nfailure = { joint = 3, at = 0.2, kind = \"error\" }\n";
    let (code, out) = connect("words", failure, "wait 0.5\nstatus\n");
    assert_eq!(code, 3, "{out}");
    assert!(out.contains("fault 11: the drive reports a fault (joint 3)"), "{out}");
    assert!(out.contains("joint 3 says: overloaded (error 0xe)"), "{out}");
}

#[test]
fn a_push_is_told_in_newtons_at_the_tip() {
    let push = "[plant]\npush = { at = 0.3, duration = 2.0, wrench = { force = [0.0, 0.0, -8.0] } }\n";
    let (code, out) = connect("push", push, "wait 0.2\nstatus\nwait 0.6\nstatus\n");
    assert_eq!(code, 0, "{out}");
    let forces: Vec<[f64; 3]> = out
        .split("force ")
        .skip(1)
        .map(|part| {
            let numbers: Vec<f64> = part.split(" N").next().unwrap().split(' ').map(|x| x.parse().unwrap()).collect();
            numbers.try_into().unwrap()
        })
        .collect();
    let [before, during] = forces.as_slice() else { panic!("{out}") };
    let size = |force: &[f64; 3]| force.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Stiction of 0.3 N m can hide a newton at the tip.
    assert!(size(before) < 2.0, "{before:?}");
    assert!((size(during) - 8.0).abs() < 2.5, "{during:?}");
}

#[test]
fn a_motion_worth_recording_is_played_and_its_record_is_a_log() {
    let motion = file("feel_motion.toml");
    let (code, _, error) = told(
        at_the_top()
            .args(["identify", "excite", "scenes/yam_move.toml", "--periods", "1", "--out"])
            .arg(new(&motion))
            .output()
            .unwrap(),
    );
    assert_eq!((code, error.as_str()), (0, ""));
    let record = new(&file("feel_record.log")).to_owned();
    let more = ["--motion", motion.to_str().unwrap(), "--record", record.to_str().unwrap()];
    let (code, out) = connect_with("feel_plays", "", "run\nwait\n", &more);
    assert!(code == 0 && out.contains("wait: arrived"), "{out}");
    let (code, out, error) =
        told(at_the_top().args(["identify", "robots/yam.toml", "--json", "--log"]).arg(&record).output().unwrap());
    assert!(matches!(code, 0 | 3), "{out}{error}");
    let found: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(code == 0, found["verdict"]["grade"] == "trusted", "{out}{error}");
    let joints = found["joints"].as_array().unwrap();
    // The arm matches its file, so identification improves nothing, and the residual is small.
    assert!(
        joints.len() == 6 && joints.iter().all(|joint| joint["relative_rms"].as_f64().unwrap() < 0.25),
        "{joints:?}"
    );
    // A record without torque.
    let idle = new(&file("feel_idle.log")).to_owned();
    connect_with("feel_idles", "", "disarm\n", &["--record", idle.to_str().unwrap()]);
    let short = std::fs::read(&idle).unwrap();
    std::fs::write(&idle, &short[..short.len() - 3]).unwrap();
    let (code, _, error) =
        told(at_the_top().args(["identify", "robots/yam.toml", "--log"]).arg(&idle).output().unwrap());
    assert!(code == 2 && error.contains("feel_idle.log"), "{error}");
}

/// Positions in the statuses that were printed, rad.
fn positions(out: &str) -> Vec<Vec<f64>> {
    let of = |part: &str| {
        part.lines()
            .skip(1)
            .take_while(|line| line.starts_with("  "))
            .map_while(|line| line.split(" rad").next()?.split_whitespace().nth(1)?.parse().ok())
            .collect()
    };
    out.split("\ntick ").skip(1).map(of).collect()
}

#[test]
fn a_payload_is_declared_where_it_is_in_the_tip_frame_and_the_arm_does_not_sag() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let yam = std::fs::read_to_string(root.join("yam.toml")).unwrap();
    // The shipped arm, and one with a tool that moves and turns the tip.
    let tool = "\n[tool]\nplacement = { xyz = [0.03, -0.02, 0.08], rpy = [0.7, -0.5, 0.3] }\n";
    for (name, more) in [("tip", ""), ("tool", tool)] {
        let (robot, path) = (file(&format!("payload_{name}_robot.toml")), file(&format!("payload_{name}.toml")));
        std::fs::write(&robot, format!("{yam}{more}")).unwrap();
        let scene = format!(
            "name = \"payload_{name}\"\nrobot = \"{}\"\n[model]\npayload = \"live\"\n\
             [plant]\npayload = {{ mass = 1.0, com = [0.0, 0.0, 0.1] }}\n[control]\nrate = 1000\nnatural_frequency = 20.0\n\
             [motion]\nkind = \"quintic\"\npoints = [{{ q = [0.0, 0.6, 0.8, 0.0, 0.0, 0.0] }}, {{ q = [0.2, 0.9, 1.1, 0.1, -0.1, 0.2], duration = 1.5 }}]\n\
             [safety]\nsafe_action = \"damped-stop\"\n",
            robot.display()
        );
        std::fs::write(&path, scene).unwrap();
        let script = file(&format!("payload_{name}.txt"));
        let commands = "home\nconfirm\nstatus\npayload 1.0 0 0 0.1\narm\nwait 1\nstatus\nrun\nwait\nquit!\n";
        std::fs::write(&script, commands).unwrap();
        let mut connect = at_the_top();
        connect.arg("connect").arg(&path).args(["--target", "desk", "--script"]).arg(&script);
        let (code, out, error) = told(connect.output().unwrap());
        assert_eq!((code, error.as_str()), (0, ""), "{out}");
        let q = positions(&out);
        let sag = q[0].iter().zip(&q[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(q.len() == 2 && q[0].len() == 6 && sag < 0.02, "{name}: {sag} rad: {out}");
        assert!(
            out.contains("payload: 1 kg at 0.000 0.000 0.100 m in the tip frame") && out.contains("wait: arrived"),
            "{out}"
        );
    }
}

#[test]
fn a_motion_of_a_milliradian_does_not_knock() {
    let script = "wait 0.5\nwatch 1\njog shoulder 0.001\nwait\njog elbow -0.001\nwait\njog 4 1e-4\nwait\nwatch 0\n";
    let (code, out) = connect("tiny", "", script);
    assert_eq!(code, 0, "{out}");
    let torques: Vec<Vec<f64>> = out
        .lines()
        .filter_map(|line| line.split("  torque ").nth(1))
        .map(|part| part.split_whitespace().map_while(|x| x.parse().ok()).collect())
        .collect();
    assert!(torques.len() > 500 && torques.iter().all(|torque| torque.len() == 6), "{out}");
    let knock = |joint: usize| {
        let of = |f: fn(f64, f64) -> f64, from| torques.iter().map(|torque| torque[joint]).fold(from, f);
        of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
    };
    let worst = (0..6).map(knock).fold(0.0, f64::max);
    // With full acceleration for a few ticks it would be 6 to 8 N m. Of the remaining range, 0.6 N m is friction that reverses its sign.
    assert!(worst < 1.5, "{worst} N m");
}

#[test]
fn hand_guiding_says_how_good_the_gravity_model_is_and_is_rejected_where_the_arm_would_drift() {
    let (code, out) = connect("guide", "", "teach\nwait 0.1\nhold\n");
    assert!(code == 0 && out.contains("teach: error of the gravity model: ") && out.contains("identify"), "{out}");
    assert!(out.contains("teach: running; guide it by hand"), "{out}");
    // With 20 % mass error, the shoulder's gravity error is above its friction of 0.3 N m.
    let (code, out) = connect("guide_heavy", "[plant]\nmasses = [1.2, 1.2, 1.2, 1.2, 1.2, 1.2]\n", "teach\n");
    assert!(code == 3 && out.contains("teach: rejected: the error of the gravity model exceeds the friction"), "{out}");
    assert!(out.contains("elbow 0.97 N m") && !out.contains("law: teach"), "{out}");
}

#[test]
fn hand_guiding_is_rejected_in_a_soft_wall_and_possible_right_after_a_motion() {
    // 0.05 rad above its lower limit the shoulder stands in a wall, which would lift it at once.
    let (code, out) = connect(
        "walls",
        "",
        "goto 0 0.05 0.8 0 0 0\nwait\nteach\ngoto 0 0.9 0.8 0 0 0\nwait\nhold\nhold\nteach\nwait 0.1\nhold\n",
    );
    let rejected =
        out.find("teach: rejected: in the soft walls of hand guiding, which would push at once, stand shoulder by ");
    let led = out.find("teach: running; guide it by hand");
    assert!(code == 3 && rejected.is_some() && led > rejected, "{out}");
    assert!(!out.contains("elbow by") && out.matches("law: teach").count() == 1, "{out}");
    assert!(
        out.contains("hold: the arm is held already: holding: as requested") && !out.contains("hold: rejected"),
        "{out}"
    );
}

#[test]
fn an_arm_that_still_brakes_is_judged_by_where_it_comes_to_rest() {
    let (code, out) = connect("braking", "", "goto 0 0.02 0.8 0 0 0\nwait 0.55\nhold\nteach\nwait 0.1\nstatus\n");
    assert!(code == 3 && out.contains("teach: rejected: in the soft walls"), "{out}");
    // A payload that it does not know: rejected for drift, and `weigh` does not let it go either.
    let heavy = "[plant]\nmasses = [1.2, 1.2, 1.2, 1.2, 1.2, 1.2]\n";
    let (code, out) = connect("gripped", heavy, "disarm!\nlaw teach\narm\nweigh\nrun\njog shoulder 0.1\n");
    assert!(code == 3 && !out.contains(": running"), "{out}");
}

/// A scene whose law is `teach` from the start: `run` begins hand guiding.
#[test]
fn the_walls_count_for_run_too() {
    let scene =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/yam_teach.toml")).unwrap();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let scene = scene.replace("../robots", &robots.display().to_string()).replace("q = [0.0, 1.0,", "q = [0.0, 0.02,");
    let (path, lines) = (file("teach_wall.toml"), file("teach_wall.txt"));
    std::fs::write(&path, scene).unwrap();
    std::fs::write(
        &lines,
        "home\nconfirm\narm\nfull-range\nrun\ncheck-torque\njog shoulder 0.1\nwait 0.1\nstatus\nquit!\n",
    )
    .unwrap();
    let (code, out, _) = told(
        at_the_top().arg("connect").arg(&path).args(["--target", "desk", "--script"]).arg(&lines).output().unwrap(),
    );
    assert!(code == 3 && out.contains("run: rejected: in the soft walls of hand guiding"), "{out}");
    // A motion would only let the arm go.
    for name in ["check-torque", "jog"] {
        assert!(out.contains(&format!("{name}: rejected: an arm that is guided by hand follows no motion")), "{out}");
    }
    assert!(!out.contains("running") && out.contains("bring them out by hand"), "{out}");
}
