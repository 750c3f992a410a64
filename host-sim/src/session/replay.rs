//! A record of a session through the very same session on the desk: every status must have the same bits.
//!
//! In a drill a measurement starts each tick, so the record's frames are all that there is to a tick. Live, the board's timer starts
//! ticks, and each status says what the tick was told: how many frames had been taken before it, and what the joints and lines said.
//! That is why a live record needs a status of every tick with [`Parts::SENSED`](link::Parts::SENSED) and
//! [`Parts::TORQUE`](link::Parts::TORQUE), from the first tick behind the hello on: what comes behind a tick that is missing
//! cannot be replayed, since nobody knows what that one was told.
//!
//! | compared | drill | live |
//! |---|---|---|
//! | state, cause, joint, homed, refusal of a request, torques and limits | every status | every status |
//! | readings, lines, reference | where the status has them | where the status has them |
//! | room for points | every status | not: it is counted when the status is sent, and frames may come before that |
//! | refusals of frames | each, in order | not: they come when they come |
//! | the black box | each tick, in order | not |
//! | cost | not: the desk's is another | not |

mod drill;
mod live;

use crate::session::frame_log::{Entry, LogError, Way};
use dynamics_core::Model;
use link::{Frame, PACKET_MAX, Pacing, Status};
use robot_compiler::SceneFile;
use serde::Serialize;

/// What came of a replay.
#[derive(Clone, Debug, PartialEq, Eq, Default, Serialize)]
pub struct Replay {
    /// Ticks that were compared.
    pub ticks: u64,
    /// Ticks of them that differ.
    pub differences: u64,
    /// The first of those.
    pub first: Option<Difference>,
    /// Why the record cannot be replayed any further.
    pub end: Option<Gap>,
}

/// Two answers that should have been the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The tick.
    pub tick: u32,
    /// What differs.
    pub field: String,
    /// What the record has.
    pub recorded: String,
    /// What the desk has.
    pub replayed: String,
}

/// Where a record cannot be replayed any further.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// The first tick that cannot.
    pub tick: u32,
    /// Why.
    pub why: String,
}

impl Replay {
    /// Whether every tick of the record was replayed with the same bits.
    #[must_use]
    pub fn is_the_same(&self) -> bool {
        self.ticks > 0 && self.differences == 0 && self.end.is_none()
    }

    fn differs(&mut self, difference: Difference) {
        self.differences += 1;
        self.first.get_or_insert(difference);
    }
}

/// Why a record makes no session.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// It has no hello of a drill or of a live session before its first tick.
    #[error("no hello of a drill or a live session before entry {0}")]
    NoHello(usize),
}

/// Run the entries of a record through the session of its scene.
///
/// # Errors
/// A record that cannot be read, or is not one of an operated session.
pub fn replay<const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    entries: impl Iterator<Item = Result<Entry, LogError>>,
) -> Result<Replay, ReplayError> {
    let mut entries = entries.enumerate().peekable();
    // What was on the line before the hello belongs to another session.
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

/// A part of a status: its name, its text, and how it is taken over from another.
type Field = (&'static str, fn(&Status) -> String, fn(&mut Status, &Status));

/// The first thing in which two statuses of a tick differ, to the bit.
fn difference(recorded: &Status, replayed: &Status) -> Option<Difference> {
    let same = |a: &Status, b: &Status| bits(&Frame::Status(a.clone())) == bits(&Frame::Status(b.clone()));
    if same(recorded, replayed) {
        return None;
    }
    // Field by field: what differs is what makes the difference when it alone is taken over.
    let fields: [Field; 11] = [
        ("state", |s| s.state.to_string(), |s, o| s.state = o.state),
        ("cause", |s| s.cause.to_string(), |s, o| s.cause = o.cause),
        ("joint", |s| format!("{:?}", s.joint), |s, o| s.joint = o.joint),
        ("homed", |s| s.homed.to_string(), |s, o| s.homed = o.homed),
        ("refused", |s| format!("{:?}", s.refused), |s, o| s.refused = o.refused),
        ("actuation", actuation, |s, o| s.actuation = o.actuation.clone()),
        ("sensed", |s| format!("{:?}", s.sensed), |s, o| s.sensed = o.sensed.clone()),
        ("reference", |s| format!("{:?}", s.reference), |s, o| s.reference = o.reference.clone()),
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

/// Torques with their bits: two that differ in the last one are the same in decimals.
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
