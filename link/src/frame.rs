//! Frames of the link. SI units and radians; joint values base first.

use crate::seal::{Nonce, Proof};
use crate::state::StateCode;
use serde::{Deserialize, Serialize};

/// Most joints that a frame carries.
pub const JOINTS_MAX: usize = 6;

/// One value per joint, base first. The count travels with it, so that frames need no type parameter and a peer for
/// another arm gets a named error instead of being misread.
pub type Joints<T> = heapless::Vec<T, JOINTS_MAX>;

/// Any frame.
///
/// | frame | from | when |
/// |---|---|---|
/// | join | host | first, open: asks who the board is, and for a challenge |
/// | challenge | MCU | answer to a join, open: who it is, whether it has a key, and its proof |
/// | proof | host | answer to a challenge, open: from here on both seal every packet |
/// | hello | both | the MCU's when it has started, open; then the host's, and the MCU's answer: each compares |
/// | reference | host | before the measurement it belongs to; holds until the next one |
/// | live | host | before the tick from which it holds; holds until the next one or a hello, which sets all of it to zero |
/// | measurement | host | once per tick; its arrival starts the tick on a board in lock step |
/// | command | MCU | answer to a measurement |
/// | fault | MCU | answer to a measurement when the controller brakes |
/// | refusal | MCU | answer to any frame that could not be used |
/// | request | host | asks the safety state machine for a change; answered by an answer with its number |
/// | lines | host | simulated lines of the board, from the next tick on; in a dry run alone |
/// | point | host | the next point of the trajectory; answered only when it is refused |
/// | alive | host | sign of life of the host; any other frame is one too |
/// | watch | host | which parts of which ticks to report |
/// | dump | host | send the black box |
/// | get, set | host | read or change a parameter; both are answered with its value |
/// | status | MCU | a tick under the safety state machine: every tick of a dry run, otherwise the watched ticks |
/// | past | MCU | a tick out of the black box, oldest first; empty behind the last |
/// | value | MCU | a parameter and its bounds |
/// | answer | MCU | the verdict on a request; sent again if the request comes again |
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Frame {
    /// Identity of the sender.
    Hello(Hello),
    /// Reading of the sensors.
    Measurement(Measurement),
    /// Reference for the arm.
    Reference(Reference),
    /// Torques for the actuators.
    Command(Command),
    /// Reason why there is no command.
    Fault(Fault),
    /// Reason why the frame before was not used.
    Refusal(Refusal),
    /// Live inputs of the scene.
    Live(Live),
    /// Request to the safety state machine, with a number.
    Request(NumberedRequest),
    /// State of a board's lines.
    Lines(Lines),
    /// Next point of the trajectory, some ticks after the point before.
    Point(Point),
    /// The host is there.
    Alive,
    /// Choice of reports.
    Watch(Watch),
    /// Request for the contents of the black box.
    Dump,
    /// Read the parameter with this number.
    Get(u8),
    /// Change a parameter.
    Set(Setting),
    /// Request for a challenge, with the host's nonce.
    Join(Nonce),
    /// Proof that the host has the link key.
    Proof(Proof),
    /// Who the board is, and whom it trusts.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Challenge(Challenge),
    /// Report of a tick.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Status(Status),
    /// Report of a tick in the black box; `None` behind the last.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Past(Option<Status>),
    /// Value of a parameter.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Value(Value),
    /// Verdict on a request.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Answer(Answer),
}

impl Frame {
    /// Number of kinds; the first payload byte is below it.
    ///
    /// The last five are read by a host alone (feature `host`): a chip that could read them would be 3 KiB longer.
    pub const KINDS: u8 = if cfg!(feature = "host") { 22 } else { 17 };

    /// A request with its number.
    #[must_use]
    pub const fn request(number: u8, request: Request) -> Self {
        Self::Request(NumberedRequest { number, request })
    }

    /// True if the count of open packets begins anew here: the frame begins a session, or a handshake.
    pub(crate) const fn begins(&self) -> bool {
        matches!(self, Self::Hello(_) | Self::Join(_) | Self::Proof(_) | Self::Challenge(_))
    }
}

/// Who the board is, and whom it trusts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Challenge {
    /// The board's build data; its pacing has no meaning.
    pub own: Hello,
    /// Whom it trusts.
    pub trust: Trust,
}

/// Whom a board trusts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum Trust {
    /// A host that has its key.
    Key {
        /// The board's nonce.
        nonce: Nonce,
        /// Origin of the nonce.
        source: NonceSource,
        /// Proof that the board has the key.
        proof: Proof,
    },
    /// It has no key: anybody on the bench, nobody else.
    NoKey,
    /// It was built to trust anybody.
    Insecure,
}

/// Origin of a board's nonces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NonceSource {
    /// The chip's random number generator.
    Generator,
    /// A random number beside the key, a count in memory that a reset leaves alone, and a timer.
    Counter,
}

