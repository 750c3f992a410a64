//! The laws of safety, and violations of them.

use serde::Serialize;

/// Law that an unsafe command breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SafetyProperty {
    /// Torque is finite.
    Finite,
    /// Torque is inside its limit.
    Limit,
    /// Torque changes no faster than its rate limit and starts from zero.
    Rate,
    /// Torque acts only in Armed, Running and Holding; in other states the robot's safe action acts.
    SafeAction,
    /// No torque acts before the joints are homed and confirmed.
    Homed,
    /// No torque acts in a tick with faulty inputs, and the machine enters its fault state.
    Fault,
    /// A reported fault exists. Of several faults of the board, the first in the list is reported.
    Named,
    /// A fault stays until it is cleared, and a standing fault cannot be cleared.
    Latched,
    /// States change only along the diagram, by a request or for a stated cause.
    Transition,
    /// Every request is granted or refused, and no other answer is given. Checked only if all messages of the host are
    /// known.
    Answered,
    /// The silence of a host is detected in time.
    Silence,
    /// The followed reference is finite, within reach, and can stop before its limits.
    Reference,
    /// A reference beyond a limit is held, and flagged.
    Held,
    /// A holding arm comes to rest.
    Rest,
    /// An armed arm stays within reach of where it was armed, unless it gives way to a collision.
    Standing,
    /// The reported command is the one that drives the actuators.
    Reported,
    /// The arm can be simulated to the end.
    RanAway,
    /// While torque is to hold it, no joint leaves its place or its path. Of drives on a bus.
    Fell,
    /// Brakes stop every joint within their time, and hold it. Of drives on a bus.
    Stopped,
    /// Without brakes every drive that hears the board damps its joint in the safe action. Of drives on a bus.
    Damped,
    /// No torque of before acts after the safe action was due. Of drives on a bus.
    OldTorque,
    /// Brakes open only in states with torque, on drives that are on. Of drives on a bus.
    BrakesOpen,
    /// A drive that goes off while torque is to act is found in time. Of drives on a bus.
    OffUnnoticed,
    /// When brakes open, every drive carries its joint. Of drives on a bus.
    Carried,
    /// A stop or a hold that was sent in time acts in its tick. Of drives on a bus.
    Strongest,
    /// No torque acts for long on a drive whose zero has moved since the homing. Of drives on a bus.
    ZeroMoved,
    /// Torque on engaging brakes holds a disarmed arm for exactly the time that they need, and ends an arm whose host is gone likewise.
    Disarmed,
    /// Without its host an arm with a rest pose is lowered, slowly, and not dropped. Of drives on a bus.
    Lowered,
}

/// An unsafe command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unsafe {
    /// The broken law.
    pub law: SafetyProperty,
    /// Description with numbers.
    pub what: String,
}

/// Returns a violation of a law.
pub(crate) fn broken(law: SafetyProperty, what: impl Into<String>) -> Result<(), Unsafe> {
    Err(Unsafe { law, what: what.into() })
}
