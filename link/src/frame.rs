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
/// | request | host | asks the safety state machine for a change; the next status grants or refuses it |
/// | lines | host | what the board's own lines would say, from the next tick on; in a drill alone |
/// | point | host | the next point of the trajectory; answered only when it is refused |
/// | alive | host | the host is there: any other frame says so too |
/// | watch | host | which parts of which ticks to report |
/// | dump | host | send the black box |
/// | get, set | host | read or change a parameter; both are answered with its value |
/// | status | MCU | a tick under the safety state machine: every one of a drill, those that are watched else |
/// | past | MCU | a tick out of the black box, oldest first; empty behind the last |
/// | value | MCU | a parameter and its bounds |
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
    /// What the safety state machine is asked for.
    Request(Request),
    /// What the lines of a board say.
    Lines(Lines),
    /// Where the arm should be some ticks after the point before.
    Point(Point),
    /// The host is there.
    Alive,
    /// What to report.
    Watch(Watch),
    /// Send what the black box holds.
    Dump,
    /// Read the parameter with this number.
    Get(u8),
    /// Change a parameter.
    Set(Setting),
    /// What a tick did.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Status(Status),
    /// What a tick did that the black box remembers; `None` behind the last.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Past(Option<Status>),
    /// What a parameter is.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Value(Value),
}

impl Frame {
    /// Number of kinds; the first payload byte is below it.
    ///
    /// The last three are read by a host alone (feature `host`): a chip that could read them would be 3 KiB longer.
    pub const KINDS: u8 = if cfg!(feature = "host") { 18 } else { 15 };
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

/// What starts a tick, and who stands between the controller and the drives.
///
/// On the bench there is the controller alone, and no drive is ever driven: torque goes back over the link and nowhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pacing {
    /// Bench: each measurement starts one: for an emulated chip, whose time runs on while the host computes.
    LockStep,
    /// Bench: the timer, at the control rate; a tick takes the newest measurement and knows its age.
    Timer,
    /// The safety state machine stands in between, each measurement starts a tick, and the host plays the lines of the board. No
    /// drive is driven.
    Drill,
    /// The safety state machine stands in between, the timer starts ticks, and the drives are driven.
    Live,
}

impl Pacing {
    /// Whether each measurement starts a tick.
    #[must_use]
    pub const fn is_lock_step(self) -> bool {
        matches!(self, Self::LockStep | Self::Drill)
    }

    /// Whether the safety state machine stands between the controller and the drives.
    #[must_use]
    pub const fn is_supervised(self) -> bool {
        matches!(self, Self::Drill | Self::Live)
    }
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
    /// A point's position, velocity or acceleration, or what the way to it is computed from, is NaN or infinite.
    NonFinitePoint,
    /// The trajectory holds as many points as it can; send this one again when the status shows room.
    TrajectoryFull,
    /// A point that takes time came before one to start from.
    NoStart,
    /// A start came while the arm runs.
    Running,
    /// No parameter has this number.
    NoParameter,
    /// The parameter is fixed by the scene that the firmware was built from.
    Fixed,
    /// The value is outside the parameter's bounds, or no number; a payload that cannot be, or is too heavy; too much gravity.
    OutOfBounds,
    /// Another change waits for its tick.
    Busy,
    /// The torque of a joint would change at once by more than it may in a tick.
    WouldJump {
        /// The first joint that would, counted from 0.
        joint: u8,
    },
}

/// What the safety state machine is asked for. See [`dynamics_core::safety::Request`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Forget where zero was, and look for it.
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
}

/// What the lines of a board say beside the joints' readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lines {
    /// The emergency stop is pressed, or its wire is broken.
    pub emergency_stop: bool,
    /// The tick before had not ended when this one was due.
    pub overrun: bool,
    /// Every joint knows its zero.
    pub zeroed: bool,
    /// Joints whose drive reports a fault: bit 0 is the first.
    pub drive_fault: u8,
    /// Supply voltage, V, where it is measured.
    pub supply: Option<f32>,
    /// Highest temperature, degrees Celsius, where it is measured.
    pub temperature: Option<f32>,
}

