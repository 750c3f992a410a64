//! Checks of a robot file: the command, and the computation of loads that it uses.

use crate::compare_output;
use crate::program::{at_its_fixtures, told};
use robot_compiler::Ends;
use robot_compiler::check::{Draft, Severity};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use studies::check::{CheckResult, answer};

const TRAPS: &str = "tests/fixtures/traps.urdf";

fn check(arguments: &[&str]) -> (i32, String, String) {
    told(at_its_fixtures().arg("check").args(arguments).output().unwrap())
}

fn looked_at(path: &Path, gravity: [f64; 3]) -> CheckResult {
    answer(Draft::load_between(path, Ends::default()).unwrap(), &gravity).unwrap()
}

/// Robot files of a folder, without linkages.
fn robots(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(Path::new("../robots").join(folder)).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let arm = |path: &PathBuf| {
        path.extension().is_some_and(|extension| extension == "toml")
            && std::fs::read_to_string(path).unwrap().contains("[[joint]]")
    };
    let mut arms: Vec<PathBuf> = paths.filter(arm).collect();
    arms.sort();
    arms
}

#[test]
fn a_maker_s_mistakes_are_found_with_their_places() {
    let (code, out, error) = check(&[TRAPS]);
    assert_eq!((code, error.as_str()), (3, ""));
    compare_output("a_maker_s_mistakes_are_found_with_their_places", out);
}

#[test]
fn the_json_says_the_same_as_the_text() {
    let (code, out, _) = check(&[TRAPS, "--json"]);
    let json: Value = serde_json::from_str(&out).unwrap();
    let text = check(&[TRAPS]).1;
    let findings = json["findings"].as_array().unwrap();
    assert_eq!(code, 3);
    for finding in findings {
        let word = |key: &str| finding[key].as_str().unwrap();
        let place = format!("{}:{}:{}: {}\n", word("file"), finding["line"], finding["column"], word("field"));
        assert!(text.contains(&place) && text.contains(word("problem")) && text.contains(word("advice")), "{finding}");
    }
    let count = |severity| findings.iter().filter(|finding| finding["severity"] == severity).count();
    let counts = ["wrong", "doubt", "note"].map(count);
    assert_eq!(["wrong", "doubts", "notes"].map(|key| json[key].as_u64().unwrap() as usize), counts);
    let [wrong, doubts, notes] = counts;
    assert!(text.ends_with(&format!("\n{wrong} wrong, {doubts} doubts, {notes} notes\n")), "{text}");
}

#[test]
fn the_exit_code_is_that_of_the_worst_finding() {
    let (code, out, _) = check(&["tests/fixtures/planar.toml"]);
    assert_eq!(code, 0, "{out}");
    // Under a very large gravity, the arm falls.
    let (code, out, _) = check(&["tests/fixtures/planar.toml", "--gravity", "0,-9810,0"]);
    assert!(code == 3 && out.contains("it falls"), "{out}");
    for bad in [&["tests/fixtures/nowhere.toml"][..], &[TRAPS, "--tip", "gripr"], &[TRAPS, "--gravity", "0,1"]] {
        let (code, out, error) = check(bad);
        assert_eq!((code, out.as_str()), (2, ""), "{bad:?}");
        assert!(!error.is_empty());
    }
}

/// Two rods in a vertical plane: the loads as calculated by hand.
#[test]
fn loads_are_those_of_the_worst_posture() {
    let planar = looked_at(Path::new("../robots/planar2r.toml"), [0.0, -9.81, 0.0]);
    let loads = planar.loads.unwrap();
    let near = |found: f64, known: f64| assert!((found / known - 1.0).abs() < 1e-3, "{found} {known}");
    near(loads[0].holding, 9.81 * (2.0 * 0.5 + 1.5 * 1.4));
    near(loads[1].holding, 9.81 * 1.5 * 0.4);
    // D_11 = I1 + m1 c1^2 + I2 + m2 (l1^2 + c2^2 + 2 l1 c2 cos q2).
    let own = 0.5 / 3.0 + 2.0 * 0.25 + 0.08 + 1.5 * (1.0 + 0.16);
    near(loads[0].inertia.0, own - 1.5 * 0.8);
    near(loads[0].inertia.1, own + 1.5 * 0.8);
    near(loads[1].inertia.0, 0.08 + 1.5 * 0.16);
    near(loads[1].inertia.1, 0.08 + 1.5 * 0.16);
}

