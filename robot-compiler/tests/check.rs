//! Rules about the numbers of an arm: each tested on a file that breaks it and on one just on the other side.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::panic, reason = "a test names the case that fails")]

use robot_compiler::check::{CheckRule, Draft, Finding, JointLoad, Severity, findings, scene_findings};
use robot_compiler::{Ends, Robot};
use std::collections::BTreeSet;

/// An arm of 1.0 m without findings, except that a URDF has no rotors.
const SOUND: &str = r#"<robot name="sound">
  <link name="stand"/>
  <link name="upper">
    <inertial><origin xyz="0 0 0.2"/><mass value="2.0"/>
      <inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.002"/></inertial>
  </link>
  <link name="fore">
    <inertial><origin xyz="0 0 0.15"/><mass value="1.0"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial>
  </link>
  <link name="hand">
    <inertial><origin xyz="0 0 0.05"/><mass value="0.4"/>
      <inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.0006" iyz="0" izz="0.0004"/></inertial>
  </link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute">
    <parent link="stand"/><child link="upper"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/><dynamics friction="0.4"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0 0 0.45"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" effort="20" velocity="3"/><dynamics friction="0.3"/>
  </joint>
  <joint name="wrist" type="revolute">
    <parent link="fore"/><child link="hand"/><origin xyz="0 0 0.35"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" effort="6" velocity="5"/><dynamics friction="0.1"/>
  </joint>
  <joint name="frame" type="fixed"><parent link="hand"/><child link="tip"/><origin xyz="0 0 0.2"/></joint>
</robot>"#;

/// Two joints with drives, friction and rotors, without findings.
const DRIVEN: &str = r#"
name = "driven"
[[joint]]
name = "lift"
type = "revolute"
dh = { a = 0.4, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 2.0
com = [-0.2, 0.0, 0.0]
inertia = { xx = 0.002, yy = 0.03, zz = 0.03 }
rotor = { inertia = 1e-4, gear = 30.0 }
friction = { coulomb = 0.4 }
limits = { position = [-2, 2], velocity = 3, torque = 40 }
[joint.drive]
kind = "mit"
bus = 1
id = 1
position = [-12.5, 12.5]
velocity = [-8, 8]
kp = [0, 500]
kd = [0, 5]
torque = [-60, 60]
damping = 2
[joint.heat]
rated = 10
time_constant = 90
[[joint]]
name = "bend"
type = "revolute"
dh = { a = 0.3, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 1.0
com = [-0.15, 0.0, 0.0]
inertia = { xx = 0.001, yy = 0.008, zz = 0.008 }
rotor = { inertia = 1e-4, gear = 20.0 }
friction = { coulomb = 0.2 }
limits = { position = [-2, 2], velocity = 3, torque = 20 }
[joint.drive]
kind = "mit"
bus = 1
id = 2
position = [-12.5, 12.5]
velocity = [-8, 8]
kp = [0, 500]
kd = [0, 5]
torque = [-30, 30]
damping = 2
[joint.heat]
rated = 5
time_constant = 60
"#;

fn load(holding: f64) -> JointLoad {
    JointLoad { holding, posture: vec![1.5, 0.0, 0.0], inertia: (0.1, 0.4), rest: None }
}

/// Loads of the two arms above, N m.
const SOUND_LOADS: [f64; 3] = [14.7, 3.0, 0.2];
const DRIVEN_LOADS: [f64; 2] = [9.3, 1.5];

fn told(draft: &Draft, loads: &[f64]) -> Vec<Finding> {
    let loads: Vec<JointLoad> = loads.iter().map(|holding| load(*holding)).collect();
    findings(draft, Some(&loads))
}

fn of_urdf(text: &str) -> Vec<Finding> {
    told(&Draft::from_urdf_str(text, "arm.urdf", Ends::tip("tip")).unwrap(), &SOUND_LOADS)
}

fn of_toml(text: &str) -> Vec<Finding> {
    told(&Draft::from_toml_str(text, "arm.toml").unwrap(), &DRIVEN_LOADS)
}

/// A text with changes; each text to be replaced must occur.
fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    })
}

/// Rules with findings, and their severity; without the rule about rotors, which no URDF has.
fn spoken(findings: &[Finding]) -> Vec<(&'static str, &'static str)> {
    let all = findings.iter().filter(|finding| finding.rule != CheckRule::Rotor || finding.severity != Severity::Note);
    all.map(|finding| (finding.rule.name(), finding.severity.name())).collect()
}