impl Lines {
    /// Nothing is wrong, every joint knows its zero, and nothing else is measured.
    pub const CALM: Self =
        Self { emergency_stop: false, overrun: false, zeroed: true, drive_fault: 0, supply: None, temperature: None };
}

/// A point of the trajectory. The way to it from the point before is the polynomial of fifth degree that agrees with both in
/// position, velocity and acceleration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Ticks from the point before to this; 0 starts a new trajectory here.
    pub ticks: u16,
    /// Where, how fast, how much faster.
    pub reference: Reference,
}

/// What to report, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Watch {
    /// Every so many ticks; 0 never.
    pub every: u16,
    /// Which [`Parts`] of a status.
    pub parts: Parts,
}

/// Parts of a [`Status`] that can be left out: a set of bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Parts(u8);

impl Parts {
    /// None of them.
    pub const NONE: Self = Self(0);
    /// Readings and lines: all that the tick was told by the board.
    pub const SENSED: Self = Self(1);
    /// Torques and limits.
    pub const TORQUE: Self = Self(2);
    /// The trajectory's reference.
    pub const REFERENCE: Self = Self(4);
    /// What the tick cost.
    pub const COST: Self = Self(8);
    /// All of them.
    pub const ALL: Self = Self(15);

    /// Both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `other` are in.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
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
    /// What it is.
    pub value: f32,
    /// What it can be set to at least; NaN where it is fixed.
    pub low: f32,
    /// What it can be set to at most; NaN where it is fixed.
    pub high: f32,
}

/// What a tick under the safety state machine was told, and what it did.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Status {
    /// Number of the tick.
    pub tick: u32,
    /// Frames that had been taken before it, refused ones too, modulo 65,536: places a tick between the frames of a log.
    pub taken: u16,
    /// [`dynamics_core::safety::State::code`].
    pub state: u8,
    /// Why: the fault's code, or [`dynamics_core::safety::HoldCause::code`]; 0 in every other state.
    pub cause: u8,
    /// The joint that is the cause, counted from 0, where it is one joint.
    pub joint: Option<u8>,
    /// The joints' zeros have been confirmed.
    pub homed: bool,
    /// Why the request of this tick was not granted.
    pub refused: Option<Denial>,
    /// Points that the trajectory has room for.
    pub room: u8,
    /// What the drives do; `None` where it was not asked for.
    pub actuation: Option<Actuation>,
    /// What the board's sensors and lines said; `None` where it was not asked for.
    pub sensed: Option<SensedLines>,
    /// The trajectory's reference, where it was asked for and there is one.
    pub reference: Option<Reference>,
    /// What the tick cost, where it was asked for and can be counted exactly.
    pub cost: Option<TickCost>,
}

/// Why a request was not granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Denial {
    /// [`dynamics_core::safety::Refusal::code`].
    pub code: u8,
    /// The fault that stands in the way, or 0.
    pub fault: u8,
    /// The joint, counted from 0, where it is one joint's.
    pub joint: Option<u8>,
}

/// What the drives do.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum Actuation {
    /// These torques or forces, N m or N, and which limits acted.
    Drive {
        /// The very bits that were computed.
        torque: Joints<f32>,
        /// As the bits of [`dynamics_core::control::LimitFlags`].
        limits: Joints<u8>,
    },
    /// Drives off, brakes engaged.
    Brake,
    /// The drives take the motion out by themselves.
    DampedStop,
    /// Drives off.
    Off,
}

/// All that a board said in a tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct SensedLines {
    /// Readings of the joints.
    pub sensed: Sensed,
    /// How old each is, ticks; 65,535 is that or older.
    pub age_ticks: Joints<u16>,
    /// The lines.
    pub lines: Lines,
}

/// What a tick cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct TickCost {
    /// Trajectory, safety state machine and controller.
    pub all: Cost,
    /// The controller alone, where it was asked.
    pub controller: Option<Cost>,
}
