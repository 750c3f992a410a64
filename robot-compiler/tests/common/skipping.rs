//! Tests that need a tool or files from outside this repository.
#![allow(unreachable_pub, reason = "a module of a test program")]

/// Reports that a test cannot run because a tool or files are missing. The continuous integration has all of them, so there the test fails.
pub fn skipped(why: &str) {
    let required = ["CI", "NEWTAU_CI"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()));
    assert!(!required, "skipped, which the continuous integration must not: {why}");
    println!("skipped: {why}");
}