/// Build data of a peer. Both sides send it; they run only when it agrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Hash of the robot, the scene and the controller's configuration.
    pub robot: u64,
    /// Number of joints.
    pub joints: u8,
    /// Control rate, Hz.
    pub rate_hz: f32,
    /// Source of ticks: the host asks, the MCU repeats.
    pub pacing: Pacing,
}

/// Source of ticks, and whether the safety state machine stands between the controller and the drives.
///
/// On the bench there is the controller alone, and no drive is ever driven: torque goes back over the link and nowhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pacing {
    /// Bench: each measurement starts a tick: for an emulated chip, whose time runs on while the host computes.
    LockStep,
    /// Bench: the timer, at the control rate; a tick takes the newest measurement and knows its age.
    Timer,
    /// The safety state machine stands in between, each measurement starts a tick, and the host simulates the lines of
    /// the board. No drive is driven.
    DryRun,
    /// The safety state machine stands in between, the timer starts ticks, and the drives are driven.
    Live,
}

impl Pacing {
    /// True if each measurement starts a tick.
    #[must_use]
    pub const fn is_lock_step(self) -> bool {
        matches!(self, Self::LockStep | Self::DryRun)
    }

    /// True if the safety state machine stands between the controller and the drives.
    #[must_use]
    pub const fn is_supervised(self) -> bool {
        matches!(self, Self::DryRun | Self::Live)
    }
}

/// Reading of the sensors, and its tick.
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

/// Reference for the arm, until the next one.
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
    /// Payload at the tip, in the last link's frame.
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

/// Torques for the actuators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// The tick this answers.
    pub tick: u32,
    /// Actuator torque or force, N m or N: exactly the computed bits.
    pub torque: Joints<f32>,
    /// Limits that acted, as the bits of [`dynamics_core::control::LimitFlags`].
    pub limits: Joints<u8>,
    /// Cost of the controller's tick, where the board can count it exactly.
    pub cost: Option<Cost>,
}

/// Cost of a tick. Instructions and cycles are different things and never stand in one column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cost {
    /// Instructions executed, as the emulator counts them.
    Instructions(u32),
    /// Processor cycles, as the chip's own counter has them.
    Cycles(u32),
}

/// Reason why the controller brakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// The tick this answers; for a fault without a measurement, the last tick before it.
    pub tick: u32,
    /// Stable number of the fault: [`dynamics_core::Fault::code`].
    pub code: u8,
    /// The joint at fault, counted from 0, if it is one joint's.
    pub joint: Option<u8>,
}

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

/// State of a board's lines, beside the joints' readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "PackedLines", into = "PackedLines")]
pub struct Lines {
    /// The emergency stop is pressed, or its wire is broken.
    pub emergency_stop: bool,
    /// The tick before had not ended when this one was due.
    pub overrun: bool,
    /// Every joint knows its zero.
    pub zeroed: bool,
    /// Joints whose drive reports a fault: bit 0 is the first.
    pub drive_fault: u8,
    /// Joints whose drive has shown, after its enable frame, that it is on: bit 0 is the first.
    pub on: u8,
    /// A drive may have lost its zero since the tick before.
    pub zero_lost: bool,
    /// Supply voltage, V, where it is measured.
    pub supply: Option<f32>,
    /// Highest temperature, degrees Celsius, where it is measured.
    pub temperature: Option<f32>,
}

/// [`Lines`] as they are sent: a status with encoder counts of six joints must fit into a millisecond of the line.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct PackedLines {
    /// Emergency stop 1, overrun 2, zeroed 4, zero lost 8.
    flags: u8,
    drive_fault: u8,
    on: u8,
    supply: Option<f32>,
    temperature: Option<f32>,
}

impl From<Lines> for PackedLines {
    fn from(lines: Lines) -> Self {
        let Lines { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature } = lines;
        let bits = [emergency_stop, overrun, zeroed, zero_lost];
        let flags = bits.iter().rev().fold(0, |flags, &bit| flags << 1 | u8::from(bit));
        Self { flags, drive_fault, on, supply, temperature }
    }
}

impl From<PackedLines> for Lines {
    fn from(packed: PackedLines) -> Self {
        let PackedLines { flags, drive_fault, on, supply, temperature } = packed;
        let is_set = |bit: u8| flags & bit != 0;
        let (emergency_stop, overrun, zeroed, zero_lost) = (is_set(1), is_set(2), is_set(4), is_set(8));
        Self { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature }
    }
}

/// Fault of a joint's drive or sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct DriveFaultReport {
    /// The joint, counted from 0.
    pub joint: u8,
    /// As the bits of `session::readings::JointFaults`.
    pub faults: u16,
    /// The drive's own error code; 0 for none.
    pub error: u8,
}

impl Lines {
    /// No fault, every drive on, every joint knows its zero, and nothing else is measured.
    pub const CALM: Self = Self {
        emergency_stop: false,
        overrun: false,
        zeroed: true,
        drive_fault: 0,
        on: u8::MAX,
        zero_lost: false,
        supply: None,
        temperature: None,
    };
}

