//! Copies of a study's files that stand alone in one folder.

use crate::describe::diagnostics::{FileError, Source};
use crate::describe::study::{Study, Subject};
use crate::read::table::{Table, parse};
use crate::read::text::read_text;
use std::ops::Range;
use std::path::Path;

impl Study {
    /// The study's files by name and text: `study.toml`, its scenes and their robots, each naming the others by these names, with
    /// this number of runs.
    ///
    /// # Errors
    /// A file that cannot be read or parsed.
    pub fn copies(&self, count: u64) -> Result<Vec<(String, String)>, FileError> {
        let scenes = match &self.subject {
            Subject::Scene(experiment) => core::slice::from_ref(&experiment.scene),
            Subject::Campaign(scenes) => scenes.as_slice(),
        };
        let many = scenes.len() > 1;
        let mut study: Vec<(Range<usize>, String)> = Vec::new();
        let mut files = Vec::new();
        for (index, (path, place)) in scenes.iter().zip(&self.places.scenes).enumerate() {
            let number = if many { format!("_{}", index + 1) } else { String::new() };
            let name = format!("scene{number}.toml");
            study.push((place.clone(), format!("{name:?}")));
            let unread = |error: FileError| {
                let problem = format!("{}: {}", error.file(), error.problem());
                self.source.error(place.clone(), if many { "scenes" } else { "scene" }, problem, error.expected())
            };
            let source = read_text(path).map_err(unread)?;
            let (robot, place) = robot_of(&source)?;
            let from = path.parent().unwrap_or(Path::new("")).join(robot);
            let extension = from.extension().and_then(|extension| extension.to_str()).unwrap_or("toml");
            let robot_name = format!("robot{number}.{extension}");
            files.push((name, spliced(&source.text, vec![(place, format!("{robot_name:?}"))])));
            files.push((robot_name, read_text(&from)?.text));
        }
        study.extend(self.places.count.iter().map(|place| (place.clone(), count.to_string())));
        files.insert(0, ("study.toml".to_owned(), spliced(&self.source.text, study)));
        Ok(files)
    }
}

/// A scene's text that names this robot file.
///
/// # Errors
/// The text is no scene.
pub fn with_robot(scene: &str, robot: &str) -> Result<String, FileError> {
    let source = Source { file: "scene.toml".to_owned(), text: scene.to_owned() };
    let (_, place) = robot_of(&source)?;
    Ok(spliced(scene, vec![(place, format!("{robot:?}"))]))
}

/// The path of a scene's robot file, and its place in the text.
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