type Changes<'a> = &'a [(&'a str, &'a str)];
/// Changes, the rule and severity that they cause, and changes just short of them.
type Case<'a> = (Changes<'a>, (CheckRule, Severity), Changes<'a>);

#[test]
fn a_sound_arm_is_believed() {
    assert_eq!(spoken(&of_urdf(SOUND)), []);
    assert_eq!(spoken(&of_toml(DRIVEN)), []);
    assert_eq!(of_toml(DRIVEN).len(), 0);
    assert!(Robot::from_urdf_str(SOUND, "arm.urdf", Ends::tip("tip")).is_ok());
}

const HAND: &str = r#"<mass value="0.4"/>
      <inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.0006" iyz="0" izz="0.0004"/>"#;
const FORE: &str = r#"<mass value="1.0"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/>"#;

#[test]
fn every_rule_speaks_and_is_silent_on_the_other_side_of_its_threshold() {
    use CheckRule::*;
    use Severity::*;
    let urdf: [Case<'_>; 21] = [
        (&[("izz=\"0.001\"", "izz=\"0.03\"")], (ImpossibleBody, Wrong), &[("izz=\"0.001\"", "izz=\"0.019\"")]),
        (&[("izz=\"0.001\"", "izz=\"-0.001\"")], (ImpossibleBody, Wrong), &[("izz=\"0.001\"", "izz=\"0\"")]),
        (&[("value=\"1.0\"", "value=\"-1.0\"")], (ImpossibleBody, Wrong), &[("value=\"1.0\"", "value=\"0.8\"")]),
        // Grams on the last joint; in an arm whose links all weigh grams, that is its share.
        (&[("value=\"0.4\"", "value=\"0.019\"")], (Mass, Doubt), &[("value=\"0.4\"", "value=\"0.036\"")]),
        (
            &[("value=\"0.4\"", "value=\"0.007\""), ("0.0006", "1e-6"), ("0.0004", "1e-6")],
            (Mass, Doubt),
            &[
                ("value=\"2.0\"", "value=\"0.6\""),
                ("value=\"0.4\"", "value=\"0.021\""),
                ("0.0006", "2e-5"),
                ("0.0004", "1e-5"),
            ],
        ),
        (
            &[(HAND, "<mass value=\"0\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")],
            (Mass, Wrong),
            &[],
        ),
        (
            &[(FORE, "<mass value=\"0\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>")],
            (Mass, Doubt),
            &[],
        ),
        (
            &[(
                "<link name=\"tip\"/>",
                "<link name=\"tip\"><inertial><mass value=\"0\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial></link>",
            )],
            (Mass, Note),
            &[(
                "<link name=\"tip\"/>",
                "<link name=\"tip\"><inertial><mass value=\"0.2\"/><inertia ixx=\"1e-4\" ixy=\"0\" ixz=\"0\" iyy=\"1e-4\" iyz=\"0\" izz=\"1e-4\"/></inertial></link>",
            )],
        ),
        // The hand measures 0.2 m, plus a margin of 0.1 m: 0.6 m is twice that.
        (&[("0.0006", "0.037"), ("0.0004", "0.037")], (Gyration, Doubt), &[("0.0006", "0.035"), ("0.0004", "0.035")]),
        (&[("0.0006", "0.33"), ("0.0004", "0.33")], (Gyration, Wrong), &[("0.0006", "0.035"), ("0.0004", "0.035")]),
        (
            &[("0.0006", "3.8e-5"), ("0.0004", "3.8e-5")],
            (Gyration, Doubt),
            &[("0.0006", "4.2e-5"), ("0.0004", "4.2e-5")],
        ),
        (&[("0.0006", "0"), ("0.0004", "0")], (Gyration, Doubt), &[("0.0006", "4.2e-5"), ("0.0004", "4.2e-5")]),
        // m c^2 of the forearm is 0.0225 kg m^2.
        (&[("0.01\"", "0.0205\"")], (InertiaAtJoint, Doubt), &[("0.01\"", "0.0200\"")]),
        (&[("0.01\"", "0.0335\"")], (InertiaAtJoint, Doubt), &[("0.01\"", "0.0339\"")]),
        // The hand's joints are 0.2 m apart, and the margin is a quarter of 1 m.
        (&[("xyz=\"0 0 0.05\"", "xyz=\"0.46 0 0\"")], (MassCentre, Doubt), &[("xyz=\"0 0 0.05\"", "xyz=\"0.44 0 0\"")]),
        (&[("xyz=\"0 0 0.05\"", "xyz=\"2.1 0 0\"")], (MassCentre, Wrong), &[("xyz=\"0 0 0.05\"", "xyz=\"0.44 0 0\"")]),
        (&[("effort=\"6\"", "effort=\"-6\"")], (ImpossibleLimit, Wrong), &[("effort=\"6\"", "effort=\"0.4\"")]),
        (
            &[("lower=\"-2\" upper=\"2\"", "lower=\"1\" upper=\"1\"")],
            (ImpossibleLimit, Wrong),
            &[("lower=\"-2\"", "lower=\"0\"")],
        ),
        (
            &[("velocity=\"3\"", "velocity=\"10\""), ("velocity=\"5\"", "velocity=\"10\"")],
            (Placeholder, Doubt),
            &[("velocity=\"3\"", "velocity=\"10\""), ("velocity=\"5\"", "velocity=\"11\"")],
        ),
        (&[("velocity=\"5\"", "velocity=\"21\"")], (WideLimit, Doubt), &[("velocity=\"5\"", "velocity=\"20\"")]),
        (
            &[("-2.5\" upper=\"2.5\" effort=\"6", "-6.4\" upper=\"6.4\" effort=\"6")],
            (Angle, Doubt),
            &[("-2.5\" upper=\"2.5\" effort=\"6", "-6.2\" upper=\"6.2\" effort=\"6")],
        ),
    ];
    let toml: [Case<'_>; 13] = [
        (&[("friction = { coulomb = 0.2 }\n", "")], (Friction, Note), &[]),
        (&[("rotor = { inertia = 1e-4, gear = 20.0 }\n", "")], (Rotor, Note), &[]),
        // The link alone has at least 0.1 kg m^2.
        (
            &[("inertia = 1e-4, gear = 20.0", "inertia = 2.4e-6, gear = 20.0")],
            (Rotor, Doubt),
            &[("inertia = 1e-4, gear = 20.0", "inertia = 2.6e-6, gear = 20.0")],
        ),
        // Gravity needs at most 9.3 N m; 14 N m are half as much again.
        (&[("torque = 40", "torque = 9.2")], (Holding, Wrong), &[("torque = 40", "torque = 14")]),
        (&[("torque = 40", "torque = 13.9")], (Holding, Doubt), &[("torque = 40", "torque = 14")]),
        // 2 % of 1.5 N m are 4095 steps over 123 N m.
        (&[("[-30, 30]", "[-62, 62]")], (TorqueStep, Doubt), &[("[-30, 30]", "[-61, 61]")]),
        (&[("[-12.5, 12.5]", "[-660, 660]")], (PositionStep, Doubt), &[("[-12.5, 12.5]", "[-650, 650]")]),
        (&[("torque = 40", "torque = 40, torque_rate = 9"), (", torque = 20", "")], (MissingLimit, Note), &[]),
        (&[("position = [-2, 2]", "position = [2, -2]")], (ImpossibleLimit, Wrong), &[]),
        // Gravity needs at most 9.3 N m.
        (&[("rated = 10", "rated = 9.29")], (Heat, Doubt), &[("rated = 10", "rated = 9.31")]),
        (&[("rated = 5\n", "")], (Heat, Note), &[]),
        (&[("time_constant = 60\n", "")], (Heat, Note), &[]),
        (&[("zz = 0.008 }", "zz = 0.008, xy = 0.01 }")], (ImpossibleBody, Wrong), &[]),
    ];
    let known: BTreeSet<_> = urdf.iter().chain(&toml).map(|(_, (rule, _), _)| *rule).collect();
    // The rest pose and the rules about scenes have their own tests, because they need a load, or a scene.
    let known: BTreeSet<_> = known
        .into_iter()
        .chain([Rest, FirstMotion, LiveAge, CheckRule::BrakeDelay, CheckRule::Oscillation])
        .chain(crate::import::RULES)
        .collect();
    assert_eq!(known, BTreeSet::from(CheckRule::ALL), "a rule without a case");
    for (broken, said, sound) in urdf {
        let said = (said.0.name(), said.1.name());
        let told = spoken(&of_urdf(&changed(SOUND, broken)));
        assert!(told.contains(&said), "{broken:?}: {told:?}");
        let told = spoken(&of_urdf(&changed(SOUND, sound)));
        assert!(!told.iter().any(|(rule, _)| *rule == said.0), "{sound:?}: {told:?}");
    }
    for (broken, said, sound) in toml {
        let said = (said.0.name(), said.1.name());
        let broken = changed(DRIVEN, broken);
        // A drive must span the joint's limits. So missing and wrong limits are tested only without drives.
        let broken = match said.0 {
            "missing-limit" | "impossible-limit" => without_drives(&broken),
            _ => broken,
        };
        let told = of_toml(&broken);
        let told: Vec<_> = told.iter().map(|finding| (finding.rule.name(), finding.severity.name())).collect();
        assert!(told.contains(&said), "{said:?}: {told:?}");
        let told = of_toml(&changed(DRIVEN, sound));
        assert!(!told.iter().any(|finding| finding.rule.name() == said.0), "{said:?}");
    }
}