#[test]
fn no_shipped_robot_is_wrong() {
    let mut told = String::new();
    for path in ["", "examples", "chapter12"].into_iter().flat_map(robots) {
        let answer = looked_at(&path, [0.0, 0.0, -9.81]);
        let rules: BTreeSet<&str> = answer.findings.iter().map(|finding| finding.rule.name()).collect();
        let counts = [Severity::Wrong, Severity::Doubt, Severity::Note].map(|severity| answer.count(severity));
        assert_eq!(counts[0], 0, "{}", answer.text());
        let name = path.strip_prefix("../robots").unwrap().display();
        told += &format!("{name}: {counts:?} {rules:?}\n");
        // A new doubt about a shipped arm is either true or a mistake in a rule.
        for doubt in answer.findings.iter().filter(|finding| finding.severity == Severity::Doubt) {
            told += &format!("    {}: {}\n", doubt.rule.name(), doubt.place.field());
        }
    }
    compare_output("no_shipped_robot_is_wrong", told);
}

/// The advice claims that a rotor often has as much inertia as the link. For the Puma 560, as others measured it, that is true.
#[test]
fn the_rotors_of_the_puma_have_a_large_share_of_what_its_joints_feel() {
    let puma = looked_at(Path::new("../robots/puma560.toml"), [0.0, 0.0, -9.81]);
    let loads = puma.loads.unwrap();
    let most = puma.draft.robot.joints.iter().zip(loads).map(|(joint, load)| {
        let rotor = joint.spec.rotor.reflected();
        rotor / (rotor + load.inertia.0)
    });
    let most: Vec<f64> = most.collect();
    assert!(most.iter().all(|share| *share > 0.3), "{most:?}");
    assert!(most[3..].iter().all(|share| *share > 0.9), "{most:?}");
}

#[test]
fn an_arm_that_cannot_be_put_into_postures_says_so() {
    let text = std::fs::read_to_string(TRAPS).unwrap().replace("value=\"1.5\"", "value=\"-1.5\"");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("negative.urdf");
    std::fs::write(&path, text).unwrap();
    let (code, out, _) = check(&[path.to_str().unwrap()]);
    assert_eq!(code, 3);
    assert!(out.contains("mass -1.5 kg is negative") && out.contains("correct the masses first"), "{out}");
}

/// Two rods in a plane, stretched and fast: the figures as calculated by hand. They turn at 8 and 10 rad/s, with 120 and 50 N m. The default scene
/// begins stretched.
#[test]
fn what_matters_to_a_person_is_what_the_limits_allow() {
    let hazard = looked_at(Path::new("../robots/planar2r.toml"), [0.0, 0.0, -9.81]).hazard.unwrap();
    let near = |found: f64, known: f64| assert!((found / known - 1.0).abs() < 1e-3, "{found} {known}");
    near(hazard.moving_mass, 3.5);
    let speed = 8.0 * 1.8 + 10.0 * 0.8;
    near(hazard.tip_speed.unwrap(), speed);
    near(hazard.tip_speed_bound.unwrap(), speed);
    // Mass matrix of the stretched arm.
    let (elbow, coupling) = (0.08 + 1.5 * 0.16, 1.5 * 0.4);
    let shoulder = 0.5 / 3.0 + 2.0 * 0.25 + 1.5 + elbow + 2.0 * coupling;
    near(hazard.kinetic_energy.unwrap(), 0.5 * (shoulder * 64.0 + 2.0 * (elbow + coupling) * 80.0 + elbow * 100.0));
    // Perpendicular to the arm, where the elbow is the weaker joint.
    near(hazard.tip_force.unwrap(), 50.0 / 0.8);
    // Two ticks of age, one until the next decision, two of latency; there are no drives.
    near(hazard.reaction_time, 0.005);
    // From the velocity limit of either joint, 0.25 s, and the reaction time.
    near(hazard.stopping_time.unwrap(), 0.255);
    near(hazard.stopping_distance.unwrap(), speed * (0.005 + 0.125));
}

