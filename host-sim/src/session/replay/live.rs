//! A record of a board that its own timer paced: each status says what its tick was told.

use super::{Gap, Replay, ReplayError, difference};
use crate::session::drill::{DeskSession, Uncounted, desk_session};
use crate::session::frame_log::{Entry, LogError, Way};
use dynamics_core::Model;
use link::codec::Received;
use link::convert::array;
use link::{Frame, Pacing, Refusal, SensedLines, Status};
use robot_compiler::SceneFile;
use session::black_box::Report;
use session::meter::Meter;
use session::readings::Lines;
use session::readings::{JointFaults, Readings};
use std::collections::VecDeque;

/// The board again.
struct Again<const N: usize> {
    session: DeskSession<N>,
    meter: Meter<Uncounted>,
    /// Frames that were sent and that no tick is known to have followed.
    waiting: VecDeque<Frame>,
    /// Frames that were taken, modulo 65,536.
    taken: u16,
    /// The tick that was replayed last.
    tick: u32,
    /// The board has answered the hello.
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
            (Way::Sent, frame @ Frame::Hello(_)) => {
                again.receive(frame);
                (again.waiting, again.taken, again.tick, again.agreed) = (VecDeque::new(), 0, 0, false);
                continue;
            }
            (Way::Sent, frame) => {
                again.waiting.push_back(frame);
                continue;
            }
            (Way::Received, Frame::Hello(hello)) => {
                again.agreed |= hello.pacing == Pacing::Live;
                continue;
            }
            (Way::Received, Frame::Refusal(refusal @ (Refusal::Lost { .. } | Refusal::Undecodable(_)))) => {
                Err(format!("what was sent did not all arrive: {refusal:?}"))
            }
            // Before that it is one of the session before.
            (Way::Received, Frame::Status(status)) if again.agreed => {
                again.replay(&status).map(|replayed| (status, replayed))
            }
            (Way::Received, _) => continue,
        };
        match replayed {
            Ok((recorded, replayed)) => {
                replay.ticks += 1;
                // Neither can be the same; see the module above.
                let comparable = |status: Status| Status { room: 0, cost: None, ..status };
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
        // What is answered comes when it comes; what a tick did is in its status.
        self.session.receive(Ok(Received { frame, missed: 0 }));
    }

    /// The tick of a status; an error says why it cannot be replayed.
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

    /// What the board's joints and lines said.
    fn tell(&mut self, sensed: &SensedLines) -> Result<(), String> {
        let wrong = |error: link::JointCountMismatch| error.to_string();
        let link::Lines { emergency_stop, overrun, zeroed, drive_fault, supply, temperature } = sensed.lines;
        let drive = |joint: usize| drive_fault >> joint & 1 == 1;
        // A lost turn is a fault of its drive too, so that nothing else is lost where there is none.
        let lost = if zeroed { JointFaults::NONE } else { JointFaults::LOST };
        let fault = |joint| if drive(joint) { JointFaults::DRIVE | lost } else { JointFaults::NONE };
        let age = |age: u16| if age == u16::MAX { u32::MAX } else { age.into() };
        let readings = Readings {
            sensed: sensed.sensed.to_core().map_err(wrong)?,
            torque: [0.0; N],
            age_ticks: array(&sensed.age_ticks).map_err(wrong)?.map(age),
            faults: core::array::from_fn(fault),
        };
        // Without joints of its own a board knows neither readings nor zeros.
        let has_joints = zeroed || drive_fault != 0;
        self.session.sense(has_joints.then_some(&readings), &Lines { emergency_stop, supply, temperature });
        if overrun {
            self.session.overrun();
        }
        Ok(())
    }
}
