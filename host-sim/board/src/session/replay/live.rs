//! Replay of a live session, which the board's own timer paced: each status holds the inputs of its tick.

use super::difference::{Gap, Replay, ReplayError, difference};
use crate::session::dry_run::{DeskSession, Uncounted, desk_session};
use crate::session::frame_log::{Direction, Entry, LogError};
use dynamics_core::Model;
use link::codec::Received;
use link::convert::array;
use link::{ExtraFields, Frame, Pacing, Refusal, SensedLines, Status};
use robot_compiler::SceneFile;
use session::black_box::Report;
use session::meter::Meter;
use session::readings::Lines;
use session::readings::{JointFaults, Readings};
use std::collections::VecDeque;

/// The replayed board.
struct Again<const N: usize> {
    session: DeskSession<N>,
    meter: Meter<Uncounted>,
    /// Frames sent but not yet taken by a replayed tick.
    waiting: VecDeque<Frame>,
    /// Number of frames taken, modulo 65,536.
    taken: u16,
    /// The last replayed tick.
    tick: u32,
    /// True if the board has answered the hello.
    agreed: bool,
}

pub(super) fn replay<const N: usize>(
    scene: &SceneFile,
    model: &Model<f64, N>,
    entries: impl Iterator<Item = Result<Entry, LogError>>,
) -> Result<Replay, ReplayError> {
    let mut again = Again::<N> {
        session: desk_session(scene, model),
        meter: Meter::new(Uncounted),
        waiting: VecDeque::new(),
        taken: 0,
        tick: 0,
        agreed: false,
    };
    let mut replay = Replay::default();
    for entry in entries {
        let Entry { way, frame, .. } = entry?;
        let replayed = match (way, frame) {
            (Direction::Sent, frame @ Frame::Hello(_)) => {
                again.receive(frame);
                (again.waiting, again.taken, again.tick, again.agreed) = (VecDeque::new(), 0, 0, false);
                continue;
            }
            (Direction::Sent, frame) => {
                again.waiting.push_back(frame);
                continue;
            }
            (Direction::Received, Frame::Hello(hello)) => {
                again.agreed |= hello.pacing == Pacing::Live;
                continue;
            }
            (Direction::Received, Frame::Refusal(refusal @ (Refusal::Lost { .. } | Refusal::Undecodable(_)))) => {
                Err(format!("what was sent did not all arrive: {refusal:?}"))
            }
            // An earlier status belongs to the previous session.
            (Direction::Received, Frame::Status(status)) if again.agreed => {
                again.replay(&status).map(|replayed| (status, replayed))
            }
            (Direction::Received, _) => continue,
        };
        match replayed {
            Ok((recorded, replayed)) => {
                replay.ticks += 1;
                // Capacity for points, cost and a drive's fault report cannot be compared; see the table in the parent module.
                let comparable = |status: Status| {
                    let extra = match status.extra {
                        ExtraFields::DriveFault(_) => ExtraFields::Nothing,
                        extra => extra,
                    };
                    Status { room: 0, cost: None, extra, ..status }
                };
                if let Some(difference) = difference(&comparable(recorded), &comparable(replayed)) {
                    replay.differs(difference);
                }
            }
            Err(why) => {
                replay.end = Some(Gap { tick: again.tick.wrapping_add(1), why });
                break;
            }
        }
    }
    Ok(replay)
}

impl<const N: usize> Again<N> {
    fn receive(&mut self, frame: Frame) {
        // Answers are ignored, because their times are not determined. A status holds the result of its tick.
        self.session.receive(Ok(Received { frame, missed: 0 }));
    }

    /// Replays the tick of a status. The error is the reason why that is not possible.
    fn replay(&mut self, recorded: &Status) -> Result<Status, String> {
        let expected = self.tick.wrapping_add(1);
        if recorded.tick != expected {
            return Err(format!("its status is missing; the next one is that of tick {}", recorded.tick));
        }
        let (Some(sensed), Some(_)) = (&recorded.sensed, &recorded.actuation) else {
            return Err("its status does not say what was sensed, or what the drives did".into());
        };
        while self.taken != recorded.taken {
            let Some(frame) = self.waiting.pop_front() else {
                return Err(format!("it had taken {} frames, and {} were sent", recorded.taken, self.taken));
            };
            self.taken = self.taken.wrapping_add(1);
            self.receive(frame);
        }
        self.tell(sensed)?;
        self.session.tick(&self.meter);
        self.tick = recorded.tick;
        let said = std::iter::from_fn(|| self.session.say()).map(Report::frame);
        let status = said.filter_map(|frame| if let Frame::Status(status) = frame { Some(status) } else { None });
        status.last().ok_or_else(|| "the session on the desk was not asked for its status".into())
    }

    /// Gives the session the recorded readings of joints and lines.
    fn tell(&mut self, sensed: &SensedLines) -> Result<(), String> {
        let wrong = |error: link::JointCountMismatch| error.to_string();
        let link::Lines { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature } =
            sensed.lines;
        let drive = |joint: usize| drive_fault >> joint & 1 == 1;
        // A zero is lost only together with a fault of its drive. So without a drive fault, nothing else is lost.
        let lost = if zeroed { JointFaults::NONE } else { JointFaults::LOST };
        let fault = |joint| if drive(joint) { JointFaults::DRIVE | lost } else { JointFaults::NONE };
        let age = |age: u16| if age == u16::MAX { u32::MAX } else { age.into() };
        let readings = Readings {
            sensed: sensed.sensed.to_core().map_err(wrong)?,
            torque: [0.0; N],
            age_ticks: array(&sensed.age_ticks).map_err(wrong)?.map(age),
            faults: core::array::from_fn(fault),
            errors: [0; N],
            on: core::array::from_fn(|joint| on >> joint & 1 == 1),
            zero_lost,
        };
        // A board without joints of its own has neither readings nor zeros.
        let has_joints = zeroed || drive_fault != 0;
        self.session.sense(has_joints.then_some(&readings), &Lines { emergency_stop, supply, temperature });
        if overrun {
            self.session.overrun();
        }
        Ok(())
    }
}