/// The same rods in a vertical plane: each joint's greatest acceleration by gravity, from a grid of postures.
#[test]
fn an_arm_with_brakes_falls_until_they_have_engaged_and_check_says_how_far() {
    let looked = looked_at(Path::new("../robots/planar2r.toml"), [0.0, -9.81, 0.0]);
    let hazard = looked.hazard.unwrap();
    let range = |i: usize| looked.draft.robot.joints[i].spec.limits.position;
    let at = |i: usize, k: u32| range(i).0 + f64::from(k) / 400.0 * (range(i).1 - range(i).0);
    let mut worst = [0.0_f64; 2];
    for (q1, q2) in (0..=400).flat_map(|i| (0..=400).map(move |k| (at(0, i), at(1, k)))) {
        let (elbow, coupling) = (0.08 + 1.5 * 0.16, 1.5 * 0.4 * q2.cos());
        let (a, b, d) = (0.5 / 3.0 + 2.0 * 0.25 + 1.5 + elbow + 2.0 * coupling, elbow + coupling, elbow);
        let g2 = 9.81 * 1.5 * 0.4 * (q1 + q2).cos();
        let g1 = 9.81 * (2.0 * 0.5 + 1.5) * q1.cos() + g2;
        let determinant = a * d - b * b;
        worst[0] = worst[0].max(((d * g1 - b * g2) / determinant).abs());
        worst[1] = worst[1].max(((a * g2 - b * g1) / determinant).abs());
    }
    assert!((hazard.brake_delay - 0.1).abs() < 1e-12);
    for (sag, worst) in hazard.sag.iter().zip(worst) {
        let known = 0.5 * worst * 0.01;
        assert!((sag / known - 1.0).abs() < 0.01, "{sag} {known}");
    }
    assert!(
        hazard
            .text()
            .contains("If the arm has brakes, it falls after a fault until they have engaged (100 ms, assumed)"),
        "{}",
        hazard.text()
    );
    // Without brakes, the line is missing.
    let (_, out, _) = check(&["../robots/yam.toml", "--scene", "../scenes/yam_move.toml"]);
    assert!(!out.contains("its brakes have engaged"), "{out}");
    // No scene specifies brakes, but an arm with a rest pose most likely has none.
    let (_, out, _) = check(&["../robots/yam.toml"]);
    assert!(!out.contains("have engaged") && !out.contains("undeclared"), "{out}");
}

/// A scene with a brake delay of zero, which no real brake reaches, does not hide how far the arm falls.
#[test]
fn a_scene_whose_brakes_need_no_time_shows_the_fall_of_slow_ones() {
    let scene = |name: &str, lines: &str| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.toml"));
        let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/yam.toml");
        let text = format!(
            "name = \"{name}\"\nrobot = \"{}\"\n[control]\nrate = 1000\nnatural_frequency = 20.0\n[motion]\nkind = \"hold\"\n\
             q = [0.0, 0.6, 0.8, 0.0, 0.0, 0.0]\nduration = 1.0\n[safety]\nsafe_action = \"brake\"\n{lines}\n",
            robot.display()
        );
        std::fs::write(&path, text).unwrap();
        check(&["../robots/yam.toml", "--scene", path.to_str().unwrap()]).1
    };
    let falls = |out: &str| out.lines().find(|line| line.contains("its brakes have engaged")).unwrap().to_owned();
    let (zero, given) = (scene("brakes_of_zero", "brake_delay_ms = 0"), scene("brakes_given", "brake_delay_ms = 100"));
    assert!(falls(&zero).contains("(100 ms, assumed)"), "{zero}");
    assert_eq!(falls(&zero).replace(", assumed", ""), falls(&given));
    let heading = "settings of the scene: think about them before the arm is armed";
    assert!(zero.contains(heading) && !given.contains(heading), "{zero}");
}

