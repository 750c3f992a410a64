//! Folders of the compiler, and the allowed dependencies between them.
#![allow(clippy::unwrap_used, reason = "a source that cannot be read should stop the test")]

use crate::common::rooms::{named, sources};
use std::path::Path;

/// Each folder may depend on those listed with it, and on itself.
const ROOMS: [(&str, &[&str]); 7] = [
    ("precision", &[]),
    ("describe", &[]),
    ("kernel", &[]),
    ("check", &["describe"]),
    ("choose", &["describe", "kernel"]),
    ("read", &["describe", "choose"]),
    ("emit", &["describe", "kernel"]),
];

fn all() -> Vec<&'static str> {
    ROOMS.map(|(room, _)| room).to_vec()
}

/// Folders that `text`, a part of `room`, uses although it must not.
fn strangers(room: &str, known: &[&str], text: &str) -> Vec<&'static str> {
    named(text, &all()).into_iter().filter(|name| *name != room && !known.contains(name)).collect()
}

#[test]
fn every_room_names_only_the_rooms_that_it_may_know() {
    for (room, known) in ROOMS {
        let mut paths = sources(&Path::new("src").join(room));
        paths.push(format!("src/{room}.rs").into());
        for path in paths {
            let found = strangers(room, known, &std::fs::read_to_string(&path).unwrap());
            assert!(found.is_empty(), "{} names {found:?}", path.display());
        }
    }
}

#[test]
fn a_room_that_names_a_stranger_is_found() {
    assert_eq!(strangers("kernel", &[], "use crate::describe::Robot;"), ["describe"]);
    assert_eq!(strangers("read", &["describe"], "use crate::{describe::Robot, emit::kernel::rust};"), ["emit"]);
    assert_eq!(strangers("read", &["describe"], "use crate::{describe::Robot, names};"), [""; 0]);
    // Checks the test itself: it must find the existing dependencies in the source.
    let chooses = std::fs::read_to_string("src/choose.rs").unwrap();
    let below: Vec<_> =
        sources(Path::new("src/choose")).iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    assert!(!strangers("choose", &[], &(chooses + &below.concat())).is_empty());
}
