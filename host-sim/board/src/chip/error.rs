//! Errors between host and chip.

use crate::key::KeyError;
use link::codec::FrameTooLong;
use link::{AsymmetricInertia, DecodeError, Distrust, Frame, Hello, JointCountMismatch, Refusal};
use std::path::PathBuf;
use std::time::Duration;

/// Reason why the chip cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ChipError {
    /// A program or file is missing.
    #[error("cannot start {program}: {source}; `cargo xtask setup` installs what is missing")]
    CannotStart {
        /// The program to start.
        program: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The firmware could not be built.
    #[error("the firmware could not be built:\n{output}")]
    Build {
        /// Output of the build.
        output: String,
    },
    /// The emulator ended.
    #[error("the emulator died ({status}) while {waiting_for} was awaited{output}")]
    Dead {
        /// Exit status.
        status: String,
        /// The awaited answer.
        waiting_for: &'static str,
        /// Output of the emulator, on separate lines.
        output: String,
    },
    /// No answer came in time.
    #[error("the chip is silent: {waiting_for} did not come within {timeout:?}")]
    Silent {
        /// The awaited answer.
        waiting_for: &'static str,
        /// Length of the wait.
        timeout: Duration,
    },
    /// The firmware was built for another robot or scene.
    #[error(
        "the firmware was built for another robot or scene: {}; build it again from this scene",
        difference(expected, found)
    )]
    OtherRobot {
        /// Hello of the host.
        expected: Hello,
        /// Hello of the chip.
        found: Hello,
    },
    /// A packet from the chip could not be decoded.
    #[error("from the chip: {0}")]
    Undecodable(#[from] DecodeError),
    /// Packets were lost.
    #[error("{missed} packets from the chip were lost")]
    Lost {
        /// Number of lost packets.
        missed: u32,
    },
    /// The chip did not use what it received.
    #[error("the chip refused: {}", refusal(.0))]
    Refused(Refusal),
    /// A frame that is not expected here.
    #[error("expected {expected} from the chip, got {found:?}")]
    Unexpected {
        /// The expected frame.
        expected: &'static str,
        /// The received frame.
        found: Box<Frame>,
    },
    /// The answer to another tick.
    #[error("the chip answered tick {found}, expected {expected}")]
    OtherTick {
        /// The requested tick.
        expected: u32,
        /// The answered tick.
        found: u32,
    },
    /// A fault with a number that this version does not know.
    #[error("the chip reports fault {code}, which this version does not know")]
    UnknownFault {
        /// The fault's number.
        code: u8,
    },
    /// A command for another number of joints.
    #[error("from the chip: {0}")]
    JointCount(#[from] JointCountMismatch),
    /// Live inputs that a frame cannot carry.
    #[error(transparent)]
    Asymmetric(#[from] AsymmetricInertia),
    /// A frame that cannot be sent.
    #[error(transparent)]
    TooLong(#[from] FrameTooLong),
    /// The chip's key does not match this host's key, or only one of the two has a key.
    #[error("{0}")]
    Distrust(#[from] Distrust),
    /// A key or a random number is not available.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// The socket to the emulator failed.
    #[error("link to the emulator: {0}")]
    Io(#[from] std::io::Error),
}

impl ChipError {
    /// Error for an unexpected frame; a refusal becomes [`ChipError::Refused`].
    pub(super) fn unexpected(expected: &'static str, found: Frame) -> Self {
        match found {
            Frame::Refusal(refusal) => Self::Refused(refusal),
            found => Self::Unexpected { expected, found: Box::new(found) },
        }
    }
}

fn difference(expected: &Hello, found: &Hello) -> String {
    let mut parts = Vec::new();
    if expected.robot != found.robot {
        parts.push(format!("hash {:016x}, expected {:016x}", found.robot, expected.robot));
    }
    if expected.joints != found.joints {
        parts.push(format!("{} joints, expected {}", found.joints, expected.joints));
    }
    if expected.rate_hz.to_bits() != found.rate_hz.to_bits() {
        parts.push(format!("{} Hz, expected {} Hz", found.rate_hz, expected.rate_hz));
    }
    parts.join("; ")
}

pub(crate) fn refusal(refusal: &Refusal) -> String {
    match refusal {
        Refusal::Undecodable(error) => error.to_string(),
        Refusal::Lost { missed } => format!("{missed} packets to the chip were lost"),
        Refusal::NoHello => "no hello has been agreed".into(),
        Refusal::JointCount { expected, found } => {
            format!("frame has values for {found} joints, the firmware has {expected}")
        }
        Refusal::OtherRobot => "hello for another robot".into(),
        Refusal::NoReference => "a measurement came before any reference".into(),
        Refusal::NonFiniteLive => "a live input is not a finite number".into(),
        Refusal::Unexpected => "a frame that only the chip sends, or that means nothing in this pacing".into(),
        Refusal::OwnMeasurements { count } => {
            format!("the board measures for itself and took no measurement from the host, {count} so far")
        }
        Refusal::Unauthentic { count } => format!(
            "{count} packets so far were not of this session: somebody else talks on the wire, or bytes were damaged"
        ),
        Refusal::NoKey => {
            "the board has no link key, and without one it does not arm: `cargo newtau firmware key new FILE`, then \
                           `cargo newtau firmware key write FILE --board BOARD`"
                .into()
        }
        Refusal::NoNonce => "the board's random number generator has failed".into(),
        Refusal::NonFinitePoint => "a point of the trajectory, or the way to it, is not a finite number".into(),
        Refusal::TrajectoryFull => "the trajectory has no room for another point".into(),
        Refusal::NoStart => "a point came before one to start from".into(),
        Refusal::Running => "a trajectory was started while the arm runs".into(),
        Refusal::NoParameter => "no parameter has this number".into(),
        Refusal::Fixed => "the parameter is fixed by the scene that the firmware was built from".into(),
        Refusal::OutOfBounds => "the value is outside its bounds".into(),
        Refusal::Driven => {
            "the arm is driven in the session of another scene, rate or pacing, which goes on: `newtau connect` with that scene takes it over".into()
        }
        Refusal::Busy => "another change waits for its tick".into(),
        Refusal::WouldJump { joint } => format!("the torque of joint {} would jump", joint + 1),
    }
}
