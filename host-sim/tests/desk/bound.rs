//! `choose bound` as a command: its table, its JSON, and its messages. What it computes is tested in `studies`.

use crate::program;
use crate::program::at_the_top;
use serde_json::Value;
use std::process::Output;

fn bound(arguments: &[&str]) -> Output {
    at_the_top()
        .args(["choose", "bound"])
        .args(arguments)
        .args(["--samples", "1000", "--boxes", "100"])
        .output()
        .unwrap()
}

fn printed(arguments: &[&str]) -> String {
    program::printed(bound(arguments))
}

fn refusal(arguments: &[&str]) -> String {
    let output = bound(arguments);
    assert_eq!((output.status.code(), output.stdout), (Some(2), vec![]));
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn the_command_gives_every_joint_both_sides() {
    let text = printed(&["robots/planar2r.toml", "scenes/planar2r_swing.toml", "--json"]);
    assert_eq!(text, printed(&["robots/planar2r.toml", "scenes/planar2r_swing.toml", "--json"]));
    let answers: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(
        (answers.len(), &answers[0]["scene"], &answers[1]["scene"]),
        (2, &Value::Null, &"planar2r_swing".into())
    );
    for answer in &answers {
        assert_eq!((&answer["level"], answer["joints"].as_array().unwrap().len()), (&"exact".into(), 2));
        for joint in answer["joints"].as_array().unwrap() {
            let number = |key: &str| joint[key].as_f64().unwrap();
            assert!(0.0 < number("found") && number("found") <= number("bound_there"), "{joint}");
            assert!(number("bound_there") <= 1.001 * number("one_state"), "{joint}");
            assert!(number("one_state") <= number("proven") && number("proven") <= number("one_box"), "{joint}");
        }
    }
    let table = printed(&["robots/planar2r.toml", "--level", "regrouped"]);
    for wanted in ["level regrouped", "Everywhere in the joint limits", "shoulder", " between "] {
        assert!(table.contains(wanted), "{wanted}: {table}");
    }
}

#[test]
fn the_command_says_what_is_missing_or_wrong() {
    let path = std::env::temp_dir().join(format!("bound-{}.toml", std::process::id()));
    let rod = "name = \"rod\"\n[[joint]]\nname = \"swing\"\ntype = \"revolute\"\nmass = 1.0\ncom = [-0.5, 0.0, 0.0]\n";
    std::fs::write(&path, format!("{rod}dh = {{ a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }}\n")).unwrap();
    let unlimited = path.to_str().unwrap();
    let said = [
        (&["robots/planar2r.toml", "--velocity", "1"][..], "velocity"),
        (&["robots/planar2r.toml", "--acceleration", "1,nan"], "expected finite numbers"),
        (&["robots/planar2r.toml", "--acceleration", "1e38,1e38"], "there is no bound"),
        (&["robots/no_such_arm.toml"], "no_such_arm"),
        (&["scenes/planar3r_reach.toml"], "control.trig: \"libm\" has no bound"),
        (&[unlimited], "give --velocity"),
        (&["robots/planar2r.toml", "--write", "README.md"], "<!-- measured: bound -->"),
    ];
    for (arguments, wanted) in said {
        let text = refusal(arguments);
        assert!(text.contains(wanted), "{arguments:?}: {text}");
    }
    printed(&[unlimited, "--velocity", "2"]);
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn the_command_writes_its_table_between_the_marks_and_nothing_else() {
    let path = std::env::temp_dir().join(format!("bound-{}.md", std::process::id()));
    std::fs::write(&path, "before\n<!-- measured: bound -->\nold\n<!-- end measured: bound -->\nafter\n").unwrap();
    let name = path.to_str().unwrap();
    assert_eq!(printed(&["robots/planar2r.toml", "--write", name]), "");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("before\n<!-- measured: bound -->\n\n| arm | joint | found |"), "{text}");
    assert!(text.ends_with("|\n\n<!-- end measured: bound -->\nafter\n") && !text.contains("old"), "{text}");
    printed(&["robots/planar2r.toml", "--write", name]);
    assert_eq!(text, std::fs::read_to_string(&path).unwrap());
    std::fs::remove_file(&path).unwrap();
}
