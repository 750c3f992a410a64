//! Frames of the link. All quantities are in SI units and radians; joint values start at the base.

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
/// | join | host | first, open: requests the board's identity and a challenge |
/// | challenge | MCU | answer to a join, open: identity, whether the board has a key, and its proof |
/// | proof | host | answer to a challenge, open: after it both sides seal every packet |
/// | hello | both | the MCU sends one after start, open; later the host sends one and the MCU answers: each compares |
/// | reference | host | before the measurement it belongs to; valid until the next one |
/// | live | host | before the tick from which it is valid; valid until the next one or a hello, which sets all of it to zero |
/// | measurement | host | once per tick; in lock step its arrival starts the tick |
/// | command | MCU | answer to a measurement |
/// | fault | MCU | answer to a measurement if the controller brakes |
/// | refusal | MCU | answer to any frame that could not be used |
/// | request | host | requests a change of the safety state machine; the MCU replies with an answer of the same number |
/// | lines | host | simulated lines of the board, from the next tick on; only in a dry run |
/// | point | host | the next point of the trajectory; answered only if it is refused |
/// | alive | host | heartbeat of the host; any other frame also counts as one |
/// | watch | host | which ticks to report, and which parts of them |
/// | dump | host | requests the contents of the black box |
/// | get, set | host | read or change a parameter; both are answered with its value |
/// | status | MCU | a tick under the safety state machine: every tick of a dry run, otherwise the watched ticks |
/// | past | MCU | a tick from the black box, oldest first; empty after the last |
/// | value | MCU | a parameter and its bounds |
/// | answer | MCU | the verdict on a request; sent again if the request is repeated |
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
    /// Reason why a received frame was not used.
    Refusal(Refusal),
    /// Live inputs of the scene.
    Live(Live),
    /// Request to the safety state machine, with a number.
    Request(NumberedRequest),
    /// State of a board's input lines.
    Lines(Lines),
    /// Next point of the trajectory.
    Point(Point),
    /// Heartbeat of the host.
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
    /// The board's identity, and which hosts it trusts.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Challenge(Challenge),
    /// Report of a tick.
    #[cfg_attr(not(feature = "host"), serde(skip_deserializing))]
    Status(Status),
    /// Report of a tick in the black box; `None` after the last.
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
    /// Number of kinds of frame that this side can decode. The first payload byte, the tag, is below it.
    ///
    /// Only a host (feature `host`) decodes the last five; on a chip their decoder would need 3 KiB of flash.
    pub const KINDS: u8 = if cfg!(feature = "host") { 22 } else { 17 };

    /// Creates a request frame with this number.
    #[must_use]
    pub const fn request(number: u8, request: Request) -> Self {
        Self::Request(NumberedRequest { number, request })
    }

    /// True if the count of open packets restarts here, because the frame begins a session or belongs to a handshake.
    pub(crate) const fn begins(&self) -> bool {
        matches!(self, Self::Hello(_) | Self::Join(_) | Self::Proof(_) | Self::Challenge(_))
    }
}

/// The board's identity, and which hosts it trusts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Challenge {
    /// The board's build data; its pacing has no meaning.
    pub own: Hello,
    /// The hosts that it trusts.
    pub trust: Trust,
}

/// The hosts that a board trusts.
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
    /// The board has no key: any host may use the bench modes, and none may drive the arm.
    NoKey,
    /// The board was built to trust any host.
    Insecure,
}

/// Origin of a board's nonces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NonceSource {
    /// The chip's random number generator.
    Generator,
    /// A random number stored with the key, a count in memory that survives a reset, and a timer.
    Counter,
}

/// Build data of a peer. Both sides send it, and they run only if it agrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Hash of the robot, the scene and the controller's configuration.
    pub robot: u64,
    /// Number of joints.
    pub joints: u8,
    /// Control rate, Hz.
    pub rate_hz: f32,
    /// Source of ticks: the host requests it, the MCU confirms it.
    pub pacing: Pacing,
}

/// Source of ticks, and whether the safety state machine runs between the controller and the drives.
///
/// The first two are bench modes: only the controller runs, and no drive is ever driven. The torque is only sent back over the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pacing {
    /// Bench mode in lock step: each measurement starts a tick. For an emulated chip, which does not stop while the host computes.
    LockStep,
    /// Bench mode with a timer: ticks start at the control rate. A tick uses the newest measurement and its age.
    Timer,
    /// Dry run: the safety state machine runs, each measurement starts a tick, and the host simulates the board's lines. No drive is driven.
    DryRun,
    /// Operation: the safety state machine runs, the timer starts ticks, and the drives are driven.
    Live,
}

impl Pacing {
    /// True if each measurement starts a tick.
    #[must_use]
    pub const fn is_lock_step(self) -> bool {
        matches!(self, Self::LockStep | Self::DryRun)
    }

    /// True if the safety state machine runs between the controller and the drives.
    #[must_use]
    pub const fn is_supervised(self) -> bool {
        matches!(self, Self::DryRun | Self::Live)
    }
}
