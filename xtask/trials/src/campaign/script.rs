//! The script of every run: bring the machine to a state, disturb it for a while, and send every request that leads back to torque.

use super::case::{Case, Situation};
use super::fault::FaultKind;
use super::host::Host;
use super::judge::Unsafe;
use super::machine::MachineError;
use super::outcome::{Counterexample, Finished, Motion, Number, Outcome};
use super::random::Random;
use link::StateCode;
use link::codec::FrameTooLong;
use link::{Frame, Request, Status};
use sim::failure::Failure;
use std::path::PathBuf;

/// Reason why a run ended early.
#[derive(Debug)]
pub(super) enum Stop {
    Unsafe {
        broken: Option<Unsafe>,
        what: String,
        inputs: String,
    },
    Machine(MachineError),
    /// The machine did not reach the state of the case.
    NotReached(Box<Status>),
}

impl From<FrameTooLong> for Stop {
    fn from(error: FrameTooLong) -> Self {
        Self::Machine(MachineError::Chip(error.into()))
    }
}

/// Longest wait for a state that the machine reaches without a request, ticks.
const PATIENCE: u32 = 20_000;

/// A run in progress, tick by tick.
pub(super) trait Script<const N: usize> {
    /// The host.
    fn host(&mut self) -> &mut Host<N>;

    /// Random numbers of the run.
    fn random(&mut self) -> &mut Random;

    /// Status of the last tick.
    fn status(&self) -> Option<&Status>;

    /// The live inputs as they should be.
    fn live(&self) -> Frame;

    /// True if the scene limits the first motion after homing.
    fn limits_first_motion(&self) -> bool;

    /// Runs a tick without a fault.
    fn step(&mut self) -> Result<(), Stop>;

    /// Runs a tick with the emergency stop pressed.
    fn press(&mut self) -> Result<(), Stop>;

    /// Sends the beginning of the scene's motion.
    fn begin_motion(&mut self) -> Result<(), Stop>;

    /// Draws the fault of a case, and returns its duration in ticks.
    fn begin_fault(&mut self, case: Case) -> Result<u32, Stop>;

    /// Runs tick number `k` of the fault, counted from 0.
    fn disturbed(&mut self, k: u32) -> Result<(), Stop>;

    /// Ends the fault.
    fn end_fault(&mut self) {}

    /// Silences the host until the fault ends.
    fn lose_host(&mut self) {}

    /// True if the host homes the arm again on the way back to torque.
    fn homes_again(&mut self) -> bool {
        true
    }

    /// Duration of arming, ticks.
    fn arming(&self) -> u32 {
        1
    }

    /// Duration of disarming, ticks.
    fn disarming(&self) -> u32 {
        0
    }

    /// State of the machine.
    fn state(&self) -> StateCode {
        self.status().map_or(StateCode::Idle, |status| status.state)
    }

    /// State and cause of the machine.
    fn where_it_is(&self) -> (StateCode, u8) {
        (self.state(), self.status().map_or(0, |status| status.cause))
    }

    /// Runs the whole script.
    fn play(&mut self, case: Case) -> Result<Outcome, Stop> {
        self.approach(case.situation)?;
        let before = self.where_it_is();
        if before.0 != case.situation.state() {
            let status = self.status().cloned();
            return Err(status.map_or(Stop::Machine(MachineError::Unreported(0)), |s| Stop::NotReached(Box::new(s))));
        }
        let ticks = self.begin_fault(case)?;
        let mut outcome = Outcome::Unaffected;
        for k in 0..ticks {
            // Simulate a host that clears faults without checking.
            if case.fault != FaultKind::Nothing && self.random().chance(0.05) {
                self.host().ask(Request::Clear)?;
            }
            self.disturbed(k)?;
            outcome = self.observed_outcome(outcome, before);
        }
        self.end_fault();
        for _ in 0..self.random().whole(5, 40) {
            self.step()?;
            outcome = self.observed_outcome(outcome, before);
        }
        if case.fault != FaultKind::Nothing && self.random().chance(0.5) {
            self.recover()?;
        }
        Ok(outcome)
    }

    /// Outcome so far: the first fault counts, otherwise the first hold.
    fn observed_outcome(&self, so_far: Outcome, before: (StateCode, u8)) -> Outcome {
        let now = self.where_it_is();
        match (so_far, now) {
            (Outcome::Fault(_), _) => so_far,
            (_, (StateCode::Fault, code)) if before.0 != StateCode::Fault => Outcome::Fault(code),
            (Outcome::Held(_), _) => so_far,
            (_, (StateCode::Holding, cause)) if before.0 != StateCode::Holding => Outcome::Held(cause),
            _ if now != before => Outcome::Asked,
            _ => so_far,
        }
    }

