//! Which folders of the simulator's source name which others.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every folder of `src`; each may name itself and those before it.
const ROOMS: [&str; 6] = ["plant", "run", "chip", "session", "study", "cli"];

/// Rooms that paths beginning with `crate` lead to; comments do not count.
fn named(text: &str) -> BTreeSet<&'static str> {
    let code: String = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim()).collect();
    let paths = code.split("crate::").skip(1);
    paths.flat_map(heads).filter_map(|head| ROOMS.into_iter().find(|room| *room == head)).collect()
}

/// The first name of a path, or of every path in a list in braces.
fn heads(path: &str) -> Vec<String> {
    let name = |text: &str| text.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let Some(list) = path.strip_prefix('{') else { return vec![name(path)] };
    let mut heads = vec![name(list)];
    let mut depth = 1;
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => heads.push(name(&list[at + 1..])),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    heads
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

#[test]
fn no_room_names_a_later_one_and_so_none_names_the_command_line() {
    for (place, room) in ROOMS.into_iter().enumerate() {
        let mut files = Vec::new();
        sources(&src().join(room), &mut files);
        assert!(!files.is_empty(), "{room} is empty");
        for file in files {
            // A test may borrow a scene's world from a later room; the command line no file may.
            let first = if file.to_str().unwrap().ends_with("tests.rs") { ROOMS.len() - 1 } else { place + 1 };
            let named = named(&fs::read_to_string(&file).unwrap());
            let later: Vec<_> =
                ROOMS.iter().skip(first.max(place + 1)).filter(|later| named.contains(*later)).collect();
            assert!(later.is_empty(), "{} names {later:?}", file.display());
        }
    }
}

#[test]
fn what_all_rooms_share_names_none_of_them_and_there_is_no_other_room() {
    for entry in fs::read_dir(src()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            assert!(ROOMS.contains(&name.as_str()), "{name} is no room");
        } else {
            let named = named(&fs::read_to_string(&path).unwrap());
            assert!(named.is_empty(), "{name} names {named:?}");
        }
    }
}

#[test]
fn a_room_is_found_however_it_is_named() {
    let all = |text| named(text).into_iter().collect::<Vec<_>>();
    assert_eq!(all("use crate::cli::names::Target;"), ["cli"]);
    assert_eq!(all("use crate::{\n    failure::{Failure, in_file},\n    cli::names::Target,\n};"), ["cli"]);
    assert_eq!(all("let code = crate::cli::run::exit_code(&run);"), ["cli"]);
    assert_eq!(all("//! as [`crate::cli`] has it\nuse crate::failure::Failure;"), [""; 0]);
    let command = fs::read_to_string(src().join("cli/run.rs")).unwrap();
    assert!(named(&command).contains("cli"), "the file that is known to name it");
}
