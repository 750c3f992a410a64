//! Check that files do not use each other in a circle: no source file uses an item of another file that, directly or through others, uses one of its
//! own.
//!
//! The test reads all files of every library and program of both workspaces, without code that is compiled only for tests. A file uses another one if
//! a path in its code, or an import, leads to an item that the other one defines; re-exports are followed to the file with the definition. A parent
//! that only declares its children, or re-exports their items, does not use them.
//!
//! Method calls are ignored, because they need types; so a file may contain a part of another file's `impl`. A name that a macro creates counts as an
//! item of the module in which it is looked up.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod graph;
mod modules;
mod names;

use graph::Graph;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Kinds of cargo targets that are not built from a package's sources.
const ELSEWHERE: [&str; 4] = ["test", "bench", "example", "custom-build"];

fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The packages of the workspace in a folder: name, and the root files of libraries and programs.
fn packages(folder: &Path) -> Vec<(String, Vec<PathBuf>)> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(folder).args(["metadata", "--no-deps", "--format-version", "1", "--locked"]);
    let output = cargo.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let package = |package: &Value| {
        let targets = package["targets"].as_array().unwrap().iter();
        let built = targets.filter(|target| !ELSEWHERE.contains(&target["kind"][0].as_str().unwrap()));
        let roots = built.map(|target| PathBuf::from(target["src_path"].as_str().unwrap())).collect();
        (package["name"].as_str().unwrap().to_owned(), roots)
    };
    metadata["packages"].as_array().unwrap().iter().map(package).collect()
}

/// The uses between files of a package with these root files.
fn uses_of(roots: &[PathBuf]) -> Graph {
    let mut graph = Graph::default();
    for root in roots {
        modules::read(root).add_uses(&mut graph);
    }
    graph
}

#[test]
fn no_source_files_use_each_other_in_a_circle() {
    let packages = [packages(top()), packages(&top().join("bench"))].concat();
    for name in ["xtask", "bench", "newtau-python", "batch-engine"] {
        assert!(packages.iter().any(|(package, roots)| package == name && !roots.is_empty()), "{name}");
    }
    let circles: Vec<String> = std::thread::scope(|scope| {
        let count = |roots| scope.spawn(move || uses_of(roots).circles(top()));
        let threads: Vec<_> = packages.iter().map(|(_, roots)| count(roots)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    assert!(circles.is_empty(), "{} circles\n{}", circles.len(), circles.join("\n"));
}

/// The circles of an invented package with these files.
fn circles_of(name: &str, files: &[(&str, &str)]) -> Vec<String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("circles").join(name);
    std::fs::remove_dir_all(&folder).ok();
    for (path, text) in files {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    uses_of(&[folder.join("lib.rs")]).circles(&folder)
}

#[test]
fn files_that_use_each_other_are_found_with_the_names_between_them() {
    let files = [
        ("lib.rs", "pub mod arm; mod plant;"),
        ("arm.rs", "pub struct Arm; impl Arm { fn step(&self) -> f64 { crate::plant::torque::of(self) } }"),
        ("plant/mod.rs", "pub mod torque; pub use torque::of;"),
        ("plant/torque.rs", "use super::super::arm::{self}; pub fn of(arm: &arm::Arm) -> f64 { 0.0 }"),
    ];
    let expected = "arm.rs, plant/torque.rs\n  arm.rs -> plant/torque.rs: of\n  plant/torque.rs -> arm.rs: Arm\n";
    assert_eq!(circles_of("two", &files), [expected]);
}

#[test]
fn a_parent_that_calls_a_child_which_uses_its_items_is_in_a_circle() {
    let child = "use super::{Arm, limits}; pub(super) fn check(arm: &Arm) { limits!(arm) }";
    let parent = |own: &str| format!("macro_rules! limits {{ ($x:expr) => {{}} }} mod check; pub struct Arm; {own}");
    let circles =
        |name: &str, own: &str| circles_of(name, &[("lib.rs", parent(own).as_str()), ("check.rs", child)]).len();
    assert_eq!(circles("call", "pub fn run(arm: &Arm) { check::check(arm) }"), 1);
    assert_eq!(circles("in_a_macro", "pub fn run(arm: &Arm) { assert_eq!((), crate::check::check(arm)) }"), 1);
    assert_eq!(circles("through_its_own_export", "pub use check::check; pub fn run(arm: &Arm) { check(arm) }"), 1);
    assert_eq!(circles("renamed", "pub use self::check as other; use other::check; pub fn run() {}"), 1);
    assert_eq!(circles("export", "pub use check::check;"), 0);
    assert_eq!(circles("statement", "pub fn run(arm: &Arm) { #[cfg(test)] check::check(arm); }"), 0);
    assert_eq!(circles("test", "#[cfg(test)] mod tests { fn run(arm: &super::Arm) { super::check::check(arm) } }"), 0);
}

#[test]
fn what_is_passed_on_belongs_to_the_file_that_defines_it() {
    let files = [
        (
            "lib.rs",
            "mod a; mod b; mod c; mod e; pub use b::*; use a::first as one; pub fn run() { one() } pub mod face { pub use crate::e::f; }",
        ),
        (
            "a.rs",
            "use crate::Shared; use std::fmt::Display; pub fn first() { let _: Shared; let _ = crate::b::Kind::Of; }",
        ),
        ("b.rs", "pub use super::c::Shared; record! { pub enum Kind { Of } }"),
        ("c/mod.rs", "mod d; pub use d::Shared;"),
        ("e.rs", "pub fn f() { crate::five!() } pub fn g() { crate::a::first() }"),
        (
            "c/d.rs",
            "#[macro_export] macro_rules! five { () => {} } pub struct Shared; mod here { use super::Shared; fn f(_: Shared) {} }",
        ),
    ];
    assert_eq!(circles_of("passed_on", &files), [""; 0]);
}
