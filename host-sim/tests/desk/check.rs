//! Would a physicist believe a robot file: the command, and the loads behind it.

use crate::program::{at_its_fixtures, told};
use host_sim::study::check::{Answer, answer};
use robot_compiler::Ends;
use robot_compiler::check::{Draft, Severity};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const TRAPS: &str = "tests/fixtures/traps.urdf";

fn check(arguments: &[&str]) -> (i32, String, String) {
    told(at_its_fixtures().arg("check").args(arguments).output().unwrap())
}

fn looked_at(path: &Path, gravity: [f64; 3]) -> Answer {
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
    insta::assert_snapshot!(out);
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
    // Under gravity of a giant it falls.
    let (code, out, _) = check(&["tests/fixtures/planar.toml", "--gravity", "0,-9810,0"]);
    assert!(code == 3 && out.contains("it falls"), "{out}");
    for bad in [&["tests/fixtures/nowhere.toml"][..], &[TRAPS, "--tip", "gripr"], &[TRAPS, "--gravity", "0,1"]] {
        let (code, out, error) = check(bad);
        assert_eq!((code, out.as_str()), (2, ""), "{bad:?}");
        assert!(!error.is_empty());
    }
}

/// Two rods in a vertical plane: the loads by hand.
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
    }
    insta::assert_snapshot!(told);
}

/// Advice says that a rotor often has as much as the link: of the Puma 560, measured by others, it has.
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
