//! The reader of the tables of test cases detects a wrong output, a lost case and a change that cannot be applied.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use crate::common::cases::{Table, check};
use std::path::Path;

const TABLE: &str = "What is here is for a person.

==== arm
a = 1
b = 2
b = 2

c = 3

==== first from arm
- a = 1
+ a = 0
...
  c = 3
+ d = 4
----
one
two
three

==== second
x
----

after an empty line

==== third.toml from third.toml
----
end
";

fn table(text: &str) -> Table {
    Table::new(Path::new("tests/data/some.txt"), text.to_owned())
}

/// The outputs of the table, with that of `name` replaced.
fn found<'a>(table: &'a Table, name: &str, output: &str) -> Vec<(&'a str, String)> {
    let output = |own: &str, expected: &String| if own == name { output.to_owned() } else { expected.clone() };
    table.cases.iter().map(|case| (case.name.as_str(), output(&case.name, &case.expected))).collect()
}

#[test]
fn a_case_is_its_text_a_changed_text_or_a_file() {
    let table = table(TABLE);
    assert_eq!(table.bases, [("arm".to_owned(), "a = 1\nb = 2\nb = 2\n\nc = 3\n".to_owned())]);
    let cases: Vec<_> = table.cases.iter().map(|case| (case.input.as_deref(), case.expected.as_str())).collect();
    let changed = "a = 0\nb = 2\nb = 2\n\nc = 3\nd = 4\n";
    let first = (Some(changed), "one\ntwo\nthree");
    assert_eq!(cases, [first, (Some("x\n"), "\nafter an empty line"), (None, "end")]);
    let file = self::table("==== a from two.urdf\n- <robot name=\"two\">\n+ <robot>\n----\n");
    let two = include_str!("data/two.urdf");
    assert_eq!(file.cases[0].input.as_deref().unwrap(), two.replace("<robot name=\"two\">", "<robot>"));
}

#[test]
fn an_output_that_differs_is_named_with_its_place_and_lines() {
    let table = table(TABLE);
    assert!(table.differences(&found(&table, "", "")).is_empty());
    let changed = table.differences(&found(&table, "first", "one\n2\n2\nthree\n"));
    assert_eq!(changed, ["tests/data/some.txt:10: first\n- two\n+ 2\n+ 2\n"]);
    let longer = table.differences(&found(&table, "third.toml", "end\n\nof all\n"));
    assert_eq!(longer, ["tests/data/some.txt:27: third.toml\n+ \n+ of all\n"]);
    let lost = table.differences(&[("fourth", "four".to_owned())]);
    assert_eq!(lost, ["tests/data/some.txt: no case fourth, found\nfour"]);
}

#[test]
fn outputs_are_written_where_they_were() {
    let table = table(TABLE);
    assert_eq!(table.with(&found(&table, "", "")), TABLE);
    assert_eq!(table.with(&found(&table, "first", "one\n2\nthree\n")), TABLE.replace("two", "2"));
    assert_eq!(table.with(&[("third.toml", "of\nall".to_owned())]), TABLE.replace("end", "of\nall"));
    let more = table.with(&[("fourth", "four\n".to_owned())]);
    assert_eq!(more, format!("{TABLE}\n==== fourth\n----\nfour\n"));
    assert!(self::table(&more).differences(&[("fourth", "four".to_owned())]).is_empty());
}

/// The panic message of a function.
fn complaint(act: impl FnOnce() + std::panic::UnwindSafe) -> String {
    *std::panic::catch_unwind(act).unwrap_err().downcast::<String>().unwrap()
}

#[test]
fn a_table_that_cannot_be_meant_is_refused_with_its_place() {
    for (old, new, said) in [
        ("- a = 1", "- b = 2", "some.txt:10: first: 2 places in the base have [\"b = 2\"]"),
        ("- a = 1", "- a = 2", "some.txt:10: first: 0 places in the base have [\"a = 2\"]"),
        ("  c = 3\n", "", "some.txt:10: first: no line of the base shows where [\"d = 4\"] is added"),
        ("- a = 1", "a = 1", "some.txt:10: first: lines that do not begin with"),
        ("----\none", "one", "some.txt:10: first: no line `----`"),
        ("==== second", "==== first", "some.txt:21: first: the second section of this name"),
        ("==== second", "==== arm", "some.txt:21: arm: the second section of this name"),
        ("first from arm", "first from leg.txt", "tests/data/leg.txt: "),
    ] {
        assert!(TABLE.contains(old), "{old}");
        let said_now = complaint(|| drop(table(&TABLE.replacen(old, new, 1))));
        assert!(said_now.contains(said), "{said_now}");
    }
}

#[test]
fn a_test_fails_where_an_output_differs() {
    let path = std::env::temp_dir().join(format!("table-{}.txt", std::process::id()));
    std::fs::write(&path, TABLE).unwrap();
    check(&path, &[("third.toml", "end\n".to_owned())]);
    let said = complaint(|| check(&path, &[("first", "one".to_owned()), ("third.toml", "end".to_owned())]));
    assert!(said.contains("1 of 2 outputs differ") && said.contains("txt:10: first\n- two\n- three\n"), "{said}");
    assert!(complaint(|| check(&path, &[("first", "==== x".to_owned())])).contains("begins a section"));
    std::fs::remove_file(&path).unwrap();
}
