//! One tick, on the bench or under supervision.

use super::change::jump;
use super::{Buffers, Session};
use crate::meter::{Counter, Meter};
use core::borrow::BorrowMut;
use dynamics_core::control::{Command, Configuration, Controller, Fault, LimitFlags, Protection, Reading, Reference};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{self, Actuation, SafeAction};
use dynamics_core::trig::Trig;
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
}

impl<const N: usize, D, T, K, C, P, B> Session<N, D, T, K, C, P, B>
where
    B: BorrowMut<Buffers<N>>,
    D: InverseDynamics<f32, N> + Clone,
    T: Trig<f32> + Clone,
    K: safety::Configuration<f32, N> + Clone,
    C: Configuration<f32, N> + Clone,
    P: Protection<f32, N> + Clone,
{
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
            let reading = Reading::Measured(measurement);
            let (command, cost) = control(&mut self.controller, meter, false, reference, reading);
            self.answer = Some(Frame::answer(self.tick, &command, cost));
        }
        safe
    }

    /// A tick under supervision.
    #[inline]
    fn supervise<M: Counter>(&mut self, pacing: Pacing, meter: &Meter<M>) -> Drives<N> {
        // Nearly every tick has none, and taking it would copy all of it.
        let change = if self.change.is_some() { self.change.take() } else { None };
        let Self { controller, supervisor, .. } = self;
        let (mut alone, mut jumps) = (None, None);
        let (output, all) = meter.measure(|| {
            supervisor.tick(|ask| {
                let trial = change.map(|change| {
                    let mut trial = controller.clone();
                    change.make(&mut trial);
                    trial
                });
                let reading = Reading::Judged { q: ask.q, qd: ask.qd };
                let (command, cost) = control(controller, meter, ask.start, ask.reference, reading);
                if let Some(mut trial) = trial {
                    let (other, _) = control(&mut trial, meter, ask.start, ask.reference, reading);
                    jumps = jump(&command, &other, controller.config());
                }
                alone = cost;
                if ask.start { bearable(command) } else { command }
            })
        });
        let cost = all.map(|all: Cost| TickCost { all, controller: alone });
        let (tick, taken) = (self.tick, self.taken);
        let Buffers { trajectory, black_box } = self.buffers.borrow_mut();
        if let Some(record) = black_box.begin() {
            // One part after the other: made as a whole it would be copied once more.
            (record.tick, record.taken, record.cost) = (tick, taken, cost);
            record.inputs.copy_from(supervisor.inputs());
            record.output = output;
        }
        supervisor.age(trajectory);
        self.unsaid = true;
        if let Some(change) = change {
            self.settle(&change, jumps);
        }
        match output.actuation {
            // In a drill no drive is driven: the host simulates the arm.
            Actuation::Drive { torque, .. } if pacing == Pacing::Live => Drives::Drive(torque),
            Actuation::Drive { .. } => Drives::Safe(self.safe_action()),
            Actuation::Safe(action) => Drives::Safe(action),
        }
    }
}

/// The first command of an arm that is armed, at rest and where it should be: it holds the arm. A joint whose torque limit acts
/// cannot. What was told while no torque acted has jumped from nothing, and this is where it is judged.
#[cold]
fn bearable<const N: usize>(command: Command<f32, N>) -> Command<f32, N> {
    let Command::Drive { limits, .. } = &command else { return command };
    match limits.iter().position(|flags| flags.contains(LimitFlags::TORQUE)) {
        Some(joint) => Command::Brake(Fault::Overload { joint: joint as u8 }),
        None => command,
    }
}

/// The controller's tick, and its own cost. Out of line, so that bench and supervision share one copy of it.
#[inline(never)]
fn control<const N: usize, D, T, C, P, M>(
    controller: &mut Controller<f32, N, D, T, C, P>,
    meter: &Meter<M>,
    start: bool,
    reference: &Reference<f32, N>,
    reading: Reading<'_, f32, N>,
) -> (Command<f32, N>, Option<Cost>)
where
    D: InverseDynamics<f32, N>,
    T: Trig<f32>,
    C: Configuration<f32, N>,
    P: Protection<f32, N>,
    M: Counter,
{
    if start {
        controller.reset();
    }
    meter.measure(|| controller.tick_from(reference, reading))
}