#[test]
fn every_rule_has_its_row_in_the_documentation() {
    let page = std::fs::read_to_string(crate::common::top("robots").join("README.md")).unwrap();
    let section = page.split("## Checks of a robot file").nth(1).unwrap();
    let rows: Vec<&str> = section.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    assert_eq!(rows, CheckRule::ALL.map(CheckRule::name));
}

#[test]
fn a_scene_of_an_arm_with_drives_is_asked_about_its_first_motion_and_the_age_of_live_inputs() {
    let rules = |robot: &str, lines: &str| {
        let scene =
            crate::common::standing(robot, &lines.replace("[safety]", "[safety]\nsafe_action = \"damped-stop\""));
        let found = scene_findings(&scene);
        assert!(found.iter().all(|finding| finding.severity == Severity::Note && finding.quote.is_none()));
        found.iter().map(|finding| finding.rule.name()).collect::<Vec<_>>()
    };
    let live = "[model]\npayload = \"live\"\n";
    for driven in ["yam", "examples/pwm2"] {
        assert_eq!(rules(driven, "[safety]\n"), [""; 0], "{driven}");
        assert_eq!(rules(driven, "[safety]\nfirst_motion = 1"), ["first-motion"], "{driven}");
        assert_eq!(rules(driven, "[safety]\nfirst_motion = 0.99"), [""; 0], "{driven}");
        assert_eq!(rules(driven, &format!("{live}[safety]\n")), ["live-age"], "{driven}");
        assert_eq!(rules(driven, &format!("{live}[safety]\nlive_age_ms = 100")), [""; 0], "{driven}");
    }
    // Nothing real moves in this scene.
    assert_eq!(rules("planar2r", &format!("{live}[safety]\nfirst_motion = 1")), [""; 0]);
}

