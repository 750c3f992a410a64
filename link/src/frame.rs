//! What is said over the link. SI units and radians; joint values base first.

use serde::{Deserialize, Serialize};

/// Most joints that a frame carries.
pub const JOINTS_MAX: usize = 6;

/// One value per joint, base first. The count travels with it, so that frames need no type parameter and a peer that
/// was built for another arm is caught by name instead of misread.
pub type Joints<T> = heapless::Vec<T, JOINTS_MAX>;

/// Any frame.
///
/// | frame | from | when |
/// |---|---|---|
/// | hello | both | the MCU's when it has started; then the host's, and the MCU's answer: each compares |
/// | reference | host | before the measurement it belongs to; holds until the next one |
/// | live | host | before the tick from which it holds; holds until the next one or a hello, which sets all of it to zero |
/// | measurement | host | once per tick; its arrival starts the tick on a board in lock step |
/// | command | MCU | answer to a measurement |
/// | fault | MCU | answer to a measurement when the controller brakes |
/// | refusal | MCU | answer to whatever could not be used |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Frame {
    /// Who is speaking.
    Hello(Hello),
    /// What the sensors say.
    Measurement(Measurement),
    /// What the arm should be doing.
    Reference(Reference),
    /// What the actuators should do.
    Command(Command),
    /// Why there is no command.
    Fault(Fault),
    /// Why the frame before was not used.
    Refusal(Refusal),
    /// What acts on the arm.
    Live(Live),
}

impl Frame {
    /// Number of kinds; the first payload byte is below it.
    pub const KINDS: u8 = 7;
}

/// What a peer was built from. Both sides say it; they run only when it agrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Hash of the robot, the scene and the controller's configuration.
    pub robot: u64,
    /// Number of joints.
    pub joints: u8,
    /// Control rate, Hz.
    pub rate_hz: f32,
    /// What starts a tick: the host asks, the MCU repeats.
    pub pacing: Pacing,
}

/// What starts a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pacing {
    /// Each measurement starts one: for an emulated chip, whose time runs on while the host computes.
    LockStep,
    /// The timer, at the control rate; a tick takes the newest measurement and knows its age.
    Timer,
}

/// What the sensors say, and for which tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Number of the tick; the answer repeats it.
    pub tick: u32,
    /// Ticks since the reading was taken; 0 is fresh.
    pub age_ticks: u32,
    /// The reading.
    pub sensed: Sensed,
}

/// A sensor reading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sensed {
    /// Position and velocity.
    State {
        /// Joint position, rad or m.
        q: Joints<f32>,
        /// Joint velocity, rad/s or m/s.
        qd: Joints<f32>,
    },
    /// Encoder counts.
    Counts(Joints<i32>),
}

/// What the arm should be doing, until the next reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Joint position, rad or m.
    pub q: Joints<f32>,
    /// Joint velocity, rad/s or m/s.
    pub qd: Joints<f32>,
    /// Joint acceleration, rad/s^2 or m/s^2.
    pub qdd: Joints<f32>,
}

/// The live inputs of the scene, until the next of these. The controller reads those whose term is live.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Live {
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: [f32; 3],
    /// Wrench of the environment on the arm at the tip's origin, in tip axes: force, N, then moment, N m.
    pub tip_wrench: [f32; 6],
    /// What the tip holds, in the last link's frame.
    pub payload: Payload,
    /// Reflected rotor inertias, kg m^2 (kg for a prismatic joint).
    pub rotor: Joints<f32>,
}

/// The ten inertial parameters of a held body, in the last link's frame and about its origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payload {
    /// Mass, kg.
    pub mass: f32,
    /// First moment, mass times mass centre, kg m.
    pub first_moment: [f32; 3],
    /// Inertia about the origin, kg m^2: xx, yy, zz, xy, xz, yz.
    pub inertia: [f32; 6],
}

/// What the actuators should do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// The tick this answers.
    pub tick: u32,
    /// Actuator torque or force, N m or N: the very bits that were computed.
    pub torque: Joints<f32>,
    /// Limits that acted, as the bits of [`dynamics_core::control::LimitFlags`].
    pub limits: Joints<u8>,
    /// What the controller's tick cost, where the board can count it exactly.
    pub cost: Option<Cost>,
}

/// What a tick cost. Instructions and cycles are different things and never stand in one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cost {
    /// Instructions executed, as the emulator counts them.
    Instructions(u32),
    /// Processor cycles, as the chip's own counter has them.
    Cycles(u32),
}

/// Why the controller brakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// The tick this answers; for a fault without a measurement, the last tick there was.
    pub tick: u32,
    /// Stable number of the fault: [`dynamics_core::Fault::code`].
    pub code: u8,
    /// The joint at fault, counted from 0, if it is one joint's.
    pub joint: Option<u8>,
}

/// Why the MCU did not use what it received.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The packet could not be decoded.
    Undecodable(crate::DecodeError),
    /// Packets were lost before this one.
    Lost {
        /// How many, modulo 256.
        missed: u8,
    },
    /// A measurement, reference or live input before hellos were exchanged.
    NoHello,
    /// The frame has values for another number of joints.
    JointCount {
        /// What the controller was built for.
        expected: u8,
        /// What came.
        found: u8,
    },
    /// The hello was for another robot, joint count or rate; the MCU's own hello came before this.
    OtherRobot,
    /// A measurement came before any reference.
    NoReference,
    /// The MCU never receives this kind of frame.
    Unexpected,
    /// A live input is NaN or infinite; those from before hold on.
    NonFiniteLive,
}
