//! A scene and its robot as texts with gaps, which the values of a run fill. A run is then read like any scene file, so
//! that every check applies to it.

use super::edit::{Problem, edit};
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::robot::Robot;
use crate::describe::scene::SceneFile;
use crate::describe::study::{Experiment, Key, Literal, Relative, Study};
use crate::read::scene;
use crate::read::table::{Table, parse};
use crate::read::text::read_text;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item};

/// The value of a key in one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drawn<'a> {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// A listed value.
    Listed(&'a Literal),
}

/// A scene and its robot with gaps for the values of a run.
#[derive(Clone, Debug)]
pub struct Template {
    scene: Gapped,
    /// `None` if the study does not change the robot.
    robot: Option<Gapped>,
    /// The robot, if it is the same in all runs.
    fixed: Robot,
    folder: PathBuf,
}

/// A text with gaps.
#[derive(Clone, Debug)]
struct Gapped {
    file: String,
    head: String,
    /// Each gap, and the text after it.
    gaps: Vec<(TemplateGap, String)>,
}

/// A gap: the varied key that fills it, and the file's own number.
#[derive(Clone, Copy, Debug)]
struct TemplateGap {
    key: usize,
    relative: Relative,
    own: f64,
}

/// A gap's mark in a document, between the quotes of a string.
const MARK: &str = "@vary ";

impl Template {
    /// Reads the scene and the robot of a study, and inserts the gaps.
    ///
    /// # Errors
    /// A file that cannot be read or parsed, or a key that does not exist.
    pub fn load(study: &Study) -> Result<Self, FileError> {
        Self::with(study, usize::MAX)
    }

    /// The scene of a run with these values, one for each key that varies.
    ///
    /// # Errors
    /// A scene or robot that these values make impossible; its location refers to the text of [`Template::texts`].
    pub fn scene(&self, values: &[Drawn<'_>]) -> Result<SceneFile, FileError> {
        let varied = self.robot.as_ref().filter(|robot| !robot.gaps.is_empty());
        let changed = varied.map(|gapped| gapped.robot(values, &self.fixed.path)).transpose()?;
        let source = Source { file: self.scene.file.clone(), text: self.scene.fill(values) };
        scene::read_with(&source, &self.folder, Some(changed.as_ref().unwrap_or(&self.fixed)))
    }

    /// The texts of a run's scene, and of its robot if the run changes it.
    #[must_use]
    pub fn texts(&self, values: &[Drawn<'_>]) -> (String, Option<String>) {
        (self.scene.fill(values), self.robot.as_ref().map(|robot| robot.fill(values)))
    }

    /// Reads a run's scene. If that fails, names the first key of the study that causes the failure.
    ///
    /// # Errors
    /// As [`Template::scene`].
    pub fn check(&self, study: &Study, values: &[Drawn<'_>]) -> Result<SceneFile, FileError> {
        let error = match self.scene(values) {
            Ok(scene) => return Ok(scene),
            Err(error) => error,
        };
        for (count, (_, key)) in changes(&study.experiment).enumerate() {
            if count == 0 {
                // First the files unchanged.
                Self::with(study, 0)?.scene(values)?;
            }
            if let Err(error) = Self::with(study, count + 1)?.scene(values) {
                let problem = format!("with this value, {}: {}", error.field(), error.problem());
                return Err(study.at(key, problem, error.expected()));
            }
        }
        Err(error)
    }

    /// As [`Template::load`] with only the first keys of the study.
    fn with(study: &Study, count: usize) -> Result<Self, FileError> {
        let experiment = &study.experiment;
        let (source, mut document) = document(&experiment.scene)?;
        let folder = experiment.scene.parent().unwrap_or(Path::new("")).to_owned();
        let fixed = scene::robot(&Table::root(&source, &parse(&source)?), &folder)?;
        let joints: Vec<String> = fixed.joints.iter().map(|joint| joint.name.clone()).collect();
        let mut of_robot: Option<(Source, DocumentMut)> = None;
        for (change, key) in changes(experiment).take(count) {
            let path: Vec<&str> = key.name.split('.').collect();
            let (document, path) = match path.as_slice() {
                ["robot", rest @ ..] => {
                    let robot = match of_robot.take() {
                        Some(robot) => robot,
                        None => robot_document(study, key, &fixed.path)?,
                    };
                    (&mut of_robot.insert(robot).1, rest)
                }
                whole => (&mut document, whole),
            };
            let mut places = 0;
            let make = &mut |item: &mut Item| {
                places += 1;
                change.make(item)
            };
            edit(document, path, &joints, make).map_err(|(problem, expected)| study.at(key, problem, expected))?;
            if places == 0 {
                return Err(study.at(key, "leads to no value", "a list that is not empty"));
            }
        }
        let robot = of_robot.map(|(source, document)| Gapped::cut(&source.file, &document.to_string()));
        let fixed = match &robot {
            Some(robot) if robot.gaps.is_empty() => robot.robot(&[], &fixed.path)?,
            _ => fixed,
        };
        Ok(Self { scene: Gapped::cut(&source.file, &document.to_string()), robot, fixed, folder })
    }
}

/// Change of a key's value.
enum Change<'a> {
    /// Another value, or none.
    Put(Option<&'a str>),
    /// A gap for the values of a key that varies.
    Mark(usize, Relative),
}

impl Change<'_> {
    fn make(&self, item: &mut Item) -> Result<(), Problem> {
        match self {
            Self::Put(value) => put(item, *value),
            Self::Mark(index, relative) => mark(item, *index, *relative),
        }
    }
}

/// The changes of a study and their keys, in the order in which they are made.
fn changes(experiment: &Experiment) -> impl Iterator<Item = (Change<'_>, &Key)> {
    let settings = experiment.set.iter().map(|setting| (Change::Put(setting.value.as_deref()), &setting.key));
    let varied = experiment.vary.iter().enumerate().map(|(i, vary)| (Change::Mark(i, vary.relative), &vary.key));
    settings.chain(varied)
}

/// A robot file that a study changes.
fn robot_document(study: &Study, key: &Key, path: &Path) -> Result<(Source, DocumentMut), FileError> {
    if path.extension().is_none_or(|extension| extension != "toml") {
        let expected = "a robot file in TOML, which `newtau import` makes of a URDF";
        return Err(study.at(key, "the robot is a URDF file", expected));
    }
    document(path)
}

/// A file as text, and as a document that can be edited.
fn document(path: &Path) -> Result<(Source, DocumentMut), FileError> {
    let source = read_text(path)?;
    // Parsed for its errors, which have a location.
    parse(&source)?;
    if source.text.contains(MARK) {
        let problem = format!("holds the text {MARK:?}, which marks the gaps of a study");
        return Err(FileError::whole_file(path, "", problem, "a file without it"));
    }
    let document = source.text.parse().map_err(|error: toml_edit::TomlError| {
        FileError::whole_file(path, "", format!("not valid TOML: {}", error.message()), "a TOML document")
    })?;
    Ok((source, document))
}

/// Replaces or removes a value.
fn put(item: &mut Item, text: Option<&str>) -> Result<(), Problem> {
    let Some(text) = text else {
        if item.is_none() {
            return Err(("the file has no such key".to_owned(), "a key that it has".to_owned()));
        }
        *item = Item::None;
        return Ok(());
    };
    let value = text.parse::<toml_edit::Value>().map_err(|error| (error.to_string(), "a TOML value".to_owned()))?;
    *item = Item::Value(value);
    Ok(())
}

/// Replaces a value by a gap's mark, which contains the value's own number.
fn mark(item: &mut Item, index: usize, relative: Relative) -> Result<(), Problem> {
    let number = item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64));
    if item.as_str().is_some_and(|text| text.starts_with(MARK)) {
        return Err(("varies already under another key".to_owned(), "every value once".to_owned()));
    }
    if number.is_none() && relative != Relative::Value {
        let found = if item.is_none() { "the file has no such key" } else { "the file's own value is no number" };
        return Err((found.to_owned(), "a key with a number of its own beside `relative`".to_owned()));
    }
    let own = number.unwrap_or(0.0).to_bits();
    let word = match relative {
        Relative::Value => 'v',
        Relative::Factor => 'f',
        Relative::Offset => 'o',
    };
    *item = toml_edit::value(format!("{MARK}{index} {word} {own}"));
    Ok(())
}

