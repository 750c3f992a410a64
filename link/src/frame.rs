//! Frames of the link. SI units and radians; joint values base first.

pub mod request;
pub mod status;
pub mod values;

use crate::seal::{Nonce, Proof};
use serde::{Deserialize, Serialize};

pub use request::{Answer, Denial, NumberedRequest, Refusal, Request, Setting, Value, Verdict};
pub use status::{Actuation, DriveFaultReport, ExtraFields, Lines, Parts, SensedLines, Status, TickCost, Watch};
pub use values::{Command, Cost, Fault, JOINTS_MAX, Joints, Live, Measurement, Payload, Point, Reference, Sensed};

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