#[test]
fn a_scene_of_an_arm_with_drives_is_asked_about_the_time_of_its_brakes() {
    let problems = |robot: &str, lines: &str| {
        let found = scene_findings(&crate::common::standing(robot, &format!("[safety]\n{lines}")));
        found.iter().map(|it| format!("{}: {}", it.rule.name(), it.place.problem())).collect::<Vec<_>>()
    };
    let [zero] = problems("yam", "brake_delay_ms = 0").try_into().unwrap();
    assert!(zero.starts_with("brake-delay: is 0: torque ends with the brakes' power"), "{zero}");
    let [missing] = problems("yam", "safe_action = \"brake\"").try_into().unwrap();
    assert!(missing.starts_with("brake-delay: is not given: 100 ms is assumed"), "{missing}");
    for quiet in ["brake_delay_ms = 100", "brake_delay_ms = 5", "safe_action = \"damped-stop\""] {
        assert_eq!(problems("yam", quiet), [""; 0], "{quiet}");
    }
    assert_eq!(problems("planar2r", "brake_delay_ms = 0"), [""; 0]);
}

fn without_drives(text: &str) -> String {
    let mut inside = false;
    let kept = text.lines().filter(|line| {
        inside = line.starts_with("[joint.drive]") || inside && !line.starts_with("[[");
        !inside
    });
    kept.map(|line| format!("{line}\n")).collect()
}

