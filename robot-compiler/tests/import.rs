//! Errors of a robot file are found and their causes guessed; missing values are kept as gaps and marked.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]

use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use nalgebra::Vector3;
use proptest::prelude::*;
use robot_compiler::check::{CheckRule, Draft, Finding, JointLoad, findings, scene_findings};
use robot_compiler::emit::{robot_file, urdf};
use robot_compiler::{Ends, Robot, UrdfArm};
use std::path::{Path, PathBuf};

/// Rules with test cases in this file.
pub(crate) const RULES: [CheckRule; 8] = [
    CheckRule::Unit,
    CheckRule::Angle,
    CheckRule::SwappedAxes,
    CheckRule::UnknownName,
    CheckRule::HeldJoint,
    CheckRule::OpenQuestion,
    CheckRule::Gravity,
    CheckRule::Payload,
];

/// A crane of three joints. For `Q`, `QD`, `QDD` Pinocchio 4.1 gives [`TORQUES`] without friction.
const CRANE: &str = include_str!("data/crane.urdf");
const Q: [f64; 3] = [0.3, 0.7, -0.9];
const QD: [f64; 3] = [0.5, -0.4, 0.8];
const QDD: [f64; 3] = [1.0, -2.0, 3.0];
const TORQUES: [f64; 3] = [0.222904, 4.523999, 0.930380];

const FINGERS: &str = r#"<link name="fl"><inertial><mass value="1.0"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="fj" type="prismatic"><parent link="hand"/><child link="fl"/><axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="10" velocity="0.1"/></joint>
  <link name="fr"><inertial><mass value="1.0"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="fk" type="prismatic"><parent link="hand"/><child link="fr"/><axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="10" velocity="0.1"/><mimic joint="fj" multiplier="1" offset="0.2"/></joint>
</robot>"#;

fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    })
}

fn loads() -> Vec<JointLoad> {
    let load = |holding, most| JointLoad { holding, posture: vec![0.0; 3], inertia: (0.01, most), rest: None };
    vec![load(0.0, 0.4), load(9.0, 0.4), load(1.0, 0.05)]
}

fn looked_at(text: &str) -> Vec<Finding> {
    findings(&Draft::from_urdf_str(text, "crane.urdf", Ends::tip("hand")).unwrap(), Some(&loads()))
}

/// Rule and problem of the findings that are more than a note.
fn doubts(found: &[Finding]) -> Vec<String> {
    let doubts = found.iter().filter(|finding| finding.severity.name() != "note");
    doubts.map(|it| format!("{}: {}; {}", it.rule.name(), it.place.problem(), it.place.expected())).collect()
}

fn import(text: &str, ends: Ends<'_>) -> String {
    robot_file(&UrdfArm::from_urdf_str(text, "crane.urdf", ends).unwrap())
}

fn gravity_torques(robot: &Robot, q: &[f64; 3]) -> [f64; 3] {
    torques(robot, q, &[0.0; 3], &[0.0; 3])
}

fn torques(robot: &Robot, q: &[f64; 3], qd: &[f64; 3], qdd: &[f64; 3]) -> [f64; 3] {
    let model = robot.model::<3>().unwrap();
    let dynamics = Dynamics::new(model, Scene::with_gravity(robot.gravity(), &model));
    dynamics.inverse_dynamics(&Libm.sin_cos_all(q), q, qd, qdd, &Live::zero())
}

/// Texts of a file, each with its replacement.
type Changes<'a> = &'a [(&'a str, &'a str)];

#[test]
fn the_crane_has_the_torques_of_pinocchio_and_no_doubts() {
    let robot = Robot::from_urdf_str(CRANE, "crane.urdf", Ends::default()).unwrap();
    for (found, known) in torques(&robot, &Q, &QD, &QDD).into_iter().zip(TORQUES) {
        assert!((found - known).abs() < 1e-6, "{found} {known}");
    }
    assert_eq!(doubts(&looked_at(CRANE)), [""; 0]);
    let text = import(CRANE, Ends::default());
    assert_eq!(doubts(&findings(&Draft::from_toml_str(&text, "crane.toml").unwrap(), Some(&loads()))), [""; 0]);
}