    /// Brings the machine to a state and waits there.
    fn approach(&mut self, situation: Situation) -> Result<(), Stop> {
        let live = self.live();
        self.host().send(&live)?;
        self.wait(3, 10)?;
        let requests: &[Request] = match situation {
            Situation::Idle => &[],
            Situation::Homing => &[Request::Home],
            Situation::Homed => &[Request::Home, Request::Confirm],
            _ => &[Request::Home, Request::Confirm, Request::Arm],
        };
        for request in requests {
            self.host().ask(*request)?;
            self.step()?;
            self.lift_limits_after(*request)?;
            if situation == Situation::Arming && *request == Request::Arm {
                let most = self.arming().saturating_sub(3);
                return self.wait(0, most);
            }
            while self.state() == StateCode::Arming {
                self.step()?;
            }
        }
        match situation {
            Situation::Running | Situation::Holding | Situation::Lowering => {
                self.wait(30, 60)?;
                self.begin_motion()?;
                self.host().ask(Request::Run)?;
                // An arm close to its rest pose would reach it at once.
                self.wait(if situation == Situation::Lowering { 100 } else { 1 }, 400)?;
            }
            Situation::Fault => {
                self.wait(0, 40)?;
                self.press()?;
            }
            _ => {}
        }
        if situation == Situation::Holding {
            self.host().ask(Request::Hold)?;
        }
        if situation == Situation::Disarming {
            self.wait(0, 60)?;
            // A drive's coarsely quantised speed may look like motion for a tick, and the machine then refuses to disarm.
            for _ in 0..PATIENCE {
                self.host().ask(Request::Disarm)?;
                self.step()?;
                if self.state() == StateCode::Disarming {
                    break;
                }
            }
            let most = self.disarming().saturating_sub(3);
            return self.wait(0, most);
        }
        if situation == Situation::Lowering {
            self.lose_host();
            for _ in 0..PATIENCE {
                if self.state() == StateCode::Lowering {
                    break;
                }
                self.step()?;
            }
        }
        self.wait(1, 60)
    }

    /// Requests to clear the fault and return to torque, even if the machine refuses.
    fn recover(&mut self) -> Result<(), Stop> {
        let homes = self.homes_again();
        for request in [Request::Clear, Request::Home, Request::Confirm, Request::Arm, Request::Run, Request::Hold] {
            if !homes && matches!(request, Request::Home | Request::Confirm) {
                continue;
            }
            self.host().ask(request)?;
            self.wait(1, 8)?;
            self.lift_limits_after(request)?;
            while self.state() == StateCode::Arming {
                self.step()?;
            }
        }
        Ok(())
    }

    /// After homing, lifts the limits of the first motion, because faults are judged at full speed and torque.
    fn lift_limits_after(&mut self, request: Request) -> Result<(), Stop> {
        if request == Request::Confirm && self.limits_first_motion() {
            self.host().ask(Request::FullRange)?;
            self.step()?;
        }
        Ok(())
    }

    /// Runs some ticks without a fault.
    fn wait(&mut self, least: u32, most: u32) -> Result<(), Stop> {
        for _ in 0..self.random().whole(least, most) {
            self.step()?;
        }
        Ok(())
    }
}

/// Returns the result of a run that has ended.
///
/// # Errors
/// [`Failure::Target`] if the chip fails; [`Failure::Input`] if the scene's machine does not reach the state.
pub(super) fn finish(
    (scene, path): &(String, PathBuf),
    case: Case,
    Number { seed, run }: Number,
    tick: u32,
    motion: Motion,
    played: Result<Outcome, Stop>,
) -> Result<Finished, Failure> {
    let (outcome, counterexample) = match played {
        Ok(outcome) => (outcome, None),
        Err(Stop::Machine(error)) => return Err(Failure::Target(miette::Report::from_err(error))),
        Err(Stop::NotReached(status)) => {
            return Err(Failure::Input(miette::miette!(
                help = "expected a scene whose arm stands at the start of its motion and can be driven from there",
                "{}: with --seed {seed} --run {run} the machine does not come to the state `{}`: {status:?}",
                path.display(),
                case.situation.name()
            )));
        }
        Err(Stop::Unsafe { broken, what, inputs }) => {
            let law = broken.map(|broken| broken.law);
            (
                Outcome::Unaffected,
                Some(Counterexample { scene: scene.clone(), seed, run, tick, case, law, what, inputs }),
            )
        }
    };
    Ok(Finished { case, outcome, ticks: tick, motion, counterexample })
}
