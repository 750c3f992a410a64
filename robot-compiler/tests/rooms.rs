//! The rooms of the compiler, and which may know which.
#![allow(clippy::unwrap_used, reason = "a source that cannot be read should stop the test")]

use std::path::{Path, PathBuf};

/// Each room knows those that are named beside it, and itself.
const ROOMS: [(&str, &[&str]); 6] = [
    ("precision", &[]),
    ("describe", &[]),
    ("kernel", &[]),
    ("choose", &["describe", "kernel"]),
    ("read", &["describe", "choose"]),
    ("emit", &["describe", "kernel"]),
];

/// All files of a folder and of the folders in it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

#[test]
fn every_room_names_only_the_rooms_that_it_may_know() {
    for (room, known) in ROOMS {
        let mut paths = sources(&Path::new("src").join(room));
        paths.push(format!("src/{room}.rs").into());
        for path in paths {
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            for named in code.flat_map(|line| line.split("crate::").skip(1)) {
                let name = named.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
                let stranger = ROOMS.iter().any(|(other, _)| *other == name) && name != room && !known.contains(&name);
                assert!(!stranger, "{} names {name}", path.display());
            }
        }
    }
}
