//! Findings: a rule's result, and its position in the file.

use crate::describe::diagnostics::FileError;
use crate::describe::draft::{Draft, FileKind, Place};

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Physically impossible, or the arm cannot hold itself.
    Wrong,
    /// Improbable: a placeholder, another unit, or a missing value.
    Doubt,
    /// Missing: measure it.
    Note,
}

impl Severity {
    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wrong => "wrong",
            Self::Doubt => "doubt",
            Self::Note => "note",
        }
    }
}

/// Subject of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CheckRule {
    /// A body that no mass distribution can have.
    ImpossibleBody,
    /// No mass, or only grams, on a link that a joint moves.
    Mass,
    /// A radius of gyration that is too large for the link, or nearly zero.
    Gyration,
    /// An inertia tensor about the joint instead of the mass centre.
    InertiaAtJoint,
    /// A mass centre outside of the link.
    MassCentre,
    /// A limit with which no joint can work.
    ImpossibleLimit,
    /// A limit that is a placeholder.
    Placeholder,
    /// A limit that is missing.
    MissingLimit,
    /// A limit so wide that it limits nothing.
    WideLimit,
    /// Torque needed to hold the arm, compared with the torque available.
    Holding,
    /// Rotor inertia after the gear.
    Rotor,
    /// Friction of a driven joint.
    Friction,
    /// The step of a drive's torque.
    TorqueStep,
    /// The step of a measured position.
    PositionStep,
    /// Torque that a motor must give continuously, compared with what it can.
    Heat,
    /// A rest pose from which a joint sinks.
    Rest,
    /// A number that is a power of ten off: another unit.
    Unit,
    /// An angle beyond a turn: degrees.
    Angle,
    /// A tensor whose axes are exchanged.
    SwappedAxes,
    /// An element or attribute that URDF does not have.
    UnknownName,
    /// A joint outside the arm that is held at an impossible position.
    HeldJoint,
    /// A question that `import` left open, and that is still unanswered.
    OpenQuestion,
    /// Gravity of a magnitude that occurs nowhere on earth, or that contradicts the robot file's mounting.
    Gravity,
    /// A payload out of reach, or heavier than the arm can hold.
    Payload,
    /// A scene of an arm with drives that does not limit the first motion after homing.
    FirstMotion,
    /// Live inputs of an arm with drives whose age is not limited.
    LiveAge,
    /// Time of the brakes of an arm with drives that is zero, or is not given.
    BrakeDelay,
    /// A loop that oscillates when it holds the simulated arm.
    Oscillation,
}

impl CheckRule {
    /// All rules.
    pub const ALL: [Self; 28] = [
        Self::ImpossibleBody,
        Self::Mass,
        Self::Gyration,
        Self::InertiaAtJoint,
        Self::MassCentre,
        Self::ImpossibleLimit,
        Self::Placeholder,
        Self::MissingLimit,
        Self::WideLimit,
        Self::Holding,
        Self::Rotor,
        Self::Friction,
        Self::TorqueStep,
        Self::PositionStep,
        Self::Heat,
        Self::Rest,
        Self::Unit,
        Self::Angle,
        Self::SwappedAxes,
        Self::UnknownName,
        Self::HeldJoint,
        Self::OpenQuestion,
        Self::Gravity,
        Self::Payload,
        Self::FirstMotion,
        Self::LiveAge,
        Self::BrakeDelay,
        Self::Oscillation,
    ];

    /// True for a rule about the settings of a scene: its safety, or the gains of its controller.
    #[must_use]
    pub const fn is_of_scene(self) -> bool {
        matches!(self, Self::FirstMotion | Self::LiveAge | Self::BrakeDelay | Self::Oscillation)
    }

    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ImpossibleBody => "impossible-body",
            Self::Mass => "mass",
            Self::Gyration => "gyration",
            Self::InertiaAtJoint => "inertia-at-joint",
            Self::MassCentre => "mass-centre",
            Self::ImpossibleLimit => "impossible-limit",
            Self::Placeholder => "placeholder",
            Self::MissingLimit => "missing-limit",
            Self::WideLimit => "wide-limit",
            Self::Holding => "holding-torque",
            Self::Rotor => "rotor",
            Self::Friction => "friction",
            Self::TorqueStep => "torque-step",
            Self::PositionStep => "position-step",
            Self::Heat => "heat",
            Self::Rest => "rest",
            Self::Unit => "unit",
            Self::Angle => "angle",
            Self::SwappedAxes => "swapped-axes",
            Self::UnknownName => "unknown-name",
            Self::HeldJoint => "held-joint",
            Self::OpenQuestion => "open-question",
            Self::Gravity => "gravity",
            Self::Payload => "payload",
            Self::FirstMotion => "first-motion",
            Self::LiveAge => "live-age",
            Self::BrakeDelay => "brake-delay",
            Self::Oscillation => "oscillation",
        }
    }
}

/// An impossible, improbable or missing value of a robot file.
#[derive(Debug)]
pub struct Finding {
    /// The rule that found it.
    pub rule: CheckRule,
    /// Its severity.
    pub severity: Severity,
    /// The position in the file and the problem; the expectation is what to measure or write instead.
    pub place: FileError,
    /// The text of the file that the finding is about, on one line; `None` if something is missing.
    pub quote: Option<String>,
}

/// Widest quote of a file.
const COLUMNS: usize = 120;

impl Finding {
    pub(super) fn new(
        draft: &Draft,
        (rule, severity): (CheckRule, Severity),
        place: &Place,
        problem: String,
        advice: String,
    ) -> Self {
        let place_error = draft.error(place, problem, advice);
        let quote = place_error.quote(COLUMNS);
        // The span of a value in TOML does not include its key.
        let key = place.field.rsplit('.').next().filter(|_| draft.kind == FileKind::Toml);
        let quote = key.map_or(quote.clone(), |key| format!("{key} = {quote}"));
        Self { rule, severity, place: place_error, quote: Some(quote).filter(|_| place.given) }
    }
}

/// Load of a joint over all postures inside the limits.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLoad {
    /// Largest torque or force of gravity, N m or N.
    pub holding: f64,
    /// The posture with the largest torque, rad or m.
    pub posture: Vec<f64>,
    /// Smallest and largest diagonal entry of the inertia matrix without rotors, kg m^2 or kg.
    pub inertia: (f64, f64),
    /// Torque or force that holds the joint in the rest pose, N m or N; `None` without a rest pose.
    pub rest: Option<f64>,
}