#[test]
fn the_likely_cause_of_a_wrong_number_is_named() {
    let lengths =
        [("xyz=\"0.3 0 0\"", "xyz=\"300 0 0\""), ("xyz=\"0.25 0 0\"", "xyz=\"250 0 0\""), ("0.03 0 0.1", "30 0 100")];
    let all_mm = [
        &lengths[..],
        &[("0.14 0.0 0.015", "140 0 15"), ("0.11 0.004 0.0", "110 4 0"), ("0.01 -0.02 0.06", "10 -20 60")],
    ]
    .concat();
    let tensor = "ixx=\"0.0021\" iyy=\"0.0162\" izz=\"0.0165\" ixy=\"0\" ixz=\"0.0001\"";
    let cases: [(Changes<'_>, &str, &str); 17] = [
        (&all_mm, "unit", "is this file in mm? Then the arm is 0."),
        (&[("0.14 0.0 0.015", "140 0 15")], "mass-centre", "in mm? Then it is 0.141 m"),
        (&[("0.14 0.0 0.015", "14 0 1.5")], "mass-centre", "in cm? Then it is 0.138 m"),
        (&[(tensor, "ixx=\"2.1e6\" iyy=\"16.2e6\" izz=\"16.5e6\" ixy=\"0\" ixz=\"1e5\"")], "gyration", "in g mm^2?"),
        (&[(tensor, "ixx=\"21\" iyy=\"162\" izz=\"165\" ixy=\"0\" ixz=\"1\"")], "gyration", "in kg cm^2?"),
        (&[("value=\"1.7\"", "value=\"1700\"")], "unit", "is it in grams? Then it is 1.70 kg"),
        (&[("1.5707963267948966", "90")], "angle", "degrees? 90.0 degrees are 1.57 rad"),
        (&[("rpy=\"0 0.4 0\"", "rpy=\"0 23 0\"")], "angle", "degrees?"),
        (&[("lower=\"-2.8\" upper=\"2.8\"", "lower=\"-160\" upper=\"160\"")], "angle", "degrees?"),
        (&[("velocity=\"2.5\"", "velocity=\"143\"")], "wide-limit", "degrees a second (2.50 rad/s)?"),
        (&[("effort=\"18\"", "effort=\"18000\"")], "unit", "in N mm? Then it is 18.0 N m"),
        (
            &[("<origin xyz=\"0.3 0 0\" rpy=\"0 0 0\"/>", "<orgin xyz=\"0.3 0 0\"/>")],
            "unknown-name",
            "did you mean `origin`?",
        ),
        (&[("xyz=\"0.3 0 0\"", "pos=\"0.3 0 0\"")], "unknown-name", "did you mean `xyz`?"),
        (&[("damping", "dampening")], "unknown-name", "did you mean `damping`?"),
        (
            &[(tensor, "ixx=\"0.0162\" iyy=\"0.0021\" izz=\"0.0165\" ixy=\"0\" ixz=\"0.0001\"")],
            "swapped-axes",
            "a rod along y, and the link lies along x",
        ),
        (
            &[
                ("xyz=\"0.11 0.004 0.0\" rpy=\"0 0.4 0\"", "xyz=\"0.15 0 0\""),
                ("value=\"0.9\"", "value=\"2.0\""),
                (
                    "ixx=\"0.0008\" iyy=\"0.0054\" izz=\"0.0055\" ixy=\"0.0\" ixz=\"0.0\" iyz=\"0.0001\"",
                    "ixx=\"8.33e-4\" iyy=\"8.33e-4\" izz=\"8.33e-4\" ixy=\"0\" ixz=\"0\" iyz=\"0\"",
                ),
            ],
            "gyration",
            "parallel-axis",
        ),
        (
            &[(
                "ixx=\"0.0008\" iyy=\"0.0054\" izz=\"0.0055\" ixy=\"0.0\" ixz=\"0.0\" iyz=\"0.0001\"",
                "ixx=\"3e-19\" iyy=\"1e-19\" izz=\"1e-19\" ixy=\"1e-18\" ixz=\"0\" iyz=\"0\"",
            )],
            "gyration",
            "a point mass",
        ),
    ];
    for (changes, rule, cause) in cases {
        let found = doubts(&looked_at(&changed(CRANE, changes)));
        assert!(found.iter().any(|it| it.starts_with(rule) && it.contains(cause)), "{changes:?}: {found:#?}");
        let longest = found.iter().flat_map(|it| it.split(|c: char| !c.is_ascii_digit())).map(str::len).max();
        assert!(longest.is_some_and(|digits| digits <= 6), "{found:#?}");
    }
    // With lengths in mm there is no advice about actuators and point masses.
    let found = doubts(&looked_at(&changed(CRANE, &all_mm)));
    assert!(found.iter().all(|it| !it.contains("actuator") && !it.contains("nearly a point")), "{found:#?}");
    // The file with the misspelt name is rejected by everything that computes with it.
    let typo = changed(CRANE, &[("<origin xyz=\"0.3 0 0\" rpy=\"0 0 0\"/>", "<orgin xyz=\"0.3 0 0\"/>")]);
    let error = Robot::from_urdf_str(&typo, "crane.urdf", Ends::default()).unwrap_err();
    assert!(error.to_string().contains("44") && error.problem().contains("unknown element `orgin`"), "{error}");
    assert!(import(&typo, Ends::default()).contains("# ? joint bend.orgin: unknown element `orgin`"));
}

#[test]
fn the_same_holds_of_a_robot_file() {
    let good = changed(
        &import(CRANE, Ends::default()),
        &[("# ? rotor = { inertia = , gear = }", "rotor = { inertia = 1e-5, gear = 50 }")],
    );
    let look = |text: &str| findings(&Draft::from_toml_str(text, "crane.toml").unwrap(), Some(&loads()));
    assert_eq!(doubts(&look(&good)), [""; 0]);
    let one = |old: &str, new: &str| doubts(&look(&good.replacen(old, new, 1))).join("\n");
    assert!(
        one("inertia = 1e-5, gear = 50", "inertia = 135, gear = 100")
            .contains("in g cm^2? Then the joint feels 0.135 kg m^2")
    );
    let row = "placement = { xyz = [0.3, 0.0, 0.0] }\naxis = [0.0, 0.0, 1.0]";
    let found = one(row, "dh = { a = 0.3, alpha = 90, d = 0, theta = 0 }");
    assert!(found.contains("angle: an angle of 90.0 rad") && found.contains("degrees?"), "{found}");
    assert!(!one(row, "dh = { a = 0.3, alpha = 1.57, d = 0, theta = 0 }").contains("angle"));
}

#[test]
fn a_gap_is_imported_and_stays_a_finding_until_it_is_filled_or_ideal() {
    let bare = {
        let mut text = CRANE.to_owned();
        while let (Some(start), Some(end)) = (text.find("<inertial>"), text.find("</inertial>")) {
            text.replace_range(start..end + "</inertial>".len(), "");
        }
        text
    };
    let toml = import(&bare, Ends::default());
    assert_eq!(toml.matches("mass = 0.0 # ? the link ").count(), 3, "{toml}");
    assert!(Robot::from_toml_str(&toml, "bare.toml").is_ok(), "identify starts from geometry alone");
    assert!(
        Robot::from_urdf_str(&bare, "bare.urdf", Ends::default()).unwrap_err().expected().contains("newtau import")
    );

    let zero = changed(
        CRANE,
        &[("effort=\"40\" velocity=\"2.5\"", "effort=\"0\" velocity=\"0\""), ("lower=\"-2.4\" upper=\"2.4\" ", "")],
    );
    let toml = import(&zero, Ends::default());
    assert_eq!(
        toml.matches("velocity (velocity is 0, a placeholder), torque (effort is 0, a placeholder)").count(),
        2,
        "{toml}"
    );
    assert!(toml.contains("position (lower and upper are both missing)"), "{toml}");
    let notes = |text: &str| {
        let found = findings(&Draft::from_toml_str(text, "crane.toml").unwrap(), Some(&loads()));
        found.iter().map(|it| format!("{}: {}", it.rule.name(), it.place.problem())).collect::<Vec<_>>()
    };
    let (found, of_urdf) = (notes(&toml), looked_at(&zero));
    for gap in
        ["no position limits on bend", "no limit on turn and lift", "no rotor inertia beside that of the links: turn"]
    {
        assert!(found.iter().any(|it| it.contains(gap)), "{gap}: {found:#?}");
        assert!(of_urdf.iter().any(|it| it.place.problem().contains(gap)), "{gap}: {of_urdf:#?}");
    }
    let ideal = toml.replace("# ? rotor = { inertia = , gear = }", "rotor = { inertia = 0, gear = 1 }");
    assert!(!notes(&ideal).iter().any(|it| it.starts_with("rotor")));
    assert!(
        !notes(&toml.replacen("source =", "ideal = \"a test\"\nsource =", 1))
            .iter()
            .any(|it| it.contains("limit") || it.contains("rotor"))
    );
}

#[test]
fn a_reduction_of_a_transmission_is_in_the_gap_of_the_rotor() {
    let ros1 = "<transmission name=\"t1\"><joint name=\"turn\"/><actuator name=\"a\"><mechanicalReduction>120</mechanicalReduction></actuator></transmission></robot>";
    let ros2 = "<ros2_control name=\"x\"><transmission name=\"t2\"><joint name=\"turn\"><mechanical_reduction>-81</mechanical_reduction></joint></transmission></ros2_control></robot>";
    for (text, gear) in [(ros1, "gear = 120.0 }"), (ros2, "gear = -81.0 }")] {
        let toml = import(&CRANE.replace("</robot>", text), Ends::default());
        assert_eq!(
            toml.lines().filter(|line| line.starts_with("# ? rotor") && line.contains(gear)).count(),
            1,
            "{toml}"
        );
    }
}

#[test]
fn a_follower_is_held_at_its_offset() {
    let text = CRANE.replace("</robot>", FINGERS);
    let robot = Robot::from_urdf_str(&text, "crane.urdf", Ends::tip("hand")).unwrap();
    assert!((gravity_torques(&robot, &[0.0; 3])[2] - 7.838).abs() < 1e-3, "{:?}", gravity_torques(&robot, &[0.0; 3]));
    assert!(robot.source.contains("held at zero: fj; held: fk at 0.2"), "{}", robot.source);
    assert!(looked_at(&text).iter().all(|it| it.rule != CheckRule::HeldJoint));
    let outside = text.replacen("lower=\"0\" upper=\"0.3\"", "lower=\"0.01\" upper=\"0.3\"", 1);
    assert!(
        doubts(&looked_at(&outside))
            .iter()
            .any(|it| it.contains("fj is held at 0 m, outside its own limits 0.01 to 0.3 m"))
    );
    let toml = import(&outside, Ends::tip("hand"));
    assert!(toml.contains("# ? joint fj.limit: fj is held at 0 m"), "{toml}");
    let open = findings(&Draft::from_toml_str(&toml, "crane.toml").unwrap(), None);
    assert!(open.iter().any(|it| it.rule == CheckRule::OpenQuestion && it.place.problem().contains("fj is held")));
    let looped = text.replacen("velocity=\"0.1\"/></joint>", "velocity=\"0.1\"/><mimic joint=\"fk\"/></joint>", 1);
    let error = Robot::from_urdf_str(&looped, "crane.urdf", Ends::tip("hand")).unwrap_err();
    assert!(error.problem().contains("in a loop"), "{error}");
}

#[test]
fn a_base_that_is_turned_turns_gravity_and_goes_into_the_robot_file() {
    let bolt = "<link name=\"world\"/><joint name=\"bolt\" type=\"fixed\"><parent link=\"world\"/><child link=\"pedestal\"/><origin rpy=\"-1.5708 0 0\"/></joint><link name=\"pedestal\"/>";
    let text = changed(CRANE, &[("<link name=\"pedestal\"/>", bolt)]);
    let ends = Ends { base: Some("pedestal"), tip: None };
    let robot = Robot::from_urdf_str(&text, "side.urdf", ends).unwrap();
    assert!((robot.gravity() - Vector3::new(0.0, 9.81, 0.0)).amax() < 1e-4, "{}", robot.gravity());
    assert!((gravity_torques(&robot, &Q)[0] + 5.726).abs() < 1e-3, "{:?}", gravity_torques(&robot, &Q));
    assert!(robot.mounting_note().contains("90.0 degrees off upright"), "{}", robot.mounting_note());
    let toml = import(&text, ends);
    assert!(toml.contains("mounting = { rpy = [-1.5708, 0.0, 0.0] }"), "{toml}");
    let read = Robot::from_toml_str(&toml, "side.toml").unwrap();
    assert_eq!(read.mounting, robot.mounting);
    // Starting from the root, the same arm is mounted with a turned placement.
    let whole = Robot::from_urdf_str(&text, "side.urdf", Ends::default()).unwrap();
    assert!(whole.mounting.is_none());
    // An export is turned like the arm.
    let again = Robot::from_urdf_str(&urdf(&robot), "again.urdf", Ends::default()).unwrap();
    for other in [&whole, &again, &read] {
        for (found, known) in gravity_torques(other, &Q).into_iter().zip(gravity_torques(&robot, &Q)) {
            assert!((found - known).abs() < 1e-12, "{found} {known}");
        }
    }
    // Upright, and turned about the vertical: no remark.
    let yawed = text.replace("rpy=\"-1.5708 0 0\"", "rpy=\"0 0 1.2\"");
    assert!(Robot::from_urdf_str(&yawed, "side.urdf", ends).unwrap().mounting.is_none());
}

#[test]
fn a_floating_base_is_refused_with_the_link_to_begin_at() {
    let float = "<link name=\"map\"/><joint name=\"root_j\" type=\"floating\"><parent link=\"map\"/><child link=\"pedestal\"/></joint><link name=\"pedestal\"/>";
    let text = changed(CRANE, &[("<link name=\"pedestal\"/>", float)]);
    let error = Robot::from_urdf_str(&text, "float.urdf", Ends::default()).unwrap_err();
    assert!(error.expected().contains("`--base pedestal`"), "{}", error.expected());
    let toml = import(&text, Ends { base: Some("pedestal"), tip: None });
    assert!(toml.contains("# ? joint root_j: the base pedestal can move"), "{toml}");
}

/// A file of this test, in the folder for temporary files.
fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn encodings_are_read_and_other_files_named_for_what_they_are() {
    let units = |text: &str| text.encode_utf16().collect::<Vec<u16>>();
    let little: Vec<u8> = units(&format!("\u{feff}{CRANE}")).into_iter().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = units(CRANE).into_iter().flat_map(u16::to_be_bytes).collect();
    let latin: Vec<u8> = CRANE.replace("crane3", "gr\u{f6}\u{df}e").chars().map(|c| c as u8).collect();
    for (name, bytes) in
        [("arm.URDF", CRANE.as_bytes()), ("little.urdf", &little), ("big.urdf", &big), ("latin.urdf", &latin)]
    {
        let robot = Robot::load(&written(name, bytes)).unwrap();
        assert_eq!(robot.dof(), 3, "{name}");
    }
    assert_eq!(Robot::load(&written("latin.urdf", &latin)).unwrap().name, "gr\u{f6}\u{df}e");
    for (name, text, what) in [
        ("page.urdf", "\n<!DOCTYPE html><html></html>", "an HTML page"),
        ("pointer.urdf", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a Git LFS pointer"),
        ("pointer.toml", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a Git LFS pointer"),
        ("archive.urdf", "PK\u{3}\u{4}", "a ZIP archive"),
        ("model.urdf", "<sdf version='1.6'/>", "the outermost element is <sdf>"),
    ] {
        let error = Robot::load(&written(name, text.as_bytes())).unwrap_err();
        assert!(error.problem().contains(what), "{name}: {error}");
    }
    let error = Robot::load(&written("latin.toml", b"# gr\xf6\xdfe\nname = \"x\"\n")).unwrap_err();
    assert!(error.problem().contains("saved as Latin-1"), "{error}");
}

#[test]
fn gravity_and_payloads_that_cannot_be_are_doubted() {
    let found = |lines: &str| {
        let found = scene_findings(&crate::common::standing("planar2r", lines));
        found.iter().map(|it| format!("{}: {}", it.rule.name(), it.place.problem())).collect::<Vec<_>>().join("; ")
    };
    for (gravity, cause) in
        [("[0, 0, -981]", "in cm/s^2?"), ("[0, 0, -1]", "in units of g?"), ("[0, 0, -9810]", "in mm/s^2?")]
    {
        let found = found(&format!("[model]\ngravity = {gravity}\n"));
        assert!(found.starts_with("gravity: ") && found.contains(cause), "{found}");
    }
    let far = found("[model]\npayload = { mass = 1.0, com = [0, 0, 80] }\n");
    assert!(far.starts_with("payload: ") && far.contains("in mm?"), "{far}");
    for good in [
        "gravity = [0, -9.81, 0]",
        "gravity = [0, 0, 9.81]",
        "gravity = [0, 0, 0]",
        "payload = { mass = 1.0, com = [0, 0, 0.1] }",
    ] {
        assert_eq!(found(&format!("[model]\n{good}\n")), "", "{good}");
    }
}

/// Parts that a URDF may lack, each with the resulting entry in the robot file.
const PARTS: [(&str, &str, &str); 9] = [
    ("<mass value=\"2.4\"/>", "", "link column has no <mass>"),
    ("<mass value=\"1.7\"/>", "<mass value=\"\"/>", "the mass of link boom has no value"),
    ("iyy=\"0.0054\" ", "", "the inertia of link stick lacks iyy"),
    ("<limit lower=\"-2.8\" upper=\"2.8\" effort=\"40\" velocity=\"2.5\"/>", "", "# ? position (no <limit>)"),
    ("lower=\"-1.0\" upper=\"2.2\" effort=\"40\"", "effort=\"0\"", "torque (effort is 0, a placeholder)"),
    ("lower=\"-2.4\" ", "", "position (no lower, 0 is taken)"),
    ("effort=\"18\" ", "", "torque (no effort)"),
    ("velocity=\"3.0\"", "", "velocity (no velocity)"),
    ("<dynamics damping=\"0.3\" friction=\"0.2\"/>", "", "# ? friction = "),
];

proptest! {
    #[test]
    fn an_import_of_random_gaps_never_stops_and_marks_each(gaps in prop::collection::vec(any::<bool>(), PARTS.len())) {
        let there = || PARTS.iter().zip(&gaps).filter(|(_, gap)| **gap);
        let text = there().fold(CRANE.to_owned(), |text, ((part, instead, _), _)| text.replace(part, instead));
        let arm = UrdfArm::from_urdf_str(&text, "gaps.urdf", Ends::default()).unwrap();
        let toml = robot_file(&arm);
        for ((_, _, mark), _) in there() {
            prop_assert!(toml.lines().any(|line| line.contains("# ?") && line.contains(mark)), "{mark}: {toml}");
        }
        let marks = toml.lines().filter(|line| line.contains("# ?") && !line.starts_with("# Every gap")).count();
        // Without gaps only a rotor for each joint is marked.
        prop_assert!(gaps.contains(&true) || marks == 3, "{toml}");
        let draft = Draft::from_toml_str(&toml, "gaps.toml").unwrap();
        prop_assert!(findings(&draft, None).len() >= usize::from(gaps.contains(&true)));
    }
}
