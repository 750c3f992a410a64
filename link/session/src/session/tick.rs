//! One tick, in a bench mode or under supervision.

use super::change::{Torques, jump};
use super::waiting::Change;
use super::{Buffers, Session};
use crate::meter::{Counter, Meter};
use core::borrow::BorrowMut;
use dynamics_core::control::{ArmBuild, Controller, ControllerConfig, Fault, LimitFlags, TorqueRequest};
use dynamics_core::safety::{self, Actuation, SafeAction};
use link::{Cost, Frame, Pacing, TickCost};

/// Command of a tick to the drives.
#[derive(Clone, Copy, Debug, PartialEq)]
// The tag is a whole word: after a one-byte tag, copies of the rest would start at odd addresses and need three times the instructions.
#[repr(u32)]
pub enum Drives<const N: usize> {
    /// Apply these torques or forces, N m or N.
    Drive([f32; N]),
    /// Perform the safe action.
    Safe(SafeAction),
    /// Switch the drives on, without torque and with brakes engaged; drives that are already on perform this action.
    Enable(SafeAction),
    /// Apply these torques or forces, N m or N, with brakes engaged.
    Preload([f32; N]),
}

impl<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>> Session<N, A, B> {
    /// Runs one tick and returns the command to the drives. [`Session::say`] then returns its report.
    ///
    /// In bench modes the reported cost is that of the controller alone. Nothing is reported while the session waits for a hello, or in a bench
    /// mode before the first reference and measurement.
    #[inline]
    pub fn tick<M: Counter>(&mut self, meter: &Meter<M>) -> Drives<N> {
        let safe = Drives::Safe(self.safe_action());
        let Some(pacing) = self.pacing else { return safe };
        if !core::mem::take(&mut self.fresh) {
            self.tick = self.tick.wrapping_add(1);
            if let Some(measurement) = &mut self.measurement {
                measurement.age_ticks = measurement.age_ticks.saturating_add(1);
            }
        }
        if pacing.is_supervised() {
            return self.supervise(pacing, meter);
        }
        if let (Some(reference), Some(measurement)) = (&self.reference, &self.measurement) {
            let (command, cost) = meter.measure(|| self.controller.tick(reference, measurement));
            self.answer = Some(Frame::answer(self.tick, &command, cost));
        }
        safe
    }

    /// Runs a tick under supervision. Its output is computed in place, in its record of the black box.
    #[inline]
    fn supervise<M: Counter>(&mut self, pacing: Pacing, meter: &Meter<M>) -> Drives<N> {
        // Nearly every tick has no change, and `take` would copy all of the option.
        let change = if self.change.is_some() { self.change.take() } else { None };
        // The change is made first. A request that it could invalidate is rejected in this tick.
        let yields = change.is_some() && self.requests.yields();
        if yields {
            self.supervisor.withdraw();
        }
        let safe = Drives::Safe(self.safe_action());
        let Self { controller, supervisor, buffers, .. } = self;
        let Buffers { trajectory, black_box } = buffers.borrow_mut();
        let Some(record) = black_box.begin(supervisor.state()) else { return safe };
        let (mut alone, mut jumps) = (None, None);
        let led = controller.config().law.is_hand_guided();
        let ((), all) = meter.measure(|| {
            supervisor.tick(&mut record.output, led, |ask, torque, limits| {
                let then = change.as_ref().map(|change| tried(controller, change, ask));
                let (answer, cost) = meter.measure(|| controller.answer(ask, torque, limits));
                alone = cost;
                if let Some(then) = then {
                    jumps = jump(ask, controller.config(), answer.map(|()| (*torque, *limits)), then);
                }
                let answer = match ask.beyond_weight {
                    Some(share) => answer.and_then(|()| ask.near_weight(share, controller, torque, limits)),
                    None => answer,
                };
                if ask.start { answer.and_then(|()| bearable(torque, controller.config())) } else { answer }
            });
        });
        (record.tick, record.taken) = (self.tick, self.taken);
        record.cost = all.map(|all: Cost| TickCost { all, controller: alone });
        record.inputs = *supervisor.inputs();
        let drives = match record.output.actuation {
            // In a dry run no drive is driven: the host simulates the arm.
            Actuation::Safe(action) => Drives::Safe(action),
            _ if pacing != Pacing::Live => safe,
            Actuation::Drive { torque, .. } => Drives::Drive(torque),
            Actuation::Enable(action) => Drives::Enable(action),
            Actuation::Preload { torque, .. } => Drives::Preload(torque),
        };
        supervisor.age(trajectory);
        if self.requests.is_waiting() {
            let refused = if yields { Some(safety::Refusal::ChangePending) } else { record.output.refused };
            record.output.refused = refused;
            let asked = self.requests.settle(refused);
            // The host has cleared the fault after reading all of it: recording resumes.
            if asked == Some(link::Request::Clear) && refused.is_none() && black_box.is_read() {
                black_box.release();
            }
        }
        self.unsaid = true;
        if let Some(change) = change {
            self.settle(&change, jumps);
        }
        drives
    }
}

/// Computes the controller's answer after a change. Not inlined, so that only a tick with a change has a second controller on the stack.
#[cold]
#[inline(never)]
fn tried<const N: usize, A: ArmBuild<f32, N>>(
    controller: &Controller<f32, N, A>,
    change: &Change<N>,
    ask: &TorqueRequest<'_, f32, N>,
) -> Result<Torques<N>, Fault> {
    let mut trial = controller.clone();
    change.make(&mut trial);
    let (mut torque, mut limits) = ([0.0; N], [LimitFlags::NONE; N]);
    trial.answer(ask, &mut torque, &mut limits).map(|()| (torque, limits))
}

/// Checks that the first torques after arming can hold the arm: a joint that needs more than its torque limit cannot. Live inputs and parameters
/// that were changed while no torque acted were not checked for jumps; this check covers them.
#[cold]
fn bearable<const N: usize>(torque: &[f32; N], config: &ControllerConfig<f32, N>) -> Result<(), Fault> {
    let over = |i: usize| torque[i].is_finite() && torque[i].abs() > config.limits[i].torque;
    match (0..N).find(|&i| over(i)) {
        Some(joint) => Err(Fault::Overload { joint: joint as u8 }),
        None => Ok(()),
    }
}