#[test]
fn one_torque_for_joints_of_very_different_load_is_a_placeholder() {
    let one = changed(
        SOUND,
        &[("effort=\"50\"", "effort=\"30\""), ("effort=\"20\"", "effort=\"30\""), ("effort=\"6\"", "effort=\"30\"")],
    );
    let draft = Draft::from_urdf_str(&one, "arm.urdf", Ends::tip("tip")).unwrap();
    assert_eq!(spoken(&told(&draft, &[14.7, 3.0, 1.4])), [("placeholder", "doubt")]);
    assert_eq!(spoken(&told(&draft, &[14.7, 3.0, 1.5])), []);
    // A joint without a gravity load has nothing to compare, and neither has an arm without loads.
    assert_eq!(spoken(&told(&draft, &[0.0, 3.0, 1.5])), []);
    assert_eq!(spoken(&findings(&draft, None)), []);
}

#[test]
fn an_encoder_with_few_counts_is_found() {
    let counts = |count: &str| {
        let text = changed(
            &without_drives(DRIVEN),
            &[(
                "rotor = { inertia = 1e-4, gear = 20.0 }",
                &format!("rotor = {{ inertia = 1e-4, gear = 20.0 }}\nencoder = {{ counts_per_turn = {count} }}"),
            )],
        );
        spoken(&of_toml(&text))
    };
    assert_eq!(counts("314"), [("position-step", "doubt")]);
    assert_eq!(counts("315"), []);
}

#[test]
fn all_impossible_bodies_are_found_and_everything_that_load_refuses_is_wrong() {
    let broken = changed(
        SOUND,
        &[("izz=\"0.001\"", "izz=\"0.03\""), ("izz=\"0.002\"", "izz=\"0.09\""), ("effort=\"6\"", "effort=\"-6\"")],
    );
    let told = of_urdf(&broken);
    let places: Vec<_> = told
        .iter()
        .filter(|finding| finding.severity == Severity::Wrong)
        .map(|finding| finding.place.field())
        .collect();
    assert_eq!(places, ["link upper.inertial.inertia", "link fore.inertial.inertia", "joint 3 (wrist).limit.effort"]);
    assert!(Robot::from_urdf_str(&broken, "arm.urdf", Ends::tip("tip")).is_err());
    for old in ["mass value=\"2.0\"", "izz=\"0.002\"", "effort=\"50\"", "velocity=\"5\"", "upper=\"2\""] {
        let (key, _) = old.rsplit_once('=').unwrap();
        let text = changed(SOUND, &[(old, &format!("{key}=\"-7\""))]);
        assert!(Robot::from_urdf_str(&text, "arm.urdf", Ends::tip("tip")).is_err(), "{old}");
        assert!(of_urdf(&text).iter().any(|finding| finding.severity == Severity::Wrong), "{old}");
    }
    // A moved link without <inertial> is wrong even with links beyond it.
    let start = SOUND.find("<inertial><origin xyz=\"0 0 0.15\"/>").unwrap();
    let end = start + SOUND[start..].find("</inertial>").unwrap() + "</inertial>".len();
    let bare = format!("{}{}", &SOUND[..start], &SOUND[end..]);
    assert!(Robot::from_urdf_str(&bare, "arm.urdf", Ends::tip("tip")).is_err());
    assert_eq!(spoken(&of_urdf(&bare)), [("mass", "wrong")]);
}

/// A problem that no rule covers is rejected as when the arm is loaded, even after an impossible body.
#[test]
fn a_file_that_no_rule_understands_is_refused() {
    let broken = changed(
        DRIVEN,
        &[
            ("zz = 0.03 }", "zz = 0.3 }"),
            ("dh = { a = 0.3, alpha = 0.0, d = 0.0, theta = 0.0 }", "placement = {}\naxis = [0, 2, 0]"),
        ],
    );
    assert_eq!(Draft::from_toml_str(&broken, "arm.toml").unwrap_err().field(), "joint 2 (bend).axis");
    for (old, new) in [
        ("torque = 40", "torque = 40, torque_rate = -1"),
        ("inertia = 1e-4", "inertia = -1e-4"),
        ("mass = 1.0", "mass = \"1\""),
    ] {
        let broken = changed(DRIVEN, &[(old, new)]);
        let refused = Draft::from_toml_str(&broken, "arm.toml").unwrap_err();
        assert_eq!(refused.to_string(), Robot::from_toml_str(&broken, "arm.toml").unwrap_err().to_string());
    }
}

