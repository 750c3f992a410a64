//! A record of `connect` as a log: the ticks in which torque acted.

use crate::failure::Failure;
use crate::session::frame_log::{self, Way};
use link::{Actuation, Frame, Sensed};
use robot_compiler::{SceneFile, with_dof};
use std::collections::HashMap;
use std::path::Path;

/// Ticks without torque, or whose status is missing, that end a stretch.
const GAP: u32 = 20;

/// A tick: its number, positions and velocities (the second empty where counts were measured), torques.
struct Tick {
    number: u32,
    place: Vec<f64>,
    speed: Vec<f64>,
    torque: Vec<f64>,
}

/// The longest stretch in which torque acted, as the text of a log: time, positions, velocities where they were measured, torques.
///
/// # Errors
/// [`Failure::Input`]: a record that cannot be read, or one without torque.
pub fn text(bytes: Vec<u8>, path: &Path) -> Result<Vec<u8>, Failure> {
    let wrong = |problem: String, expected: &str| {
        Failure::Input(miette::miette!(help = format!("expected {expected}"), "{}: {problem}", path.display()))
    };
    let log = frame_log::Log::new(bytes).map_err(|error| wrong(error.to_string(), "a record of this version"))?;
    let scene = SceneFile::from_toml_str(&log.head.text, &log.head.scene).map_err(Failure::input)?;
    let per_count: Vec<f64> = with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        scene.controller_config(&model).encoder.map(|encoder| encoder.per_count).to_vec()
    });
    let mut told: HashMap<u32, Sensed> = HashMap::new();
    let mut ticks: Vec<Tick> = Vec::new();
    for entry in log.entries() {
        let entry = entry.map_err(|error| wrong(error.to_string(), "a record that was closed"))?;
        match (entry.way, entry.frame) {
            // In a drill the readings are the host's, and the next status answers them.
            (Way::Sent, Frame::Measurement(measurement)) => {
                told = HashMap::from([(measurement.tick, measurement.sensed)]);
            }
            (Way::Received, Frame::Status(status)) => {
                let sensed = status.sensed.map(|said| said.sensed).or_else(|| told.remove(&status.tick));
                if let (Some(Actuation::Drive { torque, .. }), Some(sensed)) = (status.actuation, sensed) {
                    let wide = |values: &[f32]| values.iter().copied().map(f64::from).collect::<Vec<_>>();
                    let (place, speed) = match &sensed {
                        Sensed::State { q, qd } => (wide(q), wide(qd)),
                        Sensed::Counts(counts) => {
                            let place = |(count, per_count): (&i32, &f64)| f64::from(*count) * per_count;
                            (counts.iter().zip(&per_count).map(place).collect(), Vec::new())
                        }
                    };
                    ticks.push(Tick { number: status.tick, place, speed, torque: wide(&torque) });
                }
            }
            _ => {}
        }
    }
    let stretch = ticks.chunk_by(|a, b| b.number.wrapping_sub(a.number) <= GAP).max_by_key(|stretch| stretch.len());
    let Some(stretch) = stretch else {
        return Err(wrong("no torque acted in it".to_owned(), "a record of an arm that was armed and moved"));
    };
    Ok(csv(stretch, scene.period()))
}

fn csv(ticks: &[Tick], period: f64) -> Vec<u8> {
    let joints = ticks.first().map_or(0, |tick| tick.place.len());
    let speeds = ticks.iter().all(|tick| tick.speed.len() == joints);
    let names = ["q", "qd", "tau"].into_iter().filter(|name| speeds || *name != "qd");
    let head = names.flat_map(|name| (1..=joints).map(move |joint| format!("{name}_{joint}")));
    let mut text = std::iter::once("time".to_owned()).chain(head).collect::<Vec<_>>().join(",");
    for tick in ticks {
        let speed = if speeds { tick.speed.as_slice() } else { &[] };
        let numbers = tick.place.iter().chain(speed).chain(&tick.torque);
        let row: Vec<String> =
            std::iter::once(f64::from(tick.number) * period).chain(numbers.copied()).map(|x| x.to_string()).collect();
        text += "\n";
        text += &row.join(",");
    }
    text.push('\n');
    text.into_bytes()
}
