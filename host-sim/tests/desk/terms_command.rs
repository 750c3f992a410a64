//! `newtau model terms` as used by a person or a script.

use crate::program;
use crate::program::at_the_top;
use crate::reference::relative;
use serde_json::Value;
use std::process::{Output, Stdio};

const PUMA: &str = "robots/puma560.toml";
const PICK: &str = "scenes/puma560_pick.toml";
const Q: &str = "0.4,-0.5,-1.2,0.7,-0.9,2.5";
const QD: &str = "1,-2,0.5,3,-1.5,0.8";

fn terms(arguments: &[&str]) -> Output {
    at_the_top().args(["model", "terms"]).args(arguments).output().unwrap()
}

fn printed(arguments: &[&str]) -> String {
    program::printed(terms(arguments))
}

fn json(arguments: &[&str]) -> Value {
    let mut all = arguments.to_vec();
    all.push("--json");
    serde_json::from_str(&printed(&all)).unwrap()
}

/// All numbers of nested lists, in order.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(flat).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

/// The program's message when it rejects its input.
fn refusal(arguments: &[&str]) -> String {
    let output = terms(arguments);
    assert_eq!((output.status.code(), output.stdout), (Some(2), vec![]));
    String::from_utf8(output.stderr).unwrap()
}

const TERMS: [&str; 5] = ["mass_matrix", "coriolis_matrix", "velocity_coupling", "gravity", "christoffel"];

#[test]
fn the_methods_agree() {
    let of = |method| json(&[PUMA, "--q", Q, "--qd", QD, "--scene", PICK, "--method", method]);
    let lagrange = of("lagrange");
    for method in ["trace", "recursive"] {
        let other = of(method);
        assert_eq!(other["method"], method);
        for term in TERMS {
            let off = relative(&flat(&other[term]), &flat(&lagrange[term]));
            println!("{method} {term}: {off:.2e}");
            assert!(off < 1e-14, "{method} {term}: {off:e}");
        }
    }
    assert_eq!(flat(&lagrange["christoffel"]).len(), 216);
}

#[test]
fn the_terms_are_those_of_dynamics() {
    let found = json(&[PUMA, "--q", Q, "--qd", QD]);
    let question = format!("{{\"q\":[{Q}],\"qd\":[{QD}]}}");
    let mut child = at_the_top()
        .args(["model", "dynamics", PUMA, "--input", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), question.as_bytes()).unwrap();
    let wanted: Value = serde_json::from_slice(&child.wait_with_output().unwrap().stdout).unwrap();
    for (term, same) in [("mass_matrix", "mass_matrix"), ("velocity_coupling", "coriolis_qd"), ("gravity", "gravity")] {
        let off = relative(&flat(&found[term]), &flat(&wanted[same]));
        assert!(off < 1e-14, "{term}: {off:e}");
    }
    // Without its rotors the matrix is smaller by gear^2 inertia on its diagonal only.
    let bare = flat(&json(&[PUMA, "--q", Q, "--rotor", "absent"])["mass_matrix"]);
    let all = flat(&found["mass_matrix"]);
    for (i, (all, bare)) in all.iter().zip(&bare).enumerate() {
        assert_eq!(all > bare, i % 7 == 0, "entry {i}");
    }
    assert!((all[0] - bare[0] - 62.6111_f64.powi(2) * 2e-4).abs() < 1e-14);
}

/// Slender rods: `D12 - D22 = m2 l1 l2 cos(q2) / 2` and `Gamma^1_12 = -m2 l1 l2 sin(q2) / 2`.
#[test]
fn two_rods_have_their_closed_forms() {
    let rods = json(&["robots/planar2r.toml", "--q", "0.3,0.7", "--qd", "1,-2", "--gravity", "0,0,-9.81"]);
    let coupling = 0.5 * 1.5 * 1.0 * 0.8;
    let d = flat(&rods["mass_matrix"]);
    assert!((d[1] - d[3] - coupling * 0.7_f64.cos()).abs() < 1e-15, "{d:?}");
    let symbols = flat(&rods["christoffel"]);
    let bend = -coupling * 0.7_f64.sin();
    assert!(relative(&symbols, &[0.0, bend, bend, bend, -bend, 0.0, 0.0, 0.0]) < 1e-14, "{symbols:?}");
    // Gravity perpendicular to the plane has no effect.
    assert!(flat(&rods["gravity"]).iter().all(|torque| torque.abs() < 1e-14));
}

#[test]
fn a_scene_brings_its_gravity_and_payload() {
    let weight = |more: &[&str]| flat(&json(&[&[PUMA, "--q", Q], more].concat())["gravity"]);
    let (empty, held) = (weight(&[]), weight(&["--scene", PICK]));
    assert!(relative(&held, &empty) > 0.01, "{held:?}");
    let afloat = weight(&["--scene", PICK, "--gravity", "0,0,0"]);
    assert!(afloat.iter().all(|torque| torque.abs() < 1e-300), "{afloat:?}");
}

#[test]
fn tables_show_every_term_and_joint() {
    let text = printed(&["robots/scara.toml", "--q", "0.1,0.2,0.05,0"]);
    assert!(text.contains(", by the method lagrange; g = (0, 0, -9.81) m/s^2\n"), "{text}");
    assert!(
        text.contains("H = C qd") && text.contains("Inertia matrix D:") && text.contains("C, with dD/dt - 2 C skew")
    );
    assert_eq!(text.matches("Christoffel symbols of joint").count(), 4, "{text}");
    assert!(text.contains(" N ") && text.contains(" N m "), "{text}");
    assert!(!text.contains("-0.000000"), "{text}");
    let help = program::printed(at_the_top().args(["help", "model", "terms"]).output().unwrap());
    for equation in ["12.217", "12.229", "12.238", "12.239", "12.281", "12.393", "12.394", "12.395", "12.157-12.162"] {
        assert!(help.contains(equation), "{equation}");
    }
}

#[test]
fn what_cannot_be_is_named() {
    let cases: [(&[&str], &str); 9] = [
        (&[PUMA], "--q <Q1,Q2,..>"),
        (&[PUMA, "--q", "0,0"], "`q` has 2 numbers; expected 6 numbers: one for each joint"),
        (&[PUMA, "--q", Q, "--qd", "1"], "`qd` has 1 number; expected 6 numbers: one for each joint"),
        (&[PUMA, "--q", Q, "--gravity", "0,-9.81"], "`gravity` has 2 numbers; expected 3 numbers: gx, gy, gz"),
        (&[PUMA, "--q", "0,0,0,0,nan,0"], "entry 5 of `q` is NaN; expected a finite number"),
        (&[PUMA, "--q", "0,x,0"], "invalid value 'x' for '--q"),
        (
            &[PUMA, "--q", "0,-1,0,0,0,0"],
            "joint 2 (shoulder): a position of -1 rad is below its limit of -0.7853981633974483 rad",
        ),
        (&["robots/scara.toml", "--q", "0,0,0,9"], "joint 4 (quill): a position of 9 m is above its limit of 0.85 m"),
        (&["robots/ur5.toml", "--q", Q, "--scene", PICK], "is a scene of another robot"),
    ];
    for (arguments, expected) in cases {
        let said = refusal(arguments);
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    // Only an overflow is an error: the program prints a message, and no infinity.
    let said = refusal(&[PUMA, "--q", Q, "--qd", "1e200,1e200,1e200,1e200,1e200,1e200"]);
    assert!(said.contains("the numbers are too large"), "{said}");
}
