//! Invalid files, each with its error message.
//!
//! Every case of the tables in `tests/bad` has one mistake. The table also has its message as a person sees it, without colour:
//! [`crate::common::cases`] describes the format.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]

use miette::{GraphicalReportHandler, GraphicalTheme};
use robot_compiler::{Ends, FileError, LinkageFile, Robot, SceneFile};
use std::path::{Path, PathBuf};

use crate::common::cases::{Case, Table, check};

/// Tables with their numbers of cases, so that a lost case is noticed.
const TABLES: [(&str, usize); 5] = [("drives", 47), ("linkage", 16), ("robot", 64), ("scene", 150), ("urdf", 30)];

/// The path of a table. Paths are relative to this package, so that messages are the same everywhere.
fn path(table: &str) -> PathBuf {
    Path::new("tests/bad").join(table).with_extension("txt")
}

/// Reads a text as the file of this name in `tests/bad`; without a text, reads the file itself, a robot. The names of scenes
/// begin with `scene_`, those of linkages with `linkage_`; all others are robots.
fn read(name: &str, text: Option<&str>) -> Result<(), FileError> {
    let path = Path::new("tests/bad").join(name);
    let shown = path.to_str().unwrap();
    match text {
        None => Robot::load(&path).map(|_| ()),
        Some(text) if name.starts_with("scene_") => SceneFile::from_toml_str(text, &path).map(|_| ()),
        Some(text) if name.starts_with("linkage_") => LinkageFile::from_toml_str(text, shown).map(|_| ()),
        Some(text) if name.ends_with(".urdf") => Robot::from_urdf_str(text, shown, Ends::default()).map(|_| ()),
        Some(text) => Robot::from_toml_str(text, shown).map(|_| ()),
    }
}

fn error(case: &Case) -> Option<FileError> {
    read(&case.name, case.input.as_deref()).err()
}

fn render(error: &FileError) -> String {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(120);
    handler.render_report(&mut text, error).unwrap();
    text
}

/// Asserts that every case gives the message in the table.
fn messages(table: &str) {
    let cases = Table::read(&path(table)).cases;
    let message = |case| error(case).map_or("accepted".to_owned(), |error| render(&error));
    let found: Vec<_> = cases.iter().map(|case| (case.name.as_str(), message(case))).collect();
    check(&path(table), &found);
}

#[test]
fn every_invalid_robot_file_gets_its_message() {
    messages("robot");
}

#[test]
fn every_invalid_drive_gets_its_message() {
    messages("drives");
}

#[test]
fn every_invalid_urdf_file_gets_its_message() {
    messages("urdf");
}

#[test]
fn every_invalid_scene_gets_its_message() {
    messages("scene");
}

#[test]
fn every_invalid_linkage_gets_its_message() {
    messages("linkage");
}

#[test]
fn every_message_names_file_line_and_what_was_expected() {
    for case in TABLES.iter().flat_map(|(table, _)| Table::read(&path(table)).cases) {
        let error = error(&case);
        assert!(error.is_some(), "{} was accepted", case.name);
        let error = error.unwrap();
        // A scene's error may be in its robot file.
        assert!(error.file().starts_with("tests/bad/"), "{error}");
        assert!(!error.problem().is_empty() && !error.expected().is_empty(), "{error}");
        let Some((line, column)) = error.line_column() else {
            let whole = ["not_utf8.toml", "unknown_extension.yaml"];
            assert!(whole.contains(&case.name.as_str()), "{error}: no line");
            continue;
        };
        assert!(error.to_string().starts_with(&format!("{}:{line}:{column}: ", error.file())), "{error}");
    }
}

/// Without the change the case is valid: it is the change that makes it invalid.
#[test]
fn what_the_cases_change_is_valid() {
    for (table, _) in TABLES {
        for (name, text) in Table::read(&path(table)).bases {
            let read = read(&format!("{table}_{name}"), Some(&text));
            assert!(read.is_ok(), "{table} {name}: {}", read.unwrap_err());
        }
    }
    Robot::load(Path::new("tests/data/two.urdf")).unwrap();
}

#[test]
fn no_case_is_lost() {
    let tables: Vec<_> = crate::common::files(Path::new("tests/bad"), &["txt"]);
    let counted: Vec<_> = tables.iter().map(|table| (table.clone(), Table::read(table).cases.len())).collect();
    assert_eq!(counted, TABLES.map(|(table, count)| (path(table), count)));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Robot::load(Path::new("tests/bad/nowhere.toml")).unwrap_err();
    assert_eq!(format!("{error:?}"), format!("{error}; expected {}", error.expected()));
    assert_eq!(error.file(), "tests/bad/nowhere.toml");
    assert!(error.problem().starts_with("cannot be read: "));
}

#[test]
fn a_model_of_another_size_is_refused() {
    let robot = Robot::load(&crate::common::top("robots/planar2r.toml")).unwrap();
    let error = robot.model::<3>().unwrap_err();
    assert_eq!((error.field(), error.problem(), error.expected()), ("joint", "the robot has 2 joints", "3 joints"));
}
