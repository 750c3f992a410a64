//! The tests of a package form one program if that compiles faster. A file that its `main.rs` does not include would never run.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::path::{Path, PathBuf};

/// Packages with all tests in one program.
const FOLDERS: [&str; 6] = [
    "dynamics-core/tests",
    "robot-compiler/tests",
    "host-sim/tests/desk",
    "link/session/tests/session",
    "link/joint-io/tests/explore",
    "xtask/tests/circles",
];

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// The Rust files of a folder and its subfolders, with their text.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| {
        if path.is_dir() {
            sources(&path)
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            vec![(path, text)]
        } else {
            Vec::new()
        }
    };
    paths.flat_map(of).collect()
}

/// Files that no `mod` includes, by name or by path.
fn lost(sources: &[(PathBuf, String)]) -> Vec<&Path> {
    let named = |path: &Path| {
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let folder = path.parent().and_then(Path::file_name).and_then(|name| name.to_str()).unwrap_or_default();
        let name = if stem == "mod" { folder } else { stem };
        let (by_name, by_path) = (format!("mod {name};"), format!("{stem}.rs\"]"));
        let leads = |line: &str| line.ends_with(&by_name) || line.starts_with("#[path") && line.ends_with(&by_path);
        sources.iter().any(|(from, text)| from != path && text.lines().any(|line| leads(line.trim())))
    };
    sources.iter().map(|(path, _)| path.as_path()).filter(|path| !path.ends_with("main.rs") && !named(path)).collect()
}

#[test]
fn every_file_of_a_test_program_is_in_it() {
    for folder in FOLDERS {
        let sources = sources(&top().join(folder));
        assert!(sources.iter().any(|(path, _)| path.ends_with("main.rs")), "{folder} has no main.rs");
        let lost = lost(&sources);
        assert!(lost.is_empty(), "{lost:?}");
    }
}

#[test]
fn a_file_to_which_nothing_leads_is_found() {
    let file = |path: &str, text: &str| (PathBuf::from(path), text.to_owned());
    let main = file("tests/main.rs", "mod here;\nmod common;\n#[path = \"data/emitted.rs\"]\nmod arm;\n");
    let others = ["tests/here.rs", "tests/common/mod.rs", "tests/data/emitted.rs", "tests/lost.rs"]
        .map(|path| file(path, "mod lost_not;\n"));
    let mut all = others.to_vec();
    all.push(main);
    assert_eq!(lost(&all), [Path::new("tests/lost.rs")]);
}
