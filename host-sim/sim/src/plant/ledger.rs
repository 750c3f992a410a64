//! Energy put into the arm and taken out of it.

use super::dynamics::Mechanism;
use super::{JointFriction, State};
use dynamics_core::chapter::work::WorkMeter;

/// Work on the arm while its actuators drive it, by the trapezoid rule over the steps of the integration. It excludes
/// the work of the brakes.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger<const N: usize> {
    /// Work of each actuator, with the real torque after delay, saturation and lag.
    pub actuators: WorkMeter<f64, N>,
    /// Work of each joint's friction; all of it is negative.
    pub friction: WorkMeter<f64, N>,
    /// Work of the wrench at the tip, as the joints feel it.
    pub contact: WorkMeter<f64, N>,
    /// State at the start.
    pub start: State<N>,
    /// State at the end of the last step.
    pub end: State<N>,
}

impl<const N: usize> Ledger<N> {
    pub(super) fn new(start: State<N>) -> Self {
        let none = WorkMeter::new();
        Self { actuators: none, friction: none, contact: none, start, end: start }
    }

    /// Adds a step of `h` (s) between two states under their torques.
    pub(super) fn step(
        &mut self,
        h: f64,
        ends: &[([f64; N], State<N>); 2],
        friction: Option<&[JointFriction; N]>,
        mechanism: &Mechanism<N>,
    ) {
        let [(before, from), (after, to)] = ends;
        self.actuators.step(h, (before, &from.qd), (after, &to.qd));
        if let Some(friction) = friction {
            let opposed = |drive: &[f64; N], state: &State<N>| -> [f64; N] {
                core::array::from_fn(|i| -friction[i].torque_under(drive[i], state.qd[i]))
            };
            self.friction.step(h, (&opposed(before, from), &from.qd), (&opposed(after, to), &to.qd));
        }
        if let (Some(before), Some(after)) = (mechanism.contact(&from.q), mechanism.contact(&to.q)) {
            self.contact.step(h, (&before, &from.qd), (&after, &to.qd));
        }
        self.end = *to;
    }
}
