//! Check that common dependencies of simulator, tasks and Python wheel are compiled only once: cargo compiles a package again for every set of its features.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Every package that this one is built from, with its version and features.
fn features(package: &str, options: &[&str]) -> BTreeMap<String, String> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap());
    cargo.args(["tree", "--locked", "--package", package, "--edges", "normal", "--prefix", "none", "--no-dedupe"]);
    let output = cargo.args(options).args(["--format", "{p}\t{f}"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .filter_map(|line| line.split_once('\t'))
        .map(|(name, features)| (name.into(), features.into()))
        .collect()
}

/// Packages that both are built from, but with different features.
fn differing(one: &BTreeMap<String, String>, other: &BTreeMap<String, String>) -> Vec<String> {
    let both = one.iter().filter_map(|(name, features)| Some((name, features, other.get(name)?)));
    both.filter(|(_, a, b)| a != b).map(|(name, a, b)| format!("{name}: [{a}] and [{b}]")).collect()
}

#[test]
fn simulator_tasks_and_wheel_ask_each_package_for_the_same_features() {
    let simulator = features("host-sim", &[]);
    for (package, common) in [("xtask", "robot-compiler "), ("trials", "studies "), ("newtau-python", "studies ")] {
        let other = features(package, &[]);
        assert!(other.keys().any(|name| name.starts_with(common)), "{:?}", other.keys());
        let found = differing(&simulator, &other);
        assert!(found.is_empty(), "{package}: name the features in robot-compiler/Cargo.toml:\n{}", found.join("\n"));
    }
}

/// Else `newtau` would compile the simulated arm again, which `newtau-run` has compiled in the same folder. Of `board` it compiles the session in addition.
#[test]
fn the_first_program_asks_each_package_for_the_features_of_the_whole() {
    let (first, whole) = (features("host-sim", &["--no-default-features"]), features("host-sim", &[]));
    assert!(first.keys().any(|name| name.starts_with("sim ")), "{:?}", first.keys());
    let later = ["identification ", "serialport ", "studies "];
    assert!(!first.keys().any(|name| later.iter().any(|later| name.starts_with(later))), "{:?}", first.keys());
    let found = differing(&first, &whole);
    let others: Vec<_> =
        found.into_iter().filter(|line| !line.starts_with("host-sim ") && !line.starts_with("board ")).collect();
    assert!(others.is_empty(), "name the features in host-sim/Cargo.toml:\n{}", others.join("\n"));
}

/// Derive macros share the build of what a package uses itself with that package, and are built for themselves otherwise. Then all that is derived with them is,
/// too.
#[test]
fn each_of_them_uses_what_its_derive_macros_share() {
    for package in ["host-sim", "xtask", "trials", "newtau-python"] {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap());
        cargo.args(["tree", "--locked", "--package", package, "--edges", "normal,no-proc-macro", "--prefix", "none"]);
        let output = cargo.args(["--format", "{p}"]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(
            text.lines().any(|line| line.starts_with("unicode-ident ")),
            "{package}: robot-compiler/Cargo.toml names it"
        );
    }
}

#[test]
fn a_feature_more_is_found() {
    let of = |pairs: &[(&str, &str)]| pairs.iter().map(|(name, f)| ((*name).into(), (*f).into())).collect();
    let simulator = of(&[("serde v1", "default,std"), ("clap v4", "derive"), ("csv v1", "")]);
    assert_eq!(
        differing(&simulator, &of(&[("serde v1", "std"), ("clap v4", "derive")])),
        ["serde v1: [default,std] and [std]"]
    );
    assert!(differing(&simulator, &of(&[("anyhow v1", "std"), ("csv v1", "")])).is_empty());
}