/// The mass that `check` prints is that of the weakest joint, from a grid of postures: in no posture of the grid is the capacity less.
#[test]
fn an_undeclared_mass_that_the_first_motion_holds_is_printed() {
    let mass = |lines: &str| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("undeclared.toml");
        let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/planar2r.toml");
        let text = format!(
            "name = \"undeclared\"\nrobot = \"{}\"\n[control]\nrate = 1000\n[model]\ngravity = [0.0, -9.81, 0.0]\n[motion]\nkind = \"hold\"\n\
             q = [0.0, 0.5]\nduration = 1.0\n[safety]\n{lines}\n",
            robot.display()
        );
        std::fs::write(&path, text).unwrap();
        let arguments =
            ["../robots/planar2r.toml", "--gravity", "0,-9.81,0", "--scene", path.to_str().unwrap(), "--json"];
        let json: Value = serde_json::from_str(&check(&arguments).1).unwrap();
        json["hazard"]["undeclared"].clone()
    };
    // If the arm is stretched and horizontal, its levers are longest: the shoulder carries 9.81 x 3.1 N m of its 120, the elbow 9.81 x 0.6 of its 50.
    let shoulder = (0.2 * 120.0_f64).min(120.0 - 9.81 * 3.1) / (9.81 * 1.8);
    let elbow = (0.2 * 50.0_f64).min(50.0 - 9.81 * 0.6) / (9.81 * 0.8);
    let found = mass("first_motion = 0.2");
    let (joint, weakest) = if shoulder < elbow { (0, shoulder) } else { (1, elbow) };
    assert_eq!(found[0], joint, "{found}");
    assert!((found[1].as_f64().unwrap() / weakest - 1.0).abs() < 0.01, "{found} {weakest}");
    assert!(mass("first_motion = 1").is_null());
}

#[test]
fn figures_come_from_the_scene_and_stand_beside_those_of_the_standard() {
    let (code, out, error) = check(&["../robots/yam.toml", "--scene", "../scenes/yam_move.toml", "--json"]);
    assert!(code == 0 || code == 3, "{error}");
    let json: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["hazard"]["scene"], "yam_move");
    assert_eq!(json["class_i"], serde_json::json!({ "mass": 10.0, "force": 50.0, "speed": 0.25 }));
    let hazard = |key: &str| json["hazard"][key].as_f64().unwrap();
    assert!(hazard("tip_speed") <= hazard("tip_speed_bound") && hazard("tip_speed") > 1.0, "{out}");
    // Drives on CAN: one more tick for their reply.
    assert!((hazard("reaction_time") - 0.006).abs() < 1e-12, "{out}");
    let text = check(&["../robots/yam.toml", "--scene", "../scenes/yam_move.toml"]).1;
    assert!(text.contains("near a person (scene yam_move)") && text.contains("Limits are software."), "{text}");
    // A joint without limits has no bound.
    let text = std::fs::read_to_string("../robots/planar2r.toml").unwrap().replace("velocity = 8.0, ", "");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("without_velocity.toml");
    std::fs::write(&path, text).unwrap();
    let (_, out, _) = check(&[path.to_str().unwrap()]);
    assert!(out.contains("tip speed            unbounded"), "{out}");
    let (code, _, error) = check(&["../robots/yam.toml", "--scene", "../scenes/ur5_wave.toml"]);
    assert!(code == 2 && error.contains("a scene of another robot"), "{error}");
}

