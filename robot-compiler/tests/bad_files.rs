//! Broken files, each with its error message.
//!
//! Every file in `tests/bad` breaks one thing. The message as a person sees it, without colour, is a snapshot in
//! `tests/snapshots`; `INSTA_UPDATE=always cargo test -p robot-compiler --test bad_files` writes them anew.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::panic, reason = "a test names the file that fails")]

use miette::{GraphicalReportHandler, GraphicalTheme};
use robot_compiler::{FileError, LinkageFile, Robot, SceneFile};
use std::path::{Path, PathBuf};

use crate::common::files;

/// Scene files start with `scene_`, linkages with `linkage_`, all others are robots. Paths are relative to this package, so
/// that messages are the same everywhere.
fn load(path: &Path) -> Result<(), FileError> {
    let name = path.file_name().unwrap().to_string_lossy();
    if name.starts_with("scene_") {
        SceneFile::load(path).map(|_| ())
    } else if name.starts_with("linkage_") {
        LinkageFile::load(path).map(|_| ())
    } else {
        Robot::load(path).map(|_| ())
    }
}

fn bad_files() -> Vec<PathBuf> {
    files(Path::new("tests/bad"), &["toml", "urdf", "yaml"])
}

fn render(error: &FileError) -> String {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(120);
    handler.render_report(&mut text, error).unwrap();
    text
}

#[test]
fn every_broken_file_gets_its_message() {
    let files = bad_files();
    assert!(files.len() >= 40, "found {}", files.len());
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for path in files {
            let Err(error) = load(&path) else {
                panic!("{} was accepted", path.display());
            };
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            insta::assert_snapshot!(name, render(&error));
        }
    });
}

#[test]
fn every_message_names_file_line_and_what_was_expected() {
    for path in bad_files() {
        let Err(error) = load(&path) else {
            panic!("{} was accepted", path.display());
        };
        // A scene's error may lie in the robot file that it names.
        assert!(error.file().starts_with("tests/bad/"), "{error}");
        assert!(!error.problem().is_empty() && !error.expected().is_empty(), "{error}");
        let Some((line, column)) = error.line_column() else {
            let whole = ["not_utf8.toml", "unknown_extension.yaml"];
            assert!(whole.iter().any(|name| path.ends_with(name)), "{error}: no line");
            continue;
        };
        assert!(error.to_string().starts_with(&format!("{}:{line}:{column}: ", error.file())), "{error}");
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Robot::load(Path::new("tests/bad/nowhere.toml")).unwrap_err();
    assert_eq!(error.file(), "tests/bad/nowhere.toml");
    assert!(error.problem().starts_with("cannot be read: "));
}

#[test]
fn a_model_of_another_size_is_refused() {
    let robot = Robot::load(&crate::common::top("robots/planar2r.toml")).unwrap();
    let error = robot.model::<3>().unwrap_err();
    assert_eq!((error.field(), error.problem(), error.expected()), ("joint", "the robot has 2 joints", "3 joints"));
}
