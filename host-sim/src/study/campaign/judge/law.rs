//! The laws of safety, and how one is broken.

use serde::Serialize;

/// Law that an unsafe command breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// Torque is a number.
    Finite,
    /// Torque is inside its limit.
    Limit,
    /// Torque changes by no more than its rate allows, and rises from nothing.
    Rate,
    /// Torque acts in Armed, Running and Holding alone; elsewhere the robot's safe action does.
    SafeAction,
    /// No torque before the joints were homed and confirmed.
    Homed,
    /// No torque in a tick whose inputs are at fault, and the machine is in its fault then.
    Fault,
    /// A fault is named for what is there, and of several faults of the board the first of the list is.
    Named,
    /// A fault stays until a clear that nothing stands against.
    Latched,
    /// No state is left but along the diagram, by a request or for a stated cause.
    Transition,
    /// Where all that the host said is known: a request is granted or refused, and nothing else is.
    Answered,
    /// A silent host is noticed in time.
    Silence,
    /// The reference that is followed is a number, within reach, and can stop.
    Reference,
    /// A reference beyond a limit is held, and flagged.
    Held,
    /// An arm that holds comes to rest.
    Rest,
    /// What the drives do is what is reported.
    Reported,
    /// The arm can be simulated to the end.
    RanAway,
}

/// An unsafe command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unsafe {
    /// Law that it breaks.
    pub law: Law,
    /// With its numbers.
    pub what: String,
}

/// Says that this is broken.
pub(super) fn broken(law: Law, what: impl Into<String>) -> Result<(), Unsafe> {
    Err(Unsafe { law, what: what.into() })
}
