//! Replay of a recorded session through the same session on the desk: every status must have the same bits.
//!
//! In a drill a measurement starts each tick, so the record's frames determine every tick. In a live session the
//! board's timer starts the ticks, and each status holds the inputs of its tick: how many frames had been taken before
//! it, and the readings of joints and lines. A live record therefore needs a status of every tick with
//! [`Parts::SENSED`](link::Parts::SENSED) and [`Parts::TORQUE`](link::Parts::TORQUE), from the first tick after the
//! hello on. Without the status of a tick its inputs are unknown, and neither it nor the ticks after it can be
//! replayed.
//!
//! | compared | drill | live |
//! |---|---|---|
//! | state, cause, joint, homed, refusal of a request, torques and limits | every status | every status |
//! | readings, lines, reference | if the status has them | if the status has them |
//! | room for points | every status | not: it is counted when the status is sent, and frames may come before that |
//! | refusals of frames | each, in order | not: their times are not determined |
//! | the black box | each tick, in order | not |
//! | cost | not: the desk's cost differs | not |

mod drill;
mod live;

use crate::session::frame_log::{Entry, LogError, Way};
use dynamics_core::Model;
use link::{Frame, PACKET_MAX, Pacing, Status};
use robot_compiler::SceneFile;
use serde::Serialize;

/// Result of a replay.
#[derive(Clone, Debug, PartialEq, Eq, Default, Serialize)]
pub struct Replay {
    /// Ticks that were compared.
    pub ticks: u64,
    /// Number of compared ticks that differ.
    pub differences: u64,
    /// The first difference.
    pub first: Option<Difference>,
    /// Reason why the replay stopped before the end of the record.
    pub end: Option<Gap>,
}

/// Two answers that should be the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The tick.
    pub tick: u32,
    /// Name of the field.
    pub field: String,
    /// Its value in the record.
    pub recorded: String,
    /// Its value on the desk.
    pub replayed: String,
}

/// Tick from which a record cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// The first tick that cannot be replayed.
    pub tick: u32,
    /// The reason.
    pub why: String,
}

impl Replay {
    /// True if every tick of the record was replayed with the same bits.
    #[must_use]
    pub fn is_the_same(&self) -> bool {
        self.ticks > 0 && self.differences == 0 && self.end.is_none()
    }

    fn differs(&mut self, difference: Difference) {
        self.differences += 1;
        self.first.get_or_insert(difference);
    }
}

/// Reason why a record is not a session.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// The record cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The record has no hello of a drill or of a live session before its first tick.
    #[error("no hello of a drill or a live session before entry {0}")]
    NoHello(usize),
}

/// Run the entries of a record through the session of its scene.
///
/// # Errors
/// A record that cannot be read, or is not of an operated session.
pub fn replay<const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    entries: impl Iterator<Item = Result<Entry, LogError>>,
) -> Result<Replay, ReplayError> {
    let mut entries = entries.enumerate().peekable();
    // Frames before the hello belong to another session.
    while entries.next_if(|(_, entry)| entry.as_ref().is_ok_and(|entry| entry.way == Way::Received)).is_some() {}
    match entries.peek() {
        None => Err(ReplayError::NoHello(1)),
        Some((_, Err(error))) => Err(error.clone().into()),
        Some((number, Ok(Entry { frame, .. }))) => match frame {
            Frame::Hello(hello) if hello.pacing == Pacing::Drill => {
                drill::replay(scene, model, entries.map(|(_, e)| e))
            }
            Frame::Hello(hello) if hello.pacing == Pacing::Live => live::replay(scene, model, entries.map(|(_, e)| e)),
            _ => Err(ReplayError::NoHello(number + 1)),
        },
    }
}

/// The bits of a frame.
fn bits(frame: &Frame) -> Vec<u8> {
    let mut buffer = [0; PACKET_MAX];
    postcard::to_slice(frame, &mut buffer).map_or_else(|_| Vec::new(), |bytes| bytes.to_vec())
}

/// A field of a status: its name, its text, and a function that copies it from another status.
type Field = (&'static str, fn(&Status) -> String, fn(&mut Status, &Status));

/// The first field in which two statuses of a tick differ, to the bit.
fn difference(recorded: &Status, replayed: &Status) -> Option<Difference> {
    let same = |a: &Status, b: &Status| bits(&Frame::Status(a.clone())) == bits(&Frame::Status(b.clone()));
    if same(recorded, replayed) {
        return None;
    }
    // Copy one field at a time into the recorded status: the field differs if the copy changes the bits.
    let fields: [Field; 12] = [
        ("state", |s| s.state.to_string(), |s, o| s.state = o.state),
        ("cause", |s| s.cause.to_string(), |s, o| s.cause = o.cause),
        ("joint", |s| format!("{:?}", s.joint), |s, o| s.joint = o.joint),
        ("homed", |s| s.homed.to_string(), |s, o| s.homed = o.homed),
        ("refused", |s| format!("{:?}", s.refused), |s, o| s.refused = o.refused),
        ("actuation", actuation, |s, o| s.actuation = o.actuation.clone()),
        ("sensed", |s| format!("{:?}", s.sensed), |s, o| s.sensed = o.sensed.clone()),
        ("reference", |s| format!("{:?}", s.aside), |s, o| s.aside = o.aside.clone()),
        ("kept", |s| s.kept.to_string(), |s, o| s.kept = o.kept),
        ("room", |s| s.room.to_string(), |s, o| s.room = o.room),
        ("taken", |s| s.taken.to_string(), |s, o| s.taken = o.taken),
        ("tick", |s| s.tick.to_string(), |s, o| s.tick = o.tick),
    ];
    let differs = |take: fn(&mut Status, &Status)| {
        let mut other = recorded.clone();
        take(&mut other, replayed);
        !same(&other, recorded)
    };
    let (field, text, _) = fields.into_iter().find(|(_, _, take)| differs(*take))?;
    let (recorded_text, replayed_text) = (text(recorded), text(replayed));
    Some(Difference { tick: recorded.tick, field: field.to_owned(), recorded: recorded_text, replayed: replayed_text })
}

/// Torques with their bits, because two torques that differ in the last bit can look the same in decimals.
fn actuation(status: &Status) -> String {
    match &status.actuation {
        Some(link::Actuation::Drive { torque, limits }) => {
            let torque: Vec<String> = torque.iter().map(|x| format!("{x} ({:#010x})", x.to_bits())).collect();
            format!("torque [{}], limits {limits:?}", torque.join(", "))
        }
        other => format!("{other:?}"),
    }
}

#[cfg(test)]
mod tests;
