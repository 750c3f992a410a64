//! State of the machine, and the types of a decision about it.

use super::heat::Heats;
use super::measured::{JudgedInput, Sensors};
use super::{Inputs, Refusal, State};
use crate::control::{Fault, LimitFlags, Reference};
use crate::scalar::Real;

/// State of the machine from tick to tick, except the observer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MachineMemory<S, const N: usize> {
    pub(super) state: State,
    pub(super) homed: bool,
    pub(super) sensors: Sensors<S, N>,
    /// Reference of the controller while torque acts.
    pub(super) reference: Reference<S, N>,
    /// Limits on that reference that the machine, not the controller, has applied: the reference is beyond a position limit.
    pub(super) held: Option<[LimitFlags; N]>,
    /// The torque that acts, N m or N. `limits` are the limits that acted on it.
    pub(super) torque: [S; N],
    pub(super) limits: [LimitFlags; N],
    /// Number of ticks in which torque has acted without the host.
    pub(super) alone: u32,
    /// True if the controller was compliant in the last tick because of a collision, and did not follow its reference.
    pub(super) gave_way: bool,
    /// True if the limits of the first motion are lifted.
    pub(super) full_range: bool,
    /// True if the arm stops along its path: the host's reference gets slower in every tick.
    pub(super) along: bool,
    /// Time left for the stop along the path, s. After that every joint stops on its own.
    pub(super) along_left: S,
    /// Progress of arming.
    pub(super) arming: Arming,
    /// Pace of lowering, 0 to 1.
    pub(super) pace: S,
    /// Number of ticks in which the reference was at the rest pose, or could not move.
    pub(super) settled: u32,
    /// Number of ticks of lowering in which the reference has waited for a joint.
    pub(super) waited: u32,
    /// True if it waits now.
    pub(super) waits: bool,
    /// Fault that is raised at the end of disarming.
    pub(super) ends_in: Option<Fault>,
    /// Heat of the motors.
    pub(super) heats: Heats<S, N>,
}

/// Progress of [`State::Arming`], and of [`State::Disarming`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Arming {
    /// Ticks in this state.
    pub(super) ticks: u32,
    /// True if all drives are on, and torque acts on engaged brakes.
    pub(super) preloads: bool,
    /// Number of ticks in which the drives carried the whole weight of the arm.
    pub(super) carried: u32,
}

impl Arming {
    pub(super) const START: Self = Self { ticks: 0, preloads: false, carried: 0 };
}

/// Inputs of one decision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now<'a, S, const N: usize> {
    pub(super) inputs: &'a Inputs<S, N>,
    /// The host's reference, or that of a hand-guided arm.
    pub(super) reference: Option<&'a Reference<S, N>>,
    pub(super) seen: &'a JudgedInput<'a, S, N>,
    /// True if the host has not been heard for too long.
    pub(super) silent: bool,
    /// True if the arm is hand-guided: the reference is its own position.
    pub(super) hand_guided: bool,
}

/// Action of the drives that the rules allow. For the first four the controller computes a torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Action {
    /// Torque may act, along the memory's reference.
    Drive,
    /// As `Drive`, without a limit on the torque rate.
    DriveAtOnce,
    /// Torque with engaged brakes: for the weight of an arm at rest at the memory's reference, or along the reference while the arm is disarmed.
    Preload,
    /// Switch the drives on, if the controller can compute a torque that holds the arm.
    EnableFirst,
    /// Switch the drives on.
    Enable,
    /// The safe action.
    Safe,
}

impl Action {
    /// True if torque is to act with open brakes.
    #[inline]
    pub(super) fn drives(self) -> bool {
        self <= Self::DriveAtOnce
    }

    /// True if the controller computes a torque.
    #[inline]
    pub(super) fn asks(self) -> bool {
        self <= Self::EnableFirst
    }
}

/// Action of the drives, and the reason for which the request was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Decision {
    pub(super) action: Action,
    pub(super) refused: Option<Refusal>,
}

impl Decision {
    /// This action; no request was rejected.
    pub(super) const fn of(action: Action) -> Self {
        Self { action, refused: None }
    }

    /// The safe action.
    pub(super) const fn safe(refused: Option<Refusal>) -> Self {
        Self { action: Action::Safe, refused }
    }

    /// The same decision with this request rejected, unless it was already.
    pub(super) fn refusing(self, refusal: Option<Refusal>) -> Self {
        Self { refused: self.refused.or(refusal), ..self }
    }
}

impl<S: Real, const N: usize> MachineMemory<S, N> {
    /// Idle, not homed.
    pub(super) fn new() -> Self {
        let zero = [S::zero(); N];
        Self {
            state: State::Idle,
            homed: false,
            sensors: Sensors::new(),
            reference: Reference { q: zero, qd: zero, qdd: zero },
            held: None,
            torque: zero,
            limits: [LimitFlags::NONE; N],
            alone: 0,
            gave_way: false,
            full_range: false,
            along: false,
            along_left: S::zero(),
            arming: Arming::START,
            pace: S::zero(),
            settled: 0,
            waited: 0,
            waits: false,
            ends_in: None,
            heats: Heats::cold(),
        }
    }

    /// Stores an ordinary tick: the arm goes on. Out of line, the compiler knows that nothing overlaps, and copies without a call.
    #[inline(never)]
    pub(super) fn go_on(&mut self, read: &[S; N], reference: &Reference<S, N>) {
        self.sensors.last = *read;
        self.reference.q = reference.q;
        self.reference.qd = reference.qd;
        self.reference.qdd = reference.qdd;
        self.alone = 0;
    }
}
