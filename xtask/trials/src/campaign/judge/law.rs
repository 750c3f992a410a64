//! The safety properties, and violations of them.

use serde::Serialize;

/// Safety property that an unsafe command violates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SafetyProperty {
    /// Torque is finite.
    Finite,
    /// Torque is within its limit.
    Limit,
    /// Torque changes no faster than its rate limit and starts from zero.
    Rate,
    /// Torque acts only in Armed, Running, Holding and Lowering, and on engaged brakes in Arming and Disarming. In other states the robot's safe
    /// action acts.
    SafeAction,
    /// No torque acts before the joints are homed and confirmed.
    Homed,
    /// No torque acts in a tick with faulty inputs, and the machine enters its fault state.
    Fault,
    /// A reported fault exists. Of several faults of the board, the first in the list is reported.
    Named,
    /// A fault stays until it is cleared, and cannot be cleared while its cause persists.
    Latched,
    /// States change only along the diagram, after a request or for a reported cause.
    Transition,
    /// Every request is accepted or refused, and no other answer is given. Checked only if all messages of the host are known.
    Answered,
    /// The silence of a host is detected in time.
    Silence,
    /// The followed reference is finite, within `reach`, and able to stop before its limits.
    Reference,
    /// A reference beyond a limit is clamped, and flagged.
    Held,
    /// A holding arm comes to rest.
    Rest,
    /// An armed arm stays within `reach` of the position where it was armed, unless it yields to a collision.
    Standing,
    /// The reported command equals the one that drives the actuators.
    Reported,
    /// The arm can be simulated to the end of the run.
    RanAway,
    /// While torque must hold it, no joint leaves its position or its path. Only for drives on a bus.
    Fell,
    /// Brakes stop every joint within their time, and hold it. Only for drives on a bus.
    Stopped,
    /// Without brakes, every drive that receives frames damps its joint in the safe action. Only for drives on a bus.
    Damped,
    /// No earlier torque acts after the safe action was due. Only for drives on a bus.
    OldTorque,
    /// Brakes open only in states with torque, and on drives that are on. Only for drives on a bus.
    BrakesOpen,
    /// A drive that goes off while torque must act is detected in time. Only for drives on a bus.
    OffUnnoticed,
    /// When brakes open, every drive carries its joint. Only for drives on a bus.
    Carried,
    /// A stop or a hold that was sent in time acts in its tick. Only for drives on a bus.
    Strongest,
    /// Torque acts only briefly on a drive with a zero that has moved since homing. Only for drives on a bus.
    ZeroMoved,
    /// Torque holds a disarmed arm for exactly the time that its brakes need to engage. The same applies to an arm that has lost its host.
    Disarmed,
    /// Without its host an arm with a rest pose is lowered slowly, and not dropped. Only for drives on a bus.
    Lowered,
}

/// An unsafe command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unsafe {
    /// The violated property.
    pub law: SafetyProperty,
    /// Description with numbers.
    pub what: String,
}

/// Returns a violation of a property.
pub(crate) fn broken(law: SafetyProperty, what: impl Into<String>) -> Result<(), Unsafe> {
    Err(Unsafe { law, what: what.into() })
}
