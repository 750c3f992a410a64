//! Conversion of a record of `connect`, or of `run --mcap`, to a log of the ticks in which torque acted.

use board::session::frame_log::LogError;
use board::session::frame_log::{self, Direction};
use link::{Actuation, Frame, Sensed};
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use sim::run::mcap_file;
use sim::run::mcap_file::messages::{JointState, JointStates, Message as _};
use sim::run::mcap_file::reader::{Item, Reader};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// Number of ticks without torque, or without a status, that ends a stretch.
const GAP: u32 = 20;

/// A tick: number, positions, velocities (empty if counts were measured), torques.
struct Tick {
    number: u32,
    place: Vec<f64>,
    speed: Vec<f64>,
    torque: Vec<f64>,
}

/// Returns the longest stretch in which torque acted, as the text of a log: time, positions, velocities if they were measured, torques.
///
/// # Errors
/// [`Failure::Input`]: the record cannot be read, or contains no torque.
pub fn text(bytes: Vec<u8>, path: &Path) -> Result<Vec<u8>, Failure> {
    let wrong = |problem: String, expected: &str| {
        Failure::Input(miette::miette!(help = format!("expected {expected}"), "{}: {problem}", path.display()))
    };
    let kept = bytes.starts_with(mcap_file::MAGIC).then(|| bytes.clone());
    let log = match (frame_log::Log::new(bytes), kept) {
        (Ok(log), _) => log,
        // Not a session: an MCAP file of a run, or of another program.
        (Err(error @ (LogError::Mcap(_) | LogError::Headless(_))), Some(bytes)) => {
            return joint_states(&bytes).map_err(|problem| match error {
                LogError::Mcap(_) => wrong(
                    problem,
                    "an MCAP file that `run --mcap` or `connect --record` wrote; others as CSV, for example exported by PlotJuggler",
                ),
                other => wrong(other.to_string(), "a record of this version"),
            });
        }
        (Err(error), _) => return Err(wrong(error.to_string(), "a record of this version")),
    };
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
            // In a dry run the host sends the readings, and the next status answers them.
            (Direction::Sent, Frame::Measurement(measurement)) => {
                told = HashMap::from([(measurement.tick, measurement.sensed)]);
            }
            (Direction::Received, Frame::Status(status)) => {
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

/// Converts the joint states of an MCAP file to the text of a log, with the joints' names. Joints without a torque get an empty field.
///
/// # Errors
/// A description of the problem: no joint states, joints that change, a broken message.
fn joint_states(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut others: BTreeSet<String> = BTreeSet::new();
    let mut names: Vec<String> = Vec::new();
    let mut text = String::new();
    for (number, item) in Reader::new(bytes).enumerate() {
        let Item::Message(raw) = item? else { continue };
        if raw.schema != JointStates::SCHEMA {
            others.insert(format!("{} ({})", raw.topic, raw.schema));
            continue;
        }
        let states: JointStates = serde_json::from_slice(&raw.data)
            .map_err(|error| format!("message {} of {}: {error}; JSON was expected", number + 1, raw.topic))?;
        if names.is_empty() {
            names = states.joints.iter().map(|joint| joint.name.clone()).collect();
            let head = ["position", "velocity", "effort"].iter().flat_map(|what| {
                names.iter().map(move |name| format!("\"joint_states/{}/{what}\"", name.replace(['/', '.', '"'], "_")))
            });
            text = std::iter::once("time [ns]".to_owned()).chain(head).collect::<Vec<_>>().join(",") + "\n";
        }
        if !states.joints.iter().map(|joint| &joint.name).eq(&names) {
            return Err(format!("message {} of {} has other joints than the first", number + 1, raw.topic));
        }
        let field = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
        let of = |pick: fn(&JointState) -> Option<f64>| states.joints.iter().map(move |joint| field(pick(joint)));
        let numbers = of(|joint| joint.position).chain(of(|joint| joint.velocity)).chain(of(|joint| joint.effort));
        let time = u128::from(states.timestamp.sec) * 1_000_000_000 + u128::from(states.timestamp.nsec);
        text += &(std::iter::once(time.to_string()).chain(numbers).collect::<Vec<_>>().join(",") + "\n");
    }
    if names.is_empty() {
        let others =
            if others.is_empty() { "nothing".to_owned() } else { others.into_iter().collect::<Vec<_>>().join(", ") };
        return Err(format!("no messages of the schema {}; it holds {others}", JointStates::SCHEMA));
    }
    Ok(text.into_bytes())
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
