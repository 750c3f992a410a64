//! Requests of a host, changes of parameters, and the answers of a board.

use serde::{Deserialize, Serialize};

/// Reason why the MCU did not use a received frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The packet could not be decoded.
    Undecodable(crate::packet::DecodeError),
    /// Packets were lost before this one.
    Lost {
        /// Number of packets; 255 is that or more.
        missed: u8,
    },
    /// A measurement, reference or live input before hellos were exchanged.
    NoHello,
    /// The frame has values for another number of joints.
    JointCount {
        /// Number of joints of the controller.
        expected: u8,
        /// Number of joints in the frame.
        found: u8,
    },
    /// The hello was for another robot, joint count or rate; the MCU's own hello came before this.
    OtherRobot,
    /// A measurement came before any reference.
    NoReference,
    /// The MCU never receives this kind of frame.
    Unexpected,
    /// The packet is not of the session: it is open, its seal does not fit, it was there before, or a proof is wrong.
    Unauthentic {
        /// Number of such packets since the board has started; 65,535 is that or more.
        count: u16,
    },
    /// The board has no key: without one the safety state machine is not to be had.
    NoKey,
    /// The board has no nonce: its random number generator has failed.
    NoNonce,
    /// A live input is NaN or infinite; the earlier ones stay in force.
    NonFiniteLive,
    /// A point's position, velocity or acceleration, or a number from which the way to it is computed, is NaN or
    /// infinite.
    NonFinitePoint,
    /// The trajectory holds as many points as it can; send this one again when the status shows room.
    TrajectoryFull,
    /// A point that takes time came before one to start from.
    NoStart,
    /// A start, or another law, came while the arm runs.
    Running,
    /// No parameter has this number.
    NoParameter,
    /// The parameter is fixed by the scene that the firmware was built from.
    Fixed,
    /// The value is outside the parameter's bounds, or NaN; an impossible or too heavy payload; too much gravity.
    OutOfBounds,
    /// Another change waits for its tick.
    Busy,
    /// The torque of a joint would change at once by more than it may in a tick.
    WouldJump {
        /// The first joint that would, counted from 0.
        joint: u8,
    },
    /// A measurement came from the host while the board measures for itself.
    OwnMeasurements {
        /// Number of such frames since the hello; 65,535 is that or more.
        count: u16,
    },
    /// A hello for another robot, rate or pacing came while the arm is driven; the session goes on.
    Driven,
}

/// Request with a number that the host chooses.
///
/// The board answers each number once. A frame with a number and request that are among the last 8 is the same request, sent again: it acts
/// no second time, and is answered again. A host sends a request until its answer has come, and takes the next number for the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NumberedRequest {
    /// The number.
    pub number: u8,
    /// The request.
    pub request: Request,
}

/// Verdict on a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Answer {
    /// The request's number.
    pub number: u8,
    /// The verdict.
    pub verdict: Verdict,
}

/// Verdict on a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum Verdict {
    /// The state machine has done it.
    Accepted,
    /// It has not, for this reason; nothing was changed.
    Rejected(Denial),
    /// A request of higher rank, or an earlier one of the same rank, came for the same tick; nothing was changed.
    Superseded,
}

/// Request to the safety state machine. See [`dynamics_core::safety::Request`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Forget the zeros, and look for them.
    Home,
    /// The zeros are right.
    Confirm,
    /// Hold the arm by torque.
    Arm,
    /// No torque.
    Disarm,
    /// Follow the trajectory.
    Run,
    /// Stop, and stay.
    Hold,
    /// Leave the fault.
    Clear,
    /// Emergency stop, in any state.
    Stop,
    /// Lift the limits of the first motion after homing.
    FullRange,
    /// Release the black box, which holds the ticks around a fault until then.
    Release,
}

/// Reason for which a request is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Denial {
    /// [`dynamics_core::safety::Refusal::code`].
    pub code: u8,
    /// The fault that stands in the way, or 0.
    pub fault: u8,
    /// The joint, counted from 0, where it is one joint's.
    pub joint: Option<u8>,
    /// The live input that is missing or old, as [`dynamics_core::safety::LiveInput::code`], or 0.
    pub input: u8,
}

/// A change of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Its number.
    pub index: u8,
    /// Its new value, in its unit.
    pub value: f32,
}

/// A parameter. See `session::parameters` for their numbers and units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Value {
    /// Its number.
    pub index: u8,
    /// Its value.
    pub value: f32,
    /// Lowest value that can be set; NaN where it is fixed.
    pub low: f32,
    /// Highest value that can be set; NaN where it is fixed.
    pub high: f32,
}
