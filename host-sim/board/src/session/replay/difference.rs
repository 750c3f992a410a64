//! Result of a replay: the ticks in which record and desk differ.

use crate::session::frame_log::LogError;
use link::{Frame, PACKET_MAX, Status};
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

/// Two values that should be the same.
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

    pub(super) fn differs(&mut self, difference: Difference) {
        self.differences += 1;
        self.first.get_or_insert(difference);
    }
}

/// Reason why a record is not a session.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// The scene's robot is not possible.
    #[error("{0}")]
    Robot(String),
    /// The record cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The record has no hello of a dry run or of a live session before its first tick.
    #[error("no hello of a dry run or a live session before entry {0}")]
    NoHello(usize),
}

/// The bits of a frame.
pub(super) fn bits(frame: &Frame) -> Vec<u8> {
    let mut buffer = [0; PACKET_MAX];
    postcard::to_slice(frame, &mut buffer).map_or_else(|_| Vec::new(), |bytes| bytes.to_vec())
}

/// A field of a status: its name, its text, and a function that copies it from another status.
type Field = (&'static str, fn(&Status) -> String, fn(&mut Status, &Status));

/// The first field in which two statuses of a tick differ in any bit.
pub(super) fn difference(recorded: &Status, replayed: &Status) -> Option<Difference> {
    let same = |a: &Status, b: &Status| bits(&Frame::Status(a.clone())) == bits(&Frame::Status(b.clone()));
    if same(recorded, replayed) {
        return None;
    }
    // Copies one field after the other into the recorded status: a field differs if its copy changes the bits.
    let fields: [Field; 12] = [
        ("state", |s| s.state.to_string(), |s, o| s.state = o.state),
        ("cause", |s| s.cause.to_string(), |s, o| s.cause = o.cause),
        ("joint", |s| format!("{:?}", s.joint), |s, o| s.joint = o.joint),
        ("homed", |s| s.homed.to_string(), |s, o| s.homed = o.homed),
        ("refused", |s| format!("{:?}", s.refused), |s, o| s.refused = o.refused),
        ("actuation", actuation, |s, o| s.actuation = o.actuation.clone()),
        ("sensed", |s| format!("{:?}", s.sensed), |s, o| s.sensed = o.sensed.clone()),
        ("reference", |s| format!("{:?}", s.extra), |s, o| s.extra = o.extra.clone()),
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

/// Torques with their bits, because two torques that differ only in the last bit can look the same in decimals.
fn actuation(status: &Status) -> String {
    match &status.actuation {
        Some(link::Actuation::Drive { torque, limits }) => {
            let torque: Vec<String> = torque.iter().map(|x| format!("{x} ({:#010x})", x.to_bits())).collect();
            format!("torque [{}], limits {limits:?}", torque.join(", "))
        }
        other => format!("{other:?}"),
    }
}
