//! Dependencies between the folders of each package of the simulator.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::room_names::{named, sources};
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of each package's source. Each folder may use itself and those before it. Cargo checks the dependencies between packages.
const FOLDERS: [(&str, &[&str]); 2] = [("sim/src", &["plant", "run"]), ("board/src", &["can", "chip", "session"])];

fn source(package: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(package)
}

#[test]
fn no_folder_names_a_later_one() {
    for (package, folders) in FOLDERS {
        for (place, folder) in folders.iter().enumerate() {
            let files = sources(&source(package).join(folder));
            assert!(!files.is_empty(), "{folder} is empty");
            // A test may use a scene's world from a later folder.
            for file in files.iter().filter(|file| !file.to_str().unwrap().ends_with("tests.rs")) {
                let named = named(&fs::read_to_string(file).unwrap(), folders);
                let later: Vec<_> = folders[place + 1..].iter().filter(|later| named.contains(*later)).collect();
                assert!(later.is_empty(), "{} names {later:?}", file.display());
            }
        }
    }
}

#[test]
fn every_folder_is_listed() {
    for (package, folders) in FOLDERS {
        for entry in fs::read_dir(source(package)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            // A file's own tests may be in a folder with the file's name.
            let only_tests = || sources(&path).iter().all(|file| file.ends_with("tests.rs"));
            assert!(
                !path.is_dir() || folders.contains(&name.as_str()) || only_tests(),
                "{package}: {name} is not listed"
            );
        }
    }
}

#[test]
fn a_folder_is_found_however_it_is_named() {
    let all = |text| named(text, &["cli", "plant"]).into_iter().collect::<Vec<_>>();
    assert_eq!(all("use crate::cli::names::Target;"), ["cli"]);
    assert_eq!(all("use crate::{\n    failure::{Failure, in_file},\n    cli::names::Target,\n};"), ["cli"]);
    assert_eq!(all("let code = crate::cli::run::exit_code(&run);"), ["cli"]);
    assert_eq!(all("//! as [`crate::cli`] has it\nuse crate::failure::Failure;"), [""; 0]);
    let run = fs::read_to_string(source("sim/src/run/simulate.rs")).unwrap();
    assert!(named(&run, &["plant", "run"]).contains("plant"), "a file that is known to name it");
}
