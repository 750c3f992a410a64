//! `newtau model kernel` as used by a person or a script.

use crate::program;
use crate::program::at_the_top;
use serde_json::Value;
use std::process::Output;

const PUMA: &str = "robots/puma560.toml";
const PICK: &str = "scenes/puma560_pick.toml";

/// Runs the command in the project's root folder.
fn kernel(arguments: &[&str]) -> Output {
    at_the_top().args(["model", "kernel"]).args(arguments).output().unwrap()
}

fn printed(arguments: &[&str]) -> String {
    program::printed(kernel(arguments))
}

fn counts(arguments: &[&str]) -> Vec<Value> {
    let mut all = arguments.to_vec();
    all.push("--json");
    serde_json::from_str(&printed(&all)).unwrap()
}

#[test]
fn source_is_that_of_robot_scene_level_function_and_scalar() {
    let text = printed(&[PUMA, "--scene", PICK]);
    assert!(
        text.starts_with("//! Inverse dynamics of Puma 560 in the scene puma560_pick: level exact, f32.\n"),
        "{text}"
    );
    assert!(text.contains("impl InverseDynamics<f32, 6> for Kernel {"), "{text}");
    let text = printed(&[PUMA, "--level", "regrouped", "--function", "mass-matrix", "--scalar", "f64"]);
    assert!(text.starts_with("//! Mass matrix of Puma 560 in the scene Puma 560: level regrouped, f64.\n"), "{text}");
    assert!(text.contains("pub fn mass_matrix(turn: &[SinCos<f64>; 6]) -> [f64; 21] {"), "{text}");
}

#[test]
fn the_core_s_example_is_the_kernel_that_is_printed() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../dynamics-core/examples/kernel/planar2r.rs");
    assert_eq!(printed(&["robots/planar2r.toml"]), std::fs::read_to_string(example).unwrap());
}

#[test]
fn json_has_every_level_and_function_and_the_counts_of_the_source() {
    let all = counts(&[PUMA]);
    let kinds: Vec<_> = all.iter().map(|c| (c["function"].as_str().unwrap(), c["level"].as_str().unwrap())).collect();
    assert_eq!(kinds.len(), 18);
    assert_eq!(kinds[..2], [("inverse-dynamics", "exact"), ("inverse-dynamics", "regrouped")]);
    assert_eq!(
        kinds[15..],
        [("regressor", "regrouped"), ("computed-torque", "exact"), ("computed-torque", "regrouped")]
    );
    for (count, (function, level)) in all.iter().zip(kinds) {
        let keys: Vec<_> = count.as_object().unwrap().keys().collect();
        assert_eq!(keys, ["add", "div", "function", "level", "live_inputs", "max_live", "mul", "neg", "sub"]);
        let text = printed(&[PUMA, "--function", function, "--level", level]);
        // `let name = a operator b;` or `let name = -a;`
        let statements = |wanted: Option<&str>| {
            let lines = text.lines().map(str::trim).filter(|line| line.starts_with("let "));
            lines.filter(|line| line.split(' ').nth(4) == wanted).count() as u64
        };
        for (key, operator) in
            [("mul", Some("*")), ("add", Some("+")), ("sub", Some("-")), ("div", Some("/")), ("neg", None)]
        {
            assert_eq!(count[key].as_u64().unwrap(), statements(operator), "{function} {level} {key}");
        }
    }
    let one = counts(&[PUMA, "--function", "gravity", "--level", "exact"]);
    assert_eq!(one.len(), 1);
}

#[test]
fn tables_name_every_rewrite_and_every_term_of_the_scene() {
    let text = printed(&[PUMA, "--scene", PICK, "--table"]);
    for word in ["folding of numbers", "zeros", "ones", "signs", "order of operands", "sharing", "all of them"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    for step in ["cheapest frames", "base parameters", "identities", "common factors and sums"] {
        assert!(text.contains(&format!("inverse-dynamics \u{2506} {step}")), "{step} in {text}");
    }
    for term in ["gravity", "payload", "rotors", "velocity terms"] {
        assert!(text.contains(&format!("inverse-dynamics \u{2506} exact     \u{2506} {term}")), "{term} in {text}");
    }
    // Terms that are not in the scene have no row.
    assert!(!text.contains("tip wrench"), "{text}");
    let regrouped = printed(&[PUMA, "--table", "--level", "regrouped", "--function", "gravity"]);
    assert!(!regrouped.contains("exact") && !regrouped.contains("mass-matrix"), "{regrouped}");
}

#[test]
fn a_term_costs_what_a_scene_without_it_saves() {
    let top = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let text = std::fs::read_to_string(format!("{top}/{PICK}")).unwrap();
    let without =
        text.replace("rotor = \"constant\"", "rotor = \"absent\"").replace("../robots", &format!("{top}/robots"));
    assert!(without.contains("absent"));
    let path = format!("{}/without_rotors.toml", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&path, without).unwrap();

    let asked = ["--function", "inverse-dynamics", "--level", "exact", "--scene"];
    let count = |scene: &str| counts(&[&[PUMA], &asked[..], &[scene]].concat()).remove(0);
    let (with, without) = (count(PICK), count(&path));
    let saved = |key: &str| (with[key].as_i64().unwrap() - without[key].as_i64().unwrap()).to_string();
    let table = printed(&[&[PUMA], &asked[..], &[PICK, "--table"]].concat());
    let row = table.lines().find(|line| line.contains("rotors")).unwrap();
    let cells: Vec<&str> = row.split(['\u{2502}', '\u{2506}']).map(str::trim).collect();
    let work = ["mul", "add", "sub", "div", "neg"].map(saved);
    let work = work.iter().map(String::as_str);
    assert_eq!(cells[3..10], ["rotors"].into_iter().chain(work).chain(["0"]).collect::<Vec<_>>(), "{table}");
    assert_eq!(cells[4], "6", "a product for every joint");
}

#[test]
fn what_cannot_be_is_refused() {
    let output = kernel(&["robots/ur5.toml", "--scene", PICK]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(2), vec![]));
    assert!(error.contains("scenes/puma560_pick.toml is a scene of another robot, \"Puma 560\""), "{error}");
    assert!(error.contains("robots/ur5.toml holds \"UR5\""), "{error}");
    for wrong in [&[PUMA, "--function", "energy"][..], &[PUMA, "--table", "--json"], &["nowhere.toml"], &[]] {
        let output = kernel(wrong);
        assert_eq!((output.status.code(), output.stdout), (Some(2), vec![]), "{wrong:?}");
    }
}
