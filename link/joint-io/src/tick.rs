//! The order of a tick.

use crate::{JointIo, higher};
use core::borrow::BorrowMut;
use dynamics_core::control::ArmBuild;
use session::meter::{Counter, Meter};
use session::readings::Lines;
use session::{Buffers, Drives, Session};

/// Runs one tick of a board: measurement, session, outputs. Returns true if the tick ended in time.
///
/// `is_due` returns true if the next tick is due already. It is called twice:
/// - after the session and before the outputs: if the tick is late then, it performs the safe action, because its torque is old;
/// - after the last output: if the tick is late then, for whatever reason, the next tick reports the overrun and performs the safe action.
///
/// Do actions that require a tick in time, such as feeding a watchdog, only if this returns true.
#[inline]
pub fn run_tick<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>, M: Counter>(
    session: &mut Session<N, A, B>,
    joints: &mut (impl JointIo<N> + ?Sized),
    meter: &Meter<M>,
    lines: impl FnOnce() -> Lines,
    is_due: impl Fn() -> bool,
) -> bool {
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
