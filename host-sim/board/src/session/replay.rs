//! Replay of a recorded session with the firmware's session on the desk. Every status must have the same bits.
//!
//! In a dry run a measurement starts each tick, so the recorded frames determine every tick. In a live session the board's timer starts the ticks.
//! Each status then holds the inputs of its tick: how many frames had been taken before it, and the readings of joints and lines. So a live record
//! needs a status of every tick with [`Parts::SENSED`](link::Parts::SENSED) and [`Parts::TORQUE`](link::Parts::TORQUE), from the first tick after the
//! hello on. If the status of a tick is missing, its inputs are unknown, and neither this tick nor a later one can be replayed.
//!
//! | compared | dry run | live |
//! |---|---|---|
//! | state, cause, joint, homed, refusal of a request, torques and limits | every status | every status |
//! | readings, lines, reference | if the status has them | if the status has them |
//! | capacity for points | every status | no: it is counted when the status is sent, and frames may come before that |
//! | refusals of frames | each, in order | no: their times are not determined |
//! | the black box | each tick, in order | no |
//! | cost | no: the desk's cost differs | no |

mod difference;
mod dry_run;
mod live;

pub use difference::{Difference, Gap, Replay, ReplayError};

use crate::session::frame_log::{Direction, Entry, Log, LogError};
use dynamics_core::Model;
use link::{Frame, Pacing};
use robot_compiler::{SceneFile, with_dof};

/// Replays a record with the session of a scene.
///
/// # Errors
/// As [`replay`]; a robot that is not possible.
pub fn replay_log(scene: &SceneFile, log: &Log) -> Result<Replay, ReplayError> {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(|error| ReplayError::Robot(error.to_string()))?;
        replay(scene, &model, log.entries())
    })
}

/// Replays the entries of a record with the session of its scene.
///
/// # Errors
/// The record cannot be read, or holds no session of an operator.
pub fn replay<const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    entries: impl Iterator<Item = Result<Entry, LogError>>,
) -> Result<Replay, ReplayError> {
    let mut entries = entries.enumerate().peekable();
    // Frames before the hello belong to another session.
    while entries.next_if(|(_, entry)| entry.as_ref().is_ok_and(|entry| entry.way == Direction::Received)).is_some() {}
    match entries.peek() {
        None => Err(ReplayError::NoHello(1)),
        Some((_, Err(error))) => Err(error.clone().into()),
        Some((number, Ok(Entry { frame, .. }))) => match frame {
            Frame::Hello(hello) if hello.pacing == Pacing::DryRun => {
                dry_run::replay(scene, model, entries.map(|(_, e)| e))
            }
            Frame::Hello(hello) if hello.pacing == Pacing::Live => live::replay(scene, model, entries.map(|(_, e)| e)),
            _ => Err(ReplayError::NoHello(number + 1)),
        },
    }
}

#[cfg(test)]
mod tests;
