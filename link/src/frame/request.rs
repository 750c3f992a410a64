//! Requests and parameter changes of a host, and the answers of a board.

use serde::{Deserialize, Serialize};

/// Reason why the MCU did not use a received frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The packet could not be decoded.
    Undecodable(crate::packet::DecodeError),
    /// Packets were lost before this one.
    Lost {
        /// Number of packets; 255 means 255 or more.
        missed: u8,
    },
    /// A measurement, reference or live input arrived before hellos were exchanged.
    NoHello,
    /// The frame has values for another number of joints.
    JointCount {
        /// Number of joints of the controller.
        expected: u8,
        /// Number of joints in the frame.
        found: u8,
    },
    /// The hello was for another robot, joint count or rate. The MCU sent its own hello before this refusal.
    OtherRobot,
    /// A measurement arrived before any reference.
    NoReference,
    /// The MCU never receives this kind of frame.
    Unexpected,
    /// The packet does not belong to the session: it is open, its seal does not fit, it is a repeated packet, or a proof is wrong.
    Unauthentic {
        /// Number of such packets since the board started; 65,535 means 65,535 or more.
        count: u16,
    },
    /// The board has no key, and without one it does not run the safety state machine.
    NoKey,
    /// The board has no nonce: its random number generator has failed.
    NoNonce,
    /// A live input is NaN or infinite; the earlier ones stay in force.
    NonFiniteLive,
    /// A point's position, velocity or acceleration, or a coefficient of the segment to it, is NaN or infinite.
    NonFinitePoint,
    /// The trajectory buffer is full; send this point again when the status shows free capacity.
    TrajectoryFull,
    /// A point with a duration arrived before a start point.
    NoStart,
    /// A start point, or a change of the control law, arrived while the arm runs.
    Running,
    /// No parameter has this number.
    NoParameter,
    /// The parameter is fixed by the scene that the firmware was built from.
    Fixed,
    /// The value is outside the parameter's bounds, or NaN; an impossible or too heavy payload; too much gravity.
    OutOfBounds,
    /// An earlier change is still waiting for its tick.
    Busy,
    /// The change would make the torque of a joint jump by more than its limit for one tick.
    WouldJump {
        /// The first such joint, counted from 0.
        joint: u8,
    },
    /// The host sent a measurement while the board uses its own sensors.
    OwnMeasurements {
        /// Number of such frames since the hello; 65,535 means 65,535 or more.
        count: u16,
    },
    /// A hello for another robot, rate or pacing arrived while the arm is driven; the session goes on.
    Driven,
}

/// Request with a number that the host chooses.
///
/// The board executes each number once. A frame with the number and request of one of the last 8 is a repetition: it is answered again but not
/// executed again. A host repeats a request until its answer arrives, and uses the next number for the next request.
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
    /// The request was carried out.
    Accepted,
    /// The request was rejected for this reason; nothing was changed.
    Rejected(Denial),
    /// A request of higher rank, or an earlier one of the same rank, was taken in the same tick; nothing was changed.
    Superseded,
}

/// Request to the safety state machine. See [`dynamics_core::safety::Request`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Forget the joints' zeros, and find them again.
    Home,
    /// Confirm that the zeros are correct.
    Confirm,
    /// Switch the drives on and hold the arm by torque.
    Arm,
    /// Take the torque away.
    Disarm,
    /// Follow the trajectory.
    Run,
    /// Stop and hold the position.
    Hold,
    /// Leave the fault.
    Clear,
    /// Emergency stop, in any state.
    Stop,
    /// Lift the limits of the first motion after homing.
    FullRange,
    /// Release the black box, which keeps the ticks around a fault until then.
    Release,
}

/// Reason for which a request is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Denial {
    /// [`dynamics_core::safety::Refusal::code`].
    pub code: u8,
    /// The fault that prevents it, as [`dynamics_core::Fault::code`], or 0.
    pub fault: u8,
    /// The joint that is the reason, counted from 0, if it is a single joint.
    pub joint: Option<u8>,
    /// The live input that is missing or too old, as [`dynamics_core::safety::LiveInput::code`], or 0.
    pub input: u8,
}

/// A change of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Its number.
    pub index: u8,
    /// Its new value, in the parameter's unit.
    pub value: f32,
}

/// Value and bounds of a parameter. See `session::parameters` for numbers and units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Value {
    /// Its number.
    pub index: u8,
    /// Its value, in the parameter's unit.
    pub value: f32,
    /// Lowest value that can be set; NaN if the parameter is fixed.
    pub low: f32,
    /// Highest value that can be set; NaN if the parameter is fixed.
    pub high: f32,
}
