//! Texts of states, causes of a hold, and refusals, as an operator's screen shows them. Joints are counted from 1 there.

use super::{HoldCause, LiveInput, Refusal, State};
use core::fmt;

impl State {
    /// Names of the states, in the order of their [numbers](Self::code).
    pub const NAMES: [&'static str; 9] =
        ["idle", "homing", "armed", "running", "holding", "fault", "arming", "lowering", "disarming"];

    /// The state's name, without its cause.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::NAMES[self.code() as usize]
    }
}

/// The name of the state; after `holding` its cause. A fault is its own text: `fault 9: emergency stop`.
impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Holding(cause) => write!(f, "{}: {cause}", self.name()),
            Self::Fault(fault) => fault.fmt(f),
            _ => f.write_str(self.name()),
        }
    }
}

impl HoldCause {
    /// All causes, in the order of their [numbers](Self::code); those that concern one joint appear with joint 0.
    pub const ALL: [Self; 7] = [
        Self::Requested,
        Self::HeartbeatLost,
        Self::NoReference,
        Self::NoRoom { joint: 0 },
        Self::OutOfReach { joint: 0 },
        Self::StaleInput,
        Self::FirstMotion { joint: 0 },
    ];

    /// The cause in words, without the joint.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Requested => "as requested",
            Self::HeartbeatLost => "the host fell silent",
            Self::NoReference => "the trajectory ended in motion",
            Self::NoRoom { .. } => "the stopping distance reaches a position limit",
            Self::OutOfReach { .. } => "the reference is out of reach",
            Self::StaleInput => "the live inputs are too old",
            Self::FirstMotion { .. } => {
                "the reference was faster than the first motion after homing may be (`first_motion` in [safety]); \
                 `full-range` lifts the limits"
            }
        }
    }

    /// The joint that is the cause, counted from 0, if it is a single joint.
    #[must_use]
    pub const fn joint(self) -> Option<u8> {
        match self {
            Self::NoRoom { joint } | Self::OutOfReach { joint } | Self::FirstMotion { joint } => Some(joint),
            Self::Requested | Self::HeartbeatLost | Self::NoReference | Self::StaleInput => None,
        }
    }
}

impl fmt::Display for HoldCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())?;
        write_joint(f, self.joint())
    }
}

impl Refusal {
    /// Texts of the refusals, in the order of their [numbers](Self::code), which start at 1.
    pub const TEXTS: [&'static str; 15] = [
        "this state does not allow it",
        "a fault is active",
        "the arm has not been homed",
        "a joint does not know its zero",
        "the measurement or the reference is implausible",
        "the arm moves",
        "the host was silent",
        "there is no reference to follow",
        "a joint could not stop before its limit",
        "the trajectory does not start at the arm's position",
        "a change of a parameter or a live input waits for the same tick",
        "a live input of the scene has not been sent yet",
        "a live input is too old",
        "the black box holds a fault that has not been read",
        "this is faster than the first motion after homing may be (`first_motion` in [safety])",
    ];

    /// The reason in words, without the joint, fault or live input that it concerns.
    #[must_use]
    pub const fn text(self) -> &'static str {
        Self::TEXTS[self.code() as usize - 1]
    }

    /// The joint that is the reason, counted from 0, if it is a single joint. A fault names its own joint.
    #[must_use]
    pub const fn joint(self) -> Option<u8> {
        match self {
            Self::NoRoom { joint } | Self::OutOfReach { joint } | Self::FirstMotion { joint } => Some(joint),
            _ => None,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())?;
        match self {
            Self::Fault(fault) | Self::Implausible(fault) => write!(f, ": {fault}"),
            Self::MissingInput(input) | Self::StaleInput(input) => write!(f, ": {input}"),
            _ => write_joint(f, self.joint()),
        }
    }
}

impl LiveInput {
    /// Its name: `tip wrench`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Payload => "payload",
            Self::TipWrench => "tip wrench",
            Self::Rotors => "rotors",
        }
    }
}

impl fmt::Display for LiveInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Writes the joint, counted from 1, if there is one.
fn write_joint(f: &mut fmt::Formatter<'_>, joint: Option<u8>) -> fmt::Result {
    match joint {
        Some(joint) => write!(f, " (joint {})", u32::from(joint) + 1),
        None => Ok(()),
    }
}
