//! Dependencies between the folders of the simulator's source.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::room_names::{named, sources};
use std::fs;
use std::path::{Path, PathBuf};

/// Every folder of `src`; each may use itself and the folders before it.
const ROOMS: [&str; 6] = ["plant", "run", "chip", "session", "study", "cli"];

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

#[test]
fn no_room_names_a_later_one_and_so_none_names_the_command_line() {
    for (place, room) in ROOMS.into_iter().enumerate() {
        let files = sources(&src().join(room));
        assert!(!files.is_empty(), "{room} is empty");
        for file in files {
            // A test may borrow a scene's world from a later folder, but no file may use the command line.
            let first = if file.to_str().unwrap().ends_with("tests.rs") { ROOMS.len() - 1 } else { place + 1 };
            let named = named(&fs::read_to_string(&file).unwrap(), &ROOMS);
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
            let named = named(&fs::read_to_string(&path).unwrap(), &ROOMS);
            assert!(named.is_empty(), "{name} names {named:?}");
        }
    }
}

#[test]
fn a_room_is_found_however_it_is_named() {
    let all = |text| named(text, &ROOMS).into_iter().collect::<Vec<_>>();
    assert_eq!(all("use crate::cli::names::Target;"), ["cli"]);
    assert_eq!(all("use crate::{\n    failure::{Failure, in_file},\n    cli::names::Target,\n};"), ["cli"]);
    assert_eq!(all("let code = crate::cli::run::exit_code(&run);"), ["cli"]);
    assert_eq!(all("//! as [`crate::cli`] has it\nuse crate::failure::Failure;"), [""; 0]);
    let command = fs::read_to_string(src().join("cli/run.rs")).unwrap();
    assert!(named(&command, &ROOMS).contains("cli"), "the file that is known to name it");
}
