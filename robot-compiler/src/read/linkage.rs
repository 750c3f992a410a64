//! The TOML form of a linkage file.

use super::fields::{origin, text};
use super::table::{Table, Value, parse};
use super::text::read_text;
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::linkage::{FOUR_BAR, LinkageFile, Mechanism, SLIDER_CRANK};
use dynamics_core::linkage::{
    FourBar, FourBarLengths, LinkageError, Member, PlanarBody, SliderCrank, SliderCrankLengths,
};
use nalgebra::Vector2;
use std::path::{Path, PathBuf};

/// Default gravity, m/s^2: the ground horizontal, the linkage upright.
const UPRIGHT: Vector2<f64> = Vector2::new(0.0, -9.81);

const LENGTH: &str = "a length in m, from 1e-9 to 1e6";

#[derive(Clone, Copy)]
enum LinkageKind {
    FourBar,
    SliderCrank,
}

impl LinkageFile {
    /// Reads a linkage file (TOML).
    ///
    /// # Errors
    /// A file that cannot be read, is not of its format, or describes a linkage that cannot be assembled.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let mut linkage = read(&read_text(path)?)?;
        path.clone_into(&mut linkage.path);
        Ok(linkage)
    }

    /// Reads the text of a linkage file; errors use `name` as the file's name.
    ///
    /// # Errors
    /// As [`LinkageFile::load`].
    pub fn from_toml_str(text: &str, name: &str) -> Result<Self, FileError> {
        read(&Source { file: name.to_owned(), text: text.to_owned() })
    }
}

fn read(source: &Source) -> Result<LinkageFile, FileError> {
    const KIND: &str = "\"four-bar\" or \"slider-crank\" in a linkage file";
    let document = parse(source)?;
    let root = Table::root(source, &document);
    let kind = root
        .require("kind", KIND)?
        .choice(&[(FOUR_BAR, LinkageKind::FourBar), (SLIDER_CRANK, LinkageKind::SliderCrank)])?;
    root.only(match kind {
        LinkageKind::FourBar => &["kind", "name", "source", "gravity", "ground", "crank", "coupler", "follower"],
        LinkageKind::SliderCrank => &["kind", "name", "source", "gravity", "offset", "crank", "rod", "slider"],
    })?;
    Ok(LinkageFile {
        name: text(&root.require("name", "the linkage's name")?, "the linkage's name")?,
        source: origin(&root)?,
        gravity: root.get("gravity").map_or(Ok(UPRIGHT), |value| {
            pair(&value, "the gravitational acceleration [x, y] in m/s^2, in the linkage's plane")
        })?,
        mechanism: match kind {
            LinkageKind::FourBar => Mechanism::FourBar(four_bar(&root)?),
            LinkageKind::SliderCrank => Mechanism::SliderCrank(slider_crank(&root)?),
        },
        path: PathBuf::from(&source.file),
    })
}

/// Rejects a linkage file if an arm or a scene was expected.
pub(super) fn refuse(root: &Table<'_>, wanted: &str) -> Result<(), FileError> {
    match root.get("kind") {
        Some(kind) if kind.string("").is_ok_and(|kind| [FOUR_BAR, SLIDER_CRANK].contains(&kind)) => {
            Err(kind
                .error("this file describes a closed loop", format!("{wanted}; `newtau model linkage` takes this one")))
        }
        _ => Ok(()),
    }
}

fn four_bar(root: &Table<'_>) -> Result<FourBar<f64>, FileError> {
    let [crank, coupler, follower] = ["crank", "coupler", "follower"].map(|key| turning(root, key));
    let (crank, coupler, follower) = (crank?, coupler?, follower?);
    let ground = length(&root.require("ground", "the distance of the two ground pivots in m")?)?;
    let lengths = FourBarLengths { ground, crank: crank.0, coupler: coupler.0, follower: follower.0 };
    FourBar::new(lengths, [crank.1, coupler.1, follower.1]).map_err(|error| placed(root, &error))
}

fn slider_crank(root: &Table<'_>) -> Result<SliderCrank<f64>, FileError> {
    let (crank, rod) = (turning(root, "crank")?, turning(root, "rod")?);
    let table = member(root, "slider")?;
    table.only(&["mass", "com"])?;
    let slider = body(&table)?;
    const OFFSET: &str = "how far above the crank's pivot the guide runs, in m, at most 1e6";
    let offset = root.get("offset").map_or(Ok(0.0), |value| value.within(-1e6, 1e6, OFFSET))?;
    let lengths = SliderCrankLengths { crank: crank.0, rod: rod.0, offset };
    SliderCrank::new(lengths, [crank.1, rod.1, slider]).map_err(|error| placed(root, &error))
}

fn member<'a>(root: &Table<'a>, key: &str) -> Result<Table<'a>, FileError> {
    root.require(key, "a table { length, mass, com, inertia }; a slider { mass, com }")?.table()
}

/// Length and body of a link between two pins.
fn turning(root: &Table<'_>, key: &str) -> Result<(f64, PlanarBody<f64>), FileError> {
    let table = member(root, key)?;
    table.only(&["length", "mass", "com", "inertia"])?;
    Ok((length(&table.require("length", LENGTH)?)?, body(&table)?))
}

/// A length between bounds that are wider than any linkage, and within which squares neither vanish nor overflow.
fn length(value: &Value<'_>) -> Result<f64, FileError> {
    value.within(1e-9, 1e6, LENGTH)
}

/// A body; a mass needs a centre, and without an inertia it is a point mass.
fn body(table: &Table<'_>) -> Result<PlanarBody<f64>, FileError> {
    const MASS: &str = "a mass of zero or more, kg";
    const COM: &str = "the centre of mass [x, y] in m, in the link's own frame";
    const INERTIA: &str = "the moment of inertia about the centre of mass, zero or more, kg m^2";
    let mass = table.require("mass", MASS)?.not_negative(MASS)?;
    let centre = match table.get("com") {
        Some(value) => pair(&value, COM)?,
        None if mass > 0.0 => return Err(table.error("com", "missing", COM)),
        None => Vector2::zeros(),
    };
    let inertia = table.get("inertia").map_or(Ok(0.0), |value| value.not_negative(INERTIA))?;
    if inertia > 0.0 && mass <= 0.0 {
        return Err(table.error("inertia", "given for a link without mass", "a mass above zero beside it"));
    }
    Ok(PlanarBody { mass, centre, inertia })
}

fn pair(value: &Value<'_>, expected: &str) -> Result<Vector2<f64>, FileError> {
    Ok(Vector2::from_column_slice(&value.numbers(2, expected)?))
}

/// The core's error, reported at the field that caused it.
fn placed(root: &Table<'_>, error: &LinkageError<f64>) -> FileError {
    let (member, expected) = match error {
        LinkageError::NeverCloses { longest, .. } => (*longest, "lengths of which none exceeds the sum of all others"),
        LinkageError::Length(member) => (*member, LENGTH),
        LinkageError::Body(member) => (*member, "a mass and an inertia that a body can have"),
        // Errors at one crank angle; no constructor reports them.
        _ => (Member::Crank, "a loop that closes"),
    };
    let key = member.to_string();
    match (member, root.table(&key)) {
        (Member::Ground | Member::Offset, _) | (_, Err(_) | Ok(None)) => root.error(&key, error.to_string(), expected),
        (_, Ok(Some(table))) => table.error("length", error.to_string(), expected),
    }
}