/// A point of the trajectory. The way to it from the point before is the polynomial of fifth degree that agrees with both in
/// position, velocity and acceleration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Ticks from the point before to this; 0 starts a new trajectory here.
    pub ticks: u16,
    /// Position, velocity and acceleration.
    pub reference: Reference,
}

/// Choice of reports, and their rate.
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
    /// Readings and lines: all inputs of the tick from the board.
    pub const SENSED: Self = Self(1);
    /// Torques and limits.
    pub const TORQUE: Self = Self(2);
    /// The trajectory's reference.
    pub const REFERENCE: Self = Self(4);
    /// Cost of the tick.
    pub const COST: Self = Self(8);
    /// All that a record holds.
    pub const ALL: Self = Self(15);
    /// Torque from outside on each joint, where the scene estimates it; in the place of the reference.
    pub const EXTERNAL: Self = Self(16);

    /// Both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True if all of `other` are in.
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
    /// Its value.
    pub value: f32,
    /// Lowest value that can be set; NaN where it is fixed.
    pub low: f32,
    /// Highest value that can be set; NaN where it is fixed.
    pub high: f32,
}

/// Inputs and outputs of a tick under the safety state machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Status {
    /// Number of the tick.
    pub tick: u32,
    /// Frames that had been taken before it, refused and lost ones too, modulo 65,536: places a tick between the frames of a log.
    pub taken: u16,
    /// State of the safety state machine.
    pub state: StateCode,
    /// Number of the [fault](Status::fault) or of the [cause to hold](Status::hold_cause); 0 in every other state.
    pub cause: u8,
    /// The joint that is the cause, counted from 0, where it is one joint.
    pub joint: Option<u8>,
    /// The joints' zeros have been confirmed.
    pub homed: bool,
    /// Reason for which the request of this tick was rejected.
    pub refused: Option<Denial>,
    /// The black box holds a fault that has not been released: it records no new ticks.
    pub kept: bool,
    /// Points that the trajectory has room for.
    pub room: u8,
    /// Action of the drives; `None` where it was not requested.
    pub actuation: Option<Actuation>,
    /// Readings of the board's sensors and lines; `None` where they were not requested.
    pub sensed: Option<SensedLines>,
    /// One of several things.
    pub extra: ExtraFields,
    /// Cost of the tick, where it was requested and can be counted exactly.
    pub cost: Option<TickCost>,
}

/// Optional parts of a status, which has room for one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum ExtraFields {
    /// Nothing.
    Nothing,
    /// The trajectory's reference, where it was requested and there is one.
    Reference(Reference),
    /// Torque from outside on each joint, N m or N, where it was requested and the scene estimates it.
    External(Joints<f32>),
    /// In the state of a fault, where readings were requested: what the first joint with a fault reports.
    DriveFault(DriveFaultReport),
}

impl Status {
    /// The trajectory's reference, if it is told.
    #[must_use]
    pub fn reference(&self) -> Option<&Reference> {
        match &self.extra {
            ExtraFields::Reference(reference) => Some(reference),
            _ => None,
        }
    }

    /// Torque from outside on each joint, N m or N, if it is told.
    #[must_use]
    pub fn external(&self) -> Option<&[f32]> {
        match &self.extra {
            ExtraFields::External(external) => Some(external),
            _ => None,
        }
    }

    /// Report of the first joint with a fault, if the board tells it.
    #[must_use]
    pub fn drive_fault(&self) -> Option<DriveFaultReport> {
        match self.extra {
            ExtraFields::DriveFault(drive_fault) => Some(drive_fault),
            _ => None,
        }
    }
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

/// Action of the drives.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum Actuation {
    /// These torques or forces, N m or N, and which limits acted.
    Drive {
        /// Exactly the computed bits.
        torque: Joints<f32>,
        /// As the bits of [`dynamics_core::control::LimitFlags`].
        limits: Joints<u8>,
    },
    /// Drives off, brakes engaged.
    Brake,
    /// The drives damp the motion by themselves.
    DampedStop,
    /// Drives off.
    Off,
    /// The drives are being switched on, brakes engaged.
    Enable,
    /// These torques or forces, with engaged brakes.
    Preload {
        /// Exactly the computed bits.
        torque: Joints<f32>,
        /// As the bits of [`dynamics_core::control::LimitFlags`].
        limits: Joints<u8>,
    },
}

/// Readings and lines of a board in a tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct SensedLines {
    /// Readings of the joints.
    pub sensed: Sensed,
    /// Age of each, ticks; 65,535 is that or older.
    pub age_ticks: Joints<u16>,
    /// The lines.
    pub lines: Lines,
}

/// Costs of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct TickCost {
    /// Trajectory, safety state machine and controller.
    pub all: Cost,
    /// The controller alone, where it was called.
    pub controller: Option<Cost>,
}
