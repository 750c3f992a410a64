//! Ticks of both sessions, and their properties.

use super::Comparison;
use crate::campaign::TickOutput;
use crate::campaign::judge::Heard;
use crate::fuzz::packets::all_bits;
use board::session::dry_run::DeskSession;
use dynamics_core::Reference;
use dynamics_core::control::Sensed;
use link::{ExtraFields, Frame, Measurement, Pacing, StateCode, Status};
use session::Drives;
use session::black_box::Report;
use session::readings::{JointFaults, Readings};

impl<const N: usize> Comparison<N> {
    /// Sensor reading of the arm.
    pub(super) fn reading(&self) -> Sensed<f32, N> {
        if !self.counted {
            return Sensed::State { q: self.q, qd: self.qd };
        }
        Sensed::Counts(core::array::from_fn(|i| {
            let encoder = &self.config.encoder[i];
            encoder.zero.wrapping_add((self.q[i] / encoder.per_count).round() as i32)
        }))
    }

    /// Starts a tick as the pacing requires: by the board's timer, or by a measurement of the host.
    pub(super) fn time(&mut self) {
        if self.pacing().is_some_and(Pacing::is_lock_step) {
            let (sensed, ages, _) = self.odd.take().unwrap_or((self.reading(), [0; N], [JointFaults::NONE; N]));
            let age_ticks = ages.into_iter().max().unwrap_or(0);
            let measurement = Measurement { tick: self.ticks, age_ticks, sensed: link::Sensed::new(&sensed) };
            self.send(&Frame::Measurement(measurement));
        } else {
            self.tick();
        }
    }

    /// Passes the readings of the board's own lines and joints to the sessions. They count only in a live session.
    fn sense(&mut self) {
        let (sensed, age_ticks, faults) = self.odd.take().unwrap_or((self.reading(), [0; N], [JointFaults::NONE; N]));
        let sees = self.blind == 0;
        self.blind = self.blind.saturating_sub(1);
        let readings = sees.then_some(Readings {
            sensed,
            torque: [0.0; N],
            age_ticks,
            faults,
            errors: [0; N],
            on: [true; N],
            zero_lost: false,
        });
        self.session.sense(readings.as_ref(), &self.lines);
        self.twin.sense(readings.as_ref(), &self.lines);
        if self.pacing() != Some(Pacing::Live) {
            return;
        }
        self.told.emergency_stop = self.lines.emergency_stop;
        (self.told.supply, self.told.temperature) = (self.lines.supply, self.lines.temperature);
        if sees {
            (self.told.sensed, self.told.age_ticks) = (sensed, age_ticks);
            // A missing measurement is recognised by its age.
            self.told.drive_fault = faults.map(|faults| faults.bits() & !JointFaults::MISSING.bits() != 0);
            self.told.zeroed = !faults.iter().any(|faults| faults.contains(JointFaults::LOST));
        }
    }

    /// Runs a tick of both sessions.
    pub(super) fn tick(&mut self) {
        self.ticks += 1;
        self.sense();
        let drives = self.session.tick(&self.meter);
        let same = self.twin.tick(&self.meter);
        assert_eq!(torque_bits(&drives), torque_bits(&same), "{drives:?} and {same:?}");
        let (said, full) = (said(&mut self.session), said(&mut self.twin));
        let (status, answers) = split(said);
        let (complete, others) = split(full);
        assert!(answers.iter().map(all_bits).eq(others.iter().map(all_bits)), "{answers:?} and {others:?}");
        match self.pacing() {
            Some(pacing) if pacing.is_supervised() => {
                let complete = complete.unwrap();
                if let Some(status) = status {
                    self.agree(&status, &complete);
                }
                self.judge(pacing, &drives, &complete);
                self.states[usize::from(complete.state.code())] += 1;
                self.move_arm(&complete);
            }
            _ => {
                assert!(matches!(drives, Drives::Safe(_)), "driven on the bench: {drives:?}");
                assert!(status.is_none() && complete.is_none(), "a status on the bench");
                answers.iter().for_each(|answer| self.keeps_limits(answer));
            }
        }
        // The next tick starts without new input.
        (self.asked, self.spoke, self.changes, self.told.overrun) = (None, false, false, false);
        self.told.age_ticks = self.told.age_ticks.map(|age| age.saturating_add(1));
    }

    /// Checks a supervised tick against the safety properties.
    fn judge(&mut self, pacing: Pacing, drives: &Drives<N>, status: &Status) {
        let heard = Heard { requests: self.asked.as_slice(), spoke: self.spoke, exact: true };
        self.told.tick = self.ticks;
        let acts = self.judge.acts(pacing, drives, status);
        let judged = acts
            .and_then(|drives| self.judge.watch(&self.told, &heard, &TickOutput { drives, status: status.clone() }));
        if let Err(broken) = judged {
            panic!("{broken:?}: told {:?}, heard {heard:?}, {drives:?}, {status:?}", self.told);
        }
    }

    /// Checks that a report agrees with the complete one in all parts that it contains.
    fn agree(&self, status: &Status, complete: &Status) {
        assert_eq!(status.taken, self.taken, "frames taken");
        let cut = Status {
            taken: status.taken,
            actuation: complete.actuation.clone().filter(|_| status.actuation.is_some()),
            sensed: complete.sensed.clone().filter(|_| status.sensed.is_some()),
            // External torques and a joint's fault report are in no record.
            extra: match &status.extra {
                ExtraFields::Reference(_) => complete.extra.clone(),
                other => other.clone(),
            },
            ..complete.clone()
        };
        let (a, b) = (Frame::Status(status.clone()), Frame::Status(cut));
        assert_eq!(all_bits(&a), all_bits(&b), "{a:?} and {b:?}");
    }

    /// Checks that a command in bench mode keeps the torque limits.
    fn keeps_limits(&self, answer: &Frame) {
        if let Frame::Command(command) = answer {
            for (tau, limits) in command.torque.iter().zip(&self.config.limits) {
                assert!(tau.is_finite() && tau.abs() <= limits.torque, "{command:?}");
            }
        }
    }

    /// Moves the arm to the reference, or keeps it at rest.
    fn move_arm(&mut self, status: &Status) {
        let reference = status.reference().filter(|_| status.state == StateCode::Running);
        match reference.map(|reference| reference.to_core::<N>().unwrap()) {
            Some(Reference { q, qd, .. }) => (self.q, self.qd) = (q, qd),
            None => self.qd = [0.0; N],
        }
    }
}

/// All frames that a session has to send.
pub(super) fn said<const N: usize>(session: &mut DeskSession<N>) -> Vec<Frame> {
    core::iter::from_fn(|| session.say()).map(Report::frame).collect()
}

/// Splits frames into the status of the tick and all others. Of a black-box tick only the parts that do not depend on the link remain.
fn split(said: Vec<Frame>) -> (Option<Status>, Vec<Frame>) {
    let mut status = None;
    let mut others = Vec::new();
    for frame in said {
        match frame {
            Frame::Status(only) => assert!(status.replace(only).is_none(), "two statuses of a tick"),
            Frame::Past(Some(past)) => others.push(Frame::Past(Some(Status { taken: 0, ..past }))),
            other => others.push(other),
        }
    }
    (status, others)
}

fn torque_bits<const N: usize>(drives: &Drives<N>) -> Option<[u32; N]> {
    match drives {
        Drives::Drive(torque) | Drives::Preload(torque) => Some(torque.map(f32::to_bits)),
        Drives::Safe(_) | Drives::Enable(_) => None,
    }
}
