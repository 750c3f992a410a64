//! One tick, on the bench or under supervision.

use super::change::{Torques, jump};
use super::waiting::Change;
use super::{Buffers, Session};
use crate::meter::{Counter, Meter};
use core::borrow::BorrowMut;
use dynamics_core::control::{ArmBuild, Controller, ControllerConfig, Fault, LimitFlags, TorqueRequest};
use dynamics_core::safety::{self, Actuation, SafeAction};
use link::{Cost, Frame, Pacing, TickCost};

/// Order of a tick to the drives.
#[derive(Clone, Copy, Debug, PartialEq)]
// A tag of a word: behind a byte, copies of the rest start at odd addresses, at three times the instructions.
#[repr(u32)]
pub enum Drives<const N: usize> {
    /// These torques or forces, N m or N.
    Drive([f32; N]),
    /// The safe action.
    Safe(SafeAction),
    /// Switch the drives on, without torque, brakes engaged; meanwhile a drive that is on does this.
    Enable(SafeAction),
    /// These torques or forces, N m or N, brakes engaged.
    Preload([f32; N]),
}

impl<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>> Session<N, A, B> {
    /// Run one tick, and return the order to the drives. Its report waits in [`Session::say`].
    ///
    /// The bench's cost is that of the controller alone. Nothing is reported while the session waits, or while the
    /// timer already runs on the bench but reference or measurement has not come yet.
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

    /// A tick under supervision. The black box's place for it is where it is computed.
    #[inline]
    fn supervise<M: Counter>(&mut self, pacing: Pacing, meter: &Meter<M>) -> Drives<N> {
        // Nearly every tick has none, and taking it would copy all of it.
        let change = if self.change.is_some() { self.change.take() } else { None };
        // The change is settled first. A request that it could falsify is not judged in the same tick.
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
            // Cleared by a host that has read it all: the black box goes on.
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

/// Answer that the controller would give after a change. Out of line: nearly every tick does without a second controller on the stack.
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

/// The first torques of an arm that is armed, at rest and where it should be: they hold the arm. A joint whose torque limit acts
/// cannot. What was told while no torque acted has jumped from nothing, and this is where it is judged.
#[cold]
fn bearable<const N: usize>(torque: &[f32; N], config: &ControllerConfig<f32, N>) -> Result<(), Fault> {
    let over = |i: usize| torque[i].is_finite() && torque[i].abs() > config.limits[i].torque;
    match (0..N).find(|&i| over(i)) {
        Some(joint) => Err(Fault::Overload { joint: joint as u8 }),
        None => Ok(()),
    }
}