impl Gapped {
    fn cut(file: &str, text: &str) -> Self {
        let opening = format!("\"{MARK}");
        let mut parts = text.split(opening.as_str());
        let head = parts.next().unwrap_or_default().to_owned();
        let gaps = parts.filter_map(|part| {
            let (gap, text) = part.split_once('"')?;
            let mut words = gap.split(' ');
            let key = words.next()?.parse().ok()?;
            let relative = match words.next()? {
                "f" => Relative::Factor,
                "o" => Relative::Offset,
                _ => Relative::Value,
            };
            let own = f64::from_bits(words.next()?.parse().ok()?);
            Some((TemplateGap { key, relative, own }, text.to_owned()))
        });
        Self { file: file.to_owned(), head, gaps: gaps.collect() }
    }

    /// The robot with these values.
    fn robot(&self, values: &[Drawn<'_>], path: &Path) -> Result<Robot, FileError> {
        let mut robot = Robot::from_toml_str(&self.fill(values), &self.file)?;
        path.clone_into(&mut robot.path);
        Ok(robot)
    }

    fn fill(&self, values: &[Drawn<'_>]) -> String {
        let mut text = self.head.clone();
        for (gap, behind) in &self.gaps {
            let value = values.get(gap.key).copied().unwrap_or(Drawn::Whole(0));
            gap.write(&mut text, value);
            text.push_str(behind);
        }
        text
    }
}

impl TemplateGap {
    fn write(&self, text: &mut String, value: Drawn<'_>) {
        let number = match value {
            Drawn::Number(x) => Some(x),
            Drawn::Whole(x) => Some(x as f64),
            Drawn::Listed(listed) => listed.number,
        };
        // Rust's shortest form that reads back exactly is valid TOML. Writing to a string cannot fail.
        let _ = match (self.relative, value, number) {
            (Relative::Factor, _, Some(x)) => write!(text, "{:?}", self.own * x),
            (Relative::Offset, _, Some(x)) => write!(text, "{:?}", self.own + x),
            (_, Drawn::Number(x), _) => write!(text, "{x:?}"),
            (_, Drawn::Whole(x), _) => write!(text, "{x}"),
            (_, Drawn::Listed(listed), _) => write!(text, "{}", listed.toml),
        };
    }
}
