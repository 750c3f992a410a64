//! Tests that need a tool or files of others.
#![allow(unreachable_pub, reason = "a module of a test program")]

/// Reports that a test cannot run for lack of a tool or of files. The continuous integration has them all: there it fails.
pub fn skipped(why: &str) {
    let required = ["CI", "NEWTAU_CI"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()));
    assert!(!required, "skipped, which the continuous integration must not: {why}");
    println!("skipped: {why}");
}
