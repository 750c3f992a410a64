//! The order of a tick.

use crate::{JointIo, higher};
use core::borrow::BorrowMut;
use dynamics_core::control::{Configuration, Protection};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety;
use dynamics_core::trig::Trig;
use session::meter::{Counter, Meter};
use session::readings::Lines;
use session::{Buffers, Drives, Session};

/// Runs one tick of a board: measurement, session, outputs. Returns true if the tick ended in time.
///
/// `is_due` tells that the next tick is due already. It is asked twice:
/// - after the session, before the outputs: a tick that is late then does the safe action, because its torque is old;
/// - after the last output, wherever the time went: the next tick reports the overrun, and is the safe action.
///
/// Actions that need a tick in time, such as feeding a watchdog, come after it.
#[inline]
pub fn run_tick<const N: usize, D, T, K, C, P, B, M: Counter>(
    session: &mut Session<N, D, T, K, C, P, B>,
    joints: &mut impl JointIo<N>,
    meter: &Meter<M>,
    lines: impl FnOnce() -> Lines,
    is_due: impl Fn() -> bool,
) -> bool
where
    B: BorrowMut<Buffers<N>>,
    D: InverseDynamics<f32, N> + Clone,
    T: Trig<f32> + Clone,
    K: safety::Configuration<f32, N> + Clone,
    C: Configuration<f32, N> + Clone,
    P: Protection<f32, N> + Clone,
{
    let readings = joints.measure();
    let mut lines = lines();
    lines.temperature = higher(lines.temperature, joints.temperature());
    session.sense(readings.as_ref(), &lines);
    if session.clears() {
        joints.clear();
    }
    match session.tick(meter) {
        Drives::Safe(action) => joints.safe(action),
        _ if is_due() => joints.safe(session.safe_action()),
        Drives::Drive(torque) => joints.drive(&torque, session.springs().as_ref()),
        Drives::Enable(action) => joints.enable(action),
        Drives::Preload(torque) => joints.preload(&torque, session.springs().as_ref()),
    }
    let late = is_due();
    if late {
        session.overrun();
    }
    !late
}
