//! Self-contained copies of a study's files in one folder.

use crate::describe::diagnostics::{FileError, Source};
use crate::describe::study::Study;
use crate::read::table::{Table, parse};
use crate::read::text::read_text;
use std::ops::Range;
use std::path::Path;

impl Study {
    /// The study's files by name and text: `study.toml`, its scene and its robot. They refer to each other by these names, and the study has
    /// this number of runs.
    ///
    /// # Errors
    /// A file that cannot be read or parsed.
    pub fn copies(&self, count: u64) -> Result<Vec<(String, String)>, FileError> {
        let (path, place) = (&self.experiment.scene, &self.places.scene);
        let unread = |error: FileError| {
            let problem = format!("{}: {}", error.file(), error.problem());
            self.source.error(place.clone(), "scene", problem, error.expected())
        };
        let source = read_text(path).map_err(unread)?;
        let (robot, robot_place) = robot_of(&source)?;
        let from = path.parent().unwrap_or(Path::new("")).join(robot);
        let extension = from.extension().and_then(|extension| extension.to_str()).unwrap_or("toml");
        let robot_name = format!("robot.{extension}");
        let scene = spliced(&source.text, vec![(robot_place, format!("{robot_name:?}"))]);
        let mut study = vec![(place.clone(), format!("{:?}", "scene.toml"))];
        study.extend(self.places.count.iter().map(|place| (place.clone(), count.to_string())));
        Ok(vec![
            ("study.toml".to_owned(), spliced(&self.source.text, study)),
            ("scene.toml".to_owned(), scene),
            (robot_name, read_text(&from)?.text),
        ])
    }
}

/// A scene's text with this robot file.
///
/// # Errors
/// The text is not a scene.
pub fn with_robot(scene: &str, robot: &str) -> Result<String, FileError> {
    let source = Source { file: "scene.toml".to_owned(), text: scene.to_owned() };
    let (_, place) = robot_of(&source)?;
    Ok(spliced(scene, vec![(place, format!("{robot:?}"))]))
}

/// The path of a scene's robot file, and its location in the text.
fn robot_of(source: &Source) -> Result<(String, Range<usize>), FileError> {
    const ROBOT: &str = "the path of a robot file, relative to this file";
    let document = parse(source)?;
    let robot = Table::root(source, &document).require("robot", ROBOT)?;
    Ok((robot.string(ROBOT)?.to_owned(), robot.span.clone()))
}

/// A text with pieces replaced.
fn spliced(text: &str, mut pieces: Vec<(Range<usize>, String)>) -> String {
    pieces.sort_by_key(|(place, _)| core::cmp::Reverse(place.start));
    let mut text = text.to_owned();
    for (place, new) in pieces {
        text.replace_range(place, &new);
    }
    text
}
