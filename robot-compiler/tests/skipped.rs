//! A test without its tool or files reports it on a desk, and fails in the continuous integration.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use std::process::Command;

/// Runs one test of this program in an environment without a formatter and without files of other projects.
fn passes(test: &str, variable: Option<&str>) -> bool {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([test, "--exact", "--nocapture"]);
    command.env("RUSTFMT", "/nonexistent/rustfmt").env("NEWTAU_URDF_DIR", "/nonexistent");
    command.env_remove("CI").env_remove("NEWTAU_CI");
    variable.map(|name| command.env(name, "1"));
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("running 1 test"), "{said}");
    output.status.success()
}

#[test]
fn a_test_that_lacks_something_fails_in_the_continuous_integration_alone() {
    for test in [
        "drives::emitted_source_is_as_rustfmt_would_leave_it",
        "shipped::emitted_source_is_as_rustfmt_would_leave_it",
        "urdf_corpus::every_file_loads_or_says_why_not",
        "urdf_corpus::torques_are_those_of_pinocchio",
    ] {
        assert!(passes(test, None), "{test}");
        for variable in ["CI", "NEWTAU_CI"] {
            assert!(!passes(test, Some(variable)), "{test} with {variable}");
        }
    }
}
