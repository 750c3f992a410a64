//! Reader of a hand-guided path: from `log.csv` of a run, the table of a session, or its record.

use board::session::frame_log::{Log, is_record};
use dynamics_core::control::Encoder;
use link::{Frame, Sensed};
use robot_compiler::SceneFile;
use sim::failure::Failure;
use std::path::{Path as FilePath, PathBuf};

/// Smallest number of samples of a path.
const FEWEST: usize = 3;

/// Positions over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Name of the file it was read from.
    pub file: PathBuf,
    /// Time, s, and position of each joint, rad or m; time rises.
    pub samples: Vec<(f64, Vec<f64>)>,
}

impl Path {
    /// Reads a path of the scene's arm.
    ///
    /// # Errors
    /// [`Failure::Input`]: the file cannot be read, a column is missing, a field is not a number, or time does not rise.
    pub fn load<const N: usize>(file: &FilePath, scene: &SceneFile) -> Result<Self, Failure> {
        let wrong = |problem: String| Failure::Input(miette::miette!("{}: {problem}", file.display()));
        let bytes = std::fs::read(file).map_err(|error| wrong(error.to_string()))?;
        let samples = if is_record(&bytes) {
            let log = Log::new(bytes).map_err(|error| wrong(error.to_string()))?;
            of_record::<N>(&log, scene)
        } else {
            of_table::<N>(&bytes, scene)
        };
        let samples = samples.map_err(wrong)?;
        if samples.len() < FEWEST {
            return Err(wrong(format!("{} samples of the joints, expected {FEWEST} or more", samples.len())));
        }
        if let Some(at) = samples.windows(2).position(|pair| pair[1].0 <= pair[0].0) {
            let (before, after) = (samples[at].0, samples[at + 1].0);
            return Err(wrong(format!("sample {}: time {after} after {before}, expected time that rises", at + 2)));
        }
        Ok(Self { file: file.to_owned(), samples })
    }
}

type Samples = Vec<(f64, Vec<f64>)>;

fn encoders<const N: usize>(scene: &SceneFile) -> Result<[Encoder<f64>; N], String> {
    Ok(scene.controller_config(&scene.robot.model::<N>().map_err(|error| error.to_string())?).encoder)
}

/// Positions of the arm in a record of `connect`.
fn of_record<const N: usize>(log: &Log, scene: &SceneFile) -> Result<Samples, String> {
    let encoders = encoders::<N>(scene)?;
    let mut samples: Samples = Vec::new();
    for entry in log.entries() {
        let entry = entry.map_err(|error| error.to_string())?;
        let Frame::Status(status) = entry.frame else { continue };
        let Some(sensed) = &status.sensed else { continue };
        let q: Vec<f64> = match &sensed.sensed {
            Sensed::State { q, .. } => q.iter().map(|q| f64::from(*q)).collect(),
            Sensed::Counts(counts) => counts.iter().zip(&encoders).map(|(n, e)| e.position(*n)).collect(),
        };
        if q.len() != N {
            return Err(format!("tick {}: {} joints, expected the {N} of the scene's robot", status.tick, q.len()));
        }
        let t = f64::from(status.tick) / scene.control.rate;
        // The black box repeats ticks that have already been reported.
        if samples.last().is_none_or(|(last, _)| t > *last) {
            samples.push((t, q));
        }
    }
    Ok(samples)
}

/// Positions from `log.csv` (`t`, `q1` ..) or from a session's table (`tick`, `sensed_1` ..; counts if there is no velocity).
fn of_table<const N: usize>(bytes: &[u8], scene: &SceneFile) -> Result<Samples, String> {
    let mut rows = csv::ReaderBuilder::new().from_reader(bytes);
    let head = rows.headers().map_err(|error| error.to_string())?.clone();
    let column = |names: &[String]| {
        let found = head.iter().position(|name| names.iter().any(|known| known == name));
        found.ok_or_else(|| format!("line 1: no column {}", names.join(" or ")))
    };
    let (in_ticks, time) = match column(&["t".into(), "time".into()]) {
        Ok(time) => (false, time),
        Err(_) => (true, column(&["tick".into()]).map_err(|_| "line 1: no column t, time or tick".to_owned())?),
    };
    let of_joint = |i: usize| column(&[format!("q{i}"), format!("q_{i}"), format!("sensed_{i}")]);
    let places = (1..=N).map(of_joint).collect::<Result<Vec<_>, _>>()?;
    let speeds = (1..=N).map(|i| column(&[format!("velocity_{i}")]).ok()).collect::<Vec<_>>();
    let encoders = encoders::<N>(scene)?;
    let mut samples = Samples::new();
    for (index, row) in rows.records().enumerate() {
        let row = row.map_err(|error| error.to_string())?;
        let line = row.position().map_or(index as u64 + 2, csv::Position::line);
        let number = |place: usize| {
            let text = row.get(place).unwrap_or("").trim();
            let expected = format!("line {line}, {}: found {text:?}, expected a number", &head[place]);
            text.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or(expected)
        };
        // Skip a row without a reading of the joints.
        if places.iter().all(|place| row.get(*place).is_some_and(|text| text.trim().is_empty())) {
            continue;
        }
        let q = places.iter().zip(&speeds).zip(&encoders).map(|((place, speed), encoder)| {
            let counted = speed.is_some_and(|speed| row.get(speed).is_some_and(|text| text.trim().is_empty()));
            number(*place).map(|x| if counted { encoder.position(x as i32) } else { x })
        });
        let q = q.collect::<Result<Vec<f64>, String>>()?;
        let t = number(time)?;
        samples.push((if in_ticks { t / scene.control.rate } else { t }, q));
    }
    Ok(samples)
}
