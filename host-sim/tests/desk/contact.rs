//! `model contact` as used by a person or a script: converting a wrench and converting it back, comparison with statics, and rejected input.

use crate::program::{at_the_top, told};
use serde_json::Value;

const PUMA: &str = "robots/puma560.toml";
const STATE: [&str; 6] = ["--q", "0.3,0.9,-1.6,0.4,0.5,0.2", "--qd", "0.5,-0.8,1.1,2,-1,0.7", "--qdd", "3,-2,5,1,4,-6"];

fn contact(arguments: &[&str]) -> (i32, String, String) {
    told(at_the_top().args(["model", "contact"]).args(arguments).output().unwrap())
}

fn json(arguments: &[&str]) -> Value {
    let (code, out, error) = contact(&[arguments, &["--json"]].concat());
    assert_eq!((code, error.as_str()), (0, ""));
    serde_json::from_str(&out).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn a_contact_is_felt_in_the_base_and_found_again_from_there() {
    let wrench = [5.0, -8.0, 11.0, 0.4, 0.9, -0.7];
    let text = wrench.map(|x| x.to_string()).join(",");
    let there = json(&[&[PUMA][..], &STATE, &["--tip-wrench", &text]].concat());
    let reading = list(&there["base_wrench"]);
    let back = json(
        &[&[PUMA][..], &STATE, &["--base-wrench", &reading.iter().map(f64::to_string).collect::<Vec<_>>().join(",")]]
            .concat(),
    );
    for (found, wanted) in list(&back["tip_wrench"]).iter().zip(wrench) {
        assert!((found - wanted).abs() < 1e-10, "{back}");
    }
    // In both directions, the links' own equations hold; they are solved as one linear system.
    for answer in [&there, &back] {
        assert!(answer["residual"].as_f64().unwrap() < 1e-14, "{answer}");
        assert_eq!(answer["joints"].as_array().unwrap().len(), 6);
    }
    // The Puma's first joint is at the base's origin.
    for (first, base) in list(&there["joints"][0]).iter().zip(&reading) {
        assert!((first - base).abs() < 1e-10, "{there}");
    }
}

#[test]
fn the_table_names_both_ends_and_every_joint() {
    let (code, table, error) = contact(&[PUMA, "--q", "0,0.9,-1.6,0,0.5,0", "--tip-wrench", "1,0,0,0,0,0"]);
    assert_eq!((code, error.as_str()), (0, ""));
    for word in ["Puma 560: contact at the tip", "base, on the arm", "shoulder", "tip, by the environment", "residual"]
    {
        assert!(table.contains(word), "{word} in {table}");
    }
}

#[test]
fn bad_questions_are_refused_with_what_was_expected() {
    let q = ["--q", "0,0,0,0,0,0"];
    for (arguments, words) in [
        (&["--tip-wrench", "1,2,3"][..], "`--tip-wrench` has 3 numbers; expected 6 numbers"),
        (&["--base-wrench", "1,2,3,4,5,NaN"], "entry 6 of `--base-wrench` is NaN; expected a finite number"),
        (&["--base-wrench", "0,0,0,0,0,0", "--qd", "1"], "`--qd` has 1 number; expected 6 numbers"),
        (&["--base-wrench", "0,0,0,0,0,0", "--tip-wrench", "0,0,0,0,0,0"], "cannot be used with"),
        (&[], "required arguments were not provided"),
    ] {
        let (code, out, error) = contact(&[&[PUMA][..], &q, arguments].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{error}");
        assert!(error.contains(words), "{words} in {error}");
    }
}