#[test]
fn an_accepted_body_is_a_doubt_and_its_key_is_quoted() {
    let broken = changed(
        DRIVEN,
        &[
            ("name = \"driven\"", "name = \"driven\"\nallow_unphysical = \"as published\""),
            ("zz = 0.03 }", "zz = 0.3 }"),
        ],
    );
    let told = of_toml(&broken);
    assert_eq!(spoken(&told), [("impossible-body", "doubt")]);
    assert_eq!(told[0].quote.as_deref(), Some("inertia = { xx = 0.002, yy = 0.03, zz = 0.3 }"));
    assert_eq!(told[0].place.line_column(), Some((10, 11)));
    // A mass below zero is never accepted.
    let negative = changed(&broken, &[("mass = 2.0", "mass = -2.0")]);
    assert_eq!(spoken(&of_toml(&negative))[0], ("impossible-body", "wrong"));
    assert!(Draft::from_toml_str(&negative, "arm.toml").unwrap().arm().is_none());
}

#[test]
fn fixed_parts_are_judged_before_they_are_merged() {
    // A camera of 50 g whose tensor is in kg mm^2: in the merged forearm this would go unnoticed.
    let camera = |moment: &str| {
        let text = format!(
            "<link name=\"camera\"><inertial><mass value=\"0.05\"/><inertia ixx=\"{moment}\" ixy=\"0\" ixz=\"0\" iyy=\"{moment}\" \
             iyz=\"0\" izz=\"{moment}\"/></inertial></link><joint name=\"screws\" type=\"fixed\"><parent link=\"fore\"/>\
             <child link=\"camera\"/></joint></robot>"
        );
        of_urdf(&SOUND.replace("</robot>", &text))
    };
    let told = camera("5e-3");
    assert_eq!(spoken(&told), [("gyration", "wrong")]);
    assert_eq!(told[0].place.field(), "link camera.inertial.inertia");
    assert_eq!(spoken(&camera("5e-6")), []);
}

#[test]
fn a_slide_is_as_long_as_its_travel() {
    let slide = |travel: &str| {
        let text = format!(
            "name = \"boom\"\nideal = \"a test\"\n[[joint]]\nname = \"turn\"\ntype = \"revolute\"\nplacement = {{}}\naxis = [0, 1, 0]\nmass = 1\ncom = [0, 0, 0]\n\
             inertia = {{ xx = 4e-5, yy = 4e-5, zz = 4e-5 }}\nlimits = {{ torque = 90, velocity = 1 }}\n[[joint]]\nname = \"boom\"\n\
             type = \"prismatic\"\nplacement = {{}}\naxis = [0, 0, 1]\nmass = 2\ncom = [0, 0, -0.5]\n\
             inertia = {{ xx = 0.17, yy = 0.17, zz = 0.002 }}\nlimits = {{ position = [0.0, {travel}], torque = 90, velocity = 1 }}\n"
        );
        spoken(&findings(&Draft::from_toml_str(&text, "boom.toml").unwrap(), None))
    };
    assert_eq!(slide("1.0"), []);
    assert_eq!(slide("0.1"), [("mass-centre", "wrong")]);
}

/// The joint `lift` is held by 0.4 N m of friction; its limits are -2 and 2 rad.
#[test]
fn a_joint_sinks_from_its_rest_pose_unless_friction_or_a_stop_holds_it() {
    let sinks = |q: f64, held: f64| {
        let text = changed(DRIVEN, &[("name = \"driven\"\n", &format!("name = \"driven\"\nrest = [{q}, 0.0]\n"))]);
        let draft = Draft::from_toml_str(&text, "arm.toml").unwrap();
        let mut loads = DRIVEN_LOADS.map(load);
        loads[0].rest = Some(held);
        let found = findings(&draft, Some(&loads));
        assert!(found.iter().all(|finding| finding.rule == CheckRule::Rest && finding.severity == Severity::Note));
        found.first().map(|finding| {
            assert_eq!(finding.place.line_column().map(|(line, _)| line), Some(3));
            finding.place.problem().to_owned()
        })
    };
    assert_eq!([sinks(0.0, 0.4), sinks(0.0, -0.4)], [None, None], "friction holds");
    assert!(sinks(0.0, 0.41).unwrap().contains("lift sinks from the rest pose: it takes 0.410 N m to hold"));
    // A torque above zero holds against gravity that acts downwards, to the lower limit.
    assert_eq!([sinks(-1.951, 3.0), sinks(1.951, -3.0)], [None, None], "a stop holds");
    assert!(sinks(-1.949, 3.0).is_some() && sinks(1.949, -3.0).is_some());
    assert!(sinks(1.99, 3.0).is_some() && sinks(-1.99, -3.0).is_some(), "the other stop does not");
}