/// A scene of the YAM with other lines, and the oscillation that `check` finds: problem and advice.
fn oscillation(file: &str, rate: f64, law: &str, frequency: &str) -> Option<(String, String)> {
    let text = std::fs::read_to_string("../scenes/yam_one_bus.toml").unwrap();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots").display().to_string();
    let text = text
        .replace("../robots", &robots)
        .replace("rate = 400", &format!("rate = {rate}"))
        .replace("\"split\"", &format!("\"{law}\""))
        .replace("40.0", frequency);
    // A hand-guided arm has no error to remove.
    let text: String = text
        .lines()
        .filter(|line| law != "teach" || !line.starts_with("integral"))
        .fold(String::new(), |text, line| text + line + "\n");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("oscillation_{file}.toml"));
    std::fs::write(&path, text).unwrap();
    let (code, out, error) = check(&["../robots/yam.toml", "--scene", path.to_str().unwrap(), "--json"]);
    let json: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{error}"));
    let found = json["findings"].as_array().unwrap().iter().find(|finding| finding["rule"] == "oscillation");
    assert_eq!(code, if found.is_some() { 3 } else { 0 }, "{out}");
    let text = |finding: &Value, key: &str| finding[key].as_str().unwrap().to_owned();
    let found = found.map(|finding| (text(finding, "problem"), text(finding, "advice")));
    if let Some((problem, _)) = &found {
        let (_, out, _) = check(&["../robots/yam.toml", "--scene", path.to_str().unwrap()]);
        assert!(out.contains(problem) && out.contains("wrong: the scene's controller cannot hold the arm"), "{out}");
    }
    found
}

#[test]
fn gains_that_are_too_high_for_the_rate_are_wrong_and_quiet_ones_are_named() {
    let (problem, advice) = oscillation("high", 100.0, "split", "40.0").unwrap();
    assert!(
        problem.starts_with("the simulated arm, held at rest at 100 Hz, oscillates: the torque of joint "),
        "{problem}"
    );
    let quiet = advice.split("natural_frequency = ").nth(1).unwrap().split('`').next().unwrap();
    let frequency: f64 = quiet.parse().unwrap();
    assert!((15.0..40.0).contains(&frequency), "{advice}");
    // What it advises is quiet, and so are the gains that these tests use at 100 Hz, and the shipped ones at their rate.
    assert_eq!(oscillation("advised", 100.0, "split", quiet), None);
    assert_eq!(oscillation("half", 100.0, "split", "20.0"), None);
    assert_eq!(oscillation("shipped", 400.0, "split", "40.0"), None);
    // Another law, whose spring the board computes.
    assert!(oscillation("computed", 50.0, "computed-torque", "60.0").is_some());
    assert_eq!(oscillation("slow_law", 50.0, "computed-torque", "10.0"), None);
    // A law for hand guiding holds nothing; another one holds the arm before and after.
    assert_eq!(oscillation("guided", 400.0, "teach", "40.0"), None);
    let (problem, _) = oscillation("teach", 50.0, "teach", "40.0").unwrap();
    assert!(problem.starts_with("the simulated arm, held at rest after hand guiding at 50 Hz, "), "{problem}");
}

/// Findings that once were missing: the reBot's shoulder needs 15.5 N m in its worst posture, and its motor gives 8 N m for ever while it stands still.
/// The YAM's needs 15.3 and has 9.
#[test]
fn shoulders_that_overheat_are_found() {
    for (name, needs, rated) in [("rebot_b601_rs", "15.5", "8.00"), ("yam", "15.3", "9.00")] {
        let path = format!("../robots/{name}.toml");
        let answer = looked_at(Path::new(&path), [0.0, 0.0, -9.81]);
        let hot: Vec<_> = answer.findings.iter().filter(|finding| finding.rule.name() == "heat").collect();
        let doubts: Vec<_> = hot.iter().filter(|finding| finding.severity == Severity::Doubt).collect();
        assert!(doubts.iter().any(|finding| finding.place.field().starts_with("joint 2 (shoulder)")), "{doubts:?}");
        let problem = doubts[0].place.problem();
        assert!(
            problem.contains(&format!("takes {needs} N m")) && problem.contains(&format!("gives {rated} N m for ever")),
            "{problem}"
        );
        // No maker publishes a thermal time constant.
        assert!(
            hot.iter()
                .any(|finding| finding.severity == Severity::Note && finding.place.problem().contains("time constant"))
        );
        // In its rest pose, the arm needs no torque.
        assert!(answer.findings.iter().all(|finding| finding.rule.name() != "rest"), "{}", answer.text());
    }
}
