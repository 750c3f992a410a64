//! Messages of a file for viewers. Values that are infinite or NaN are left out, because JSON cannot represent them.

use super::schemas;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A message with a schema that viewers know by name.
pub trait Message: Serialize {
    /// Name of the schema.
    const SCHEMA: &'static str;

    /// JSON schema of the messages.
    fn schema() -> Value;
}

/// A text, as ROS defines it; Foxglove reads a URDF from such a topic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// The text.
    pub data: String,
}

/// A time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: u64,
    /// Nanoseconds in addition, below 1e9.
    pub nsec: u32,
}

impl Time {
    /// A time in ns.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Self {
        Self { sec: nanos / 1_000_000_000, nsec: (nanos % 1_000_000_000) as u32 }
    }
}

/// Frames at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameTransforms {
    /// Each frame relative to its parent.
    pub transforms: Vec<FrameTransform>,
}

/// A frame relative to its parent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameTransform {
    /// Time of the transform.
    pub timestamp: Time,
    /// Name of the parent.
    pub parent_frame_id: String,
    /// Name of the frame.
    pub child_frame_id: String,
    /// Origin of the frame relative to its parent, m.
    pub translation: Xyz,
    /// `parent_from_child`, a unit quaternion.
    pub rotation: Quaternion,
}

/// A vector; the unit depends on its field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Xyz {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

/// A rotation, as a quaternion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// First imaginary part.
    pub x: f64,
    /// Second imaginary part.
    pub y: f64,
    /// Third imaginary part.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

/// Joints at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointStates {
    /// Time of the states.
    pub timestamp: Time,
    /// The joints, base first.
    pub joints: Vec<JointState>,
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct JointState {
    /// Its name in the robot file and in the URDF.
    pub name: String,
    /// Position, rad or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<f64>,
    /// Velocity, rad/s or m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<f64>,
    /// Commanded torque or force, N m or N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
}

/// The loop in one tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tick {
    /// Time of the tick.
    pub timestamp: Time,
    /// Number of the tick: from 0 in a run; the board's number in a session.
    pub tick: u64,
    /// The joints, base first.
    pub joints: Vec<JointTick>,
    /// [`dynamics_core::Fault::code`] of the fault in force; 0 for none.
    pub fault: u8,
    /// The fault in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault_text: Option<String>,
    /// State of the safety state machine, [`dynamics_core::safety::State::code`]; missing in a run, which has no state machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<u8>,
    /// Force, N, and moment, N m, at the tip in base axes that are equivalent to the external torques.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_wrench: Option<TipWrench>,
}

/// A joint in one tick. Units are rad or m, rad/s or m/s, N m or N.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct JointTick {
    /// Its name in the robot file.
    pub name: String,
    /// Reference position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
    /// Reference velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_velocity: Option<f64>,
    /// Position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<f64>,
    /// Velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<f64>,
    /// Commanded torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<f64>,
    /// Limits that acted: the sum of 1 position, 2 velocity, 4 torque, 8 torque rate, 16 collision.
    pub limits: u8,
    /// External torque, if it is estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external: Option<f64>,
    /// Torque of the scene's model at the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub terms: Option<TermTorques>,
}

/// Torque of the model at the reference, by term, N m or N. The sum is the inverse dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TermTorques {
    /// `D(q) qdd`, including the rotors.
    pub inertia: f64,
    /// `C(q, qd) qd`.
    pub velocity: f64,
    /// `G(q)`, including the torques that payload and wrench at the tip need at rest.
    pub gravity: f64,
}

/// A wrench at the tip, in base axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TipWrench {
    /// Force, N.
    pub force: Xyz,
    /// Moment, N m.
    pub moment: Xyz,
}

/// A frame of the link, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkFrame {
    /// `sent` to the board, or `received` from it.
    pub way: String,
    /// Packets lost before a received frame, modulo 256.
    pub missed: u8,
    /// Time since the start of the session, us.
    pub micros: u64,
    /// The frame in postcard's encoding, as on the wire, in hexadecimal digits.
    pub frame: String,
}

macro_rules! named {
    ($($message:ty: $name:literal, $schema:ident;)*) => {$(
        impl Message for $message {
            const SCHEMA: &'static str = $name;

            fn schema() -> Value {
                schemas::$schema()
            }
        }
    )*};
}

named! {
    Text: "std_msgs/String", text;
    FrameTransforms: "foxglove.FrameTransforms", frame_transforms;
    JointStates: "foxglove.JointStates", joint_states;
    Tick: "newtau.Tick", tick;
    LinkFrame: "newtau.Frame", link_frame;
}

/// Returns a number, or `None` if it is infinite or NaN.
#[must_use]
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