#[test]
fn a_named_actuators_ratings_go_through_the_gear_and_give_way_to_the_file() {
    let robot = |heat: &str, gear: f64| {
        let text = format!(
            "name = \"one\"\n[[joint]]\nname = \"swing\"\ntype = \"revolute\"\ndh = {{ a = 0.5, alpha = 0.0, d = 0.0, theta = 0.0 }}\n\
             mass = 1.0\ncom = [-0.25, 0.0, 0.0]\nlimits = {{ position = [-1.5, 1.5], velocity = 2.0, torque = 20.0 }}\n{heat}\n\
             [joint.drive]\nkind = \"robstride\"\nactuator = \"RS06\"\nbus = 1\nid = 1\ngear = {gear:?}\ndirection = -1\ndamping = 1.0\n"
        );
        Robot::from_toml_str(&text, "one.toml").map(|robot| robot.joints[0].heat)
    };
    let heat = robot("", 2.0).unwrap();
    assert_eq!((heat.rated, heat.peak, heat.time_constant), (Some(16.0), Some(72.0), None));
    assert_eq!(heat.rules(0.1), None, "no time constant is made up");
    let heat = robot("heat = { rated = 8.0, time_constant = 50 }", 1.0).unwrap();
    assert_eq!((heat.rated, heat.peak, heat.time_constant), (Some(8.0), Some(36.0), Some(50.0)));
    assert_eq!(heat.rules(0.1).unwrap().per_rated.to_bits(), (1.0_f64 / 8.0).to_bits());
    let problem = robot("heat = { rated = 40.0 }", 1.0).unwrap_err();
    assert!(problem.problem().contains("exchanged?"), "{problem}");
}

/// The question about grams, by link.
fn asked_about_grams(draft: &Draft) -> Vec<String> {
    let found = findings(draft, None).into_iter().filter(|finding| finding.rule == CheckRule::Unit);
    found.map(|finding| finding.place.to_string()).filter(|text| text.contains("is it in grams?")).collect()
}

#[test]
fn a_mass_in_grams_is_asked_about_with_its_line_and_link() {
    let grams = changed(SOUND, &[("<mass value=\"1.0\"/>", "<mass value=\"900\"/>")]);
    let draft = |text: &str| Draft::from_urdf_str(text, "arm.urdf", Ends::tip("tip")).unwrap();
    let line = 1 + grams.lines().position(|line| line.contains("900")).unwrap();
    let asked = asked_about_grams(&draft(&grams));
    let (place, text) = asked.first().unwrap().split_once(": ").unwrap();
    assert!(place.starts_with(&format!("arm.urdf:{line}:")), "{asked:?}");
    assert_eq!(text, "link fore.inertial.mass: 900 kg on an arm of 1.00 m: is it in grams? Then it is 0.900 kg");
    assert_eq!(asked.len(), 1, "{asked:?}");
    // All links in grams: each is asked about. In pounds, one link explains it too.
    let all = changed(&grams, &[("value=\"2.0\"", "value=\"2000\""), ("value=\"0.4\"", "value=\"400\"")]);
    assert_eq!(asked_about_grams(&draft(&all)).len(), 3);
    let pounds = asked_about_grams(&draft(&changed(&grams, &[("900", "400")])));
    assert!(pounds[0].ends_with("; in pounds, 181 kg"), "{pounds:?}");
    // The arm measures 1 m: 300 kg are allowed, of which the other links have 2.4 kg.
    assert_eq!(asked_about_grams(&draft(&changed(&grams, &[("900", "298")]))).len(), 1);
    assert_eq!(asked_about_grams(&draft(&changed(&grams, &[("900", "297")]))), [""; 0]);
}

#[test]
fn no_shipped_robot_is_asked_about_grams() {
    let folders = ["robots", "robots/examples", "robots/chapter12"].map(crate::common::top);
    let files = folders.iter().flat_map(|folder| crate::common::files(folder, &["toml"]));
    // The folder of the chapter also has closed loops, which are no arms.
    let arms: Vec<_> = files.filter_map(|file| Draft::load_between(&file, Ends::default()).ok()).collect();
    assert!(arms.len() >= 30, "{}", arms.len());
    for draft in arms {
        assert_eq!(asked_about_grams(&draft), [""; 0], "{}", draft.robot.name);
    }
}
