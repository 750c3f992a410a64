//! The control laws and their properties. Their torques are in `law_torques.rs`.

use crate::fields::{record, words};
use crate::scalar::Real;

/// Properties of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LawTraits {
    /// Source of the motion while the arm runs.
    pub motion: MotionSource,
    /// The part of the model that the law uses.
    pub model: ModelUse,
    /// The inertia that turns the feedback's acceleration into torques.
    pub feedback: FeedbackInertia,
    /// True if the law carries the arm's weight at its current position: `ID(q, 0, 0)`, alone or as part of a larger term.
    pub carries_weight: bool,
    /// Owner of the spring and damper of each joint.
    pub spring: SpringOwner,
    /// Reason why the collision watch may only report with this law; `None` if it may act.
    pub watch_only_reports: Option<&'static str>,
}

/// Source of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionSource {
    /// A trajectory: the law follows its reference.
    Reference,
    /// A person who guides the arm by hand: the reference is where the arm is.
    Hand,
}

/// The part of the model that a law uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelUse {
    /// None.
    Nothing,
    /// `ID(q, 0, 0)`.
    Holding,
    /// `ID(q, qd, ..)`.
    Motion,
    /// `ID(q_ref, qd_ref, qdd_ref)`.
    Reference,
}

/// The inertia that turns the feedback's acceleration into torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedbackInertia {
    /// The fixed `M0` of each joint.
    Fixed,
    /// The model's, `M(q)`.
    Model,
}

/// Owner of the spring and the damper that act on each joint alone, with a stiffness in N m/rad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringOwner {
    /// The law has no such spring.
    Nobody,
    /// The controller, in each tick.
    Controller,
    /// The drive's own loop, between two ticks.
    Drive,
}

/// The one list of laws: number, name, its name in a scene file, a line about it, its equation, and its properties. The enum, the numbers, the
/// names and the properties are made from it. The torques are in `law_torques.rs`.
macro_rules! laws {
    ($($code:literal $name:ident $text:literal $about:literal, $(#[doc = $doc:literal])* => $traits:expr;)*) => {
        /// Control law: torques from the reference and the state.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum ControlLaw {
            $($(#[doc = $doc])* $name,)*
        }

        impl ControlLaw {
            /// All control laws, in the order of [`ControlLaw::code`].
            pub const ALL: [Self; [$($code),*].len()] = [$(Self::$name),*];

            /// Stable number of the law, in hashes and on the wire.
            #[must_use]
            pub const fn code(self) -> u8 {
                match self {
                    $(Self::$name => $code,)*
                }
            }

            /// Name of the law in a scene file.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)*
                }
            }

            /// The law in one line.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $(Self::$name => $about,)*
                }
            }

            /// Properties that the state machine, session, readers and reports use. Outside of this file and
            /// `law_torques.rs` no code distinguishes laws by name.
            #[must_use]
            pub const fn traits(self) -> LawTraits {
                match self {
                    $(Self::$name => $traits,)*
                }
            }
        }

        words!(ControlLaw { $($name = $code),* });
    };
}

/// A law without a model and without a spring that somebody could feel.
const PD: LawTraits = LawTraits {
    motion: MotionSource::Reference,
    model: ModelUse::Nothing,
    feedback: FeedbackInertia::Fixed,
    carries_weight: false,
    spring: SpringOwner::Nobody,
    watch_only_reports: None,
};

/// [`PD`] on an arm whose weight is carried.
const WITH_WEIGHT: LawTraits = LawTraits { model: ModelUse::Holding, carries_weight: true, ..PD };

/// Springs of a chosen stiffness on an arm that the model moves.
const IMPEDANCE: LawTraits =
    LawTraits { model: ModelUse::Motion, carries_weight: true, spring: SpringOwner::Controller, ..PD };

laws! {
    0 ComputedTorque "computed-torque" "Inverse dynamics of the measured state and a corrected acceleration",
    /// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`: the error obeys `e'' + Kd e' + Kp e = 0`.
    => LawTraits { spring: SpringOwner::Nobody, feedback: FeedbackInertia::Model, ..IMPEDANCE };

    1 Pd "pd" "Spring and damper per joint",
    /// `tau = M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`, with a fixed inertia `M0` per joint: no model in the loop.
    => PD;

    2 PdGravity "pd-gravity" "Spring and damper, and the torque that holds the arm",
    /// [`ControlLaw::Pd`] plus the torque that holds the arm at rest at its position, `ID(q, 0, 0)`.
    => WITH_WEIGHT;

    3 Feedforward "feedforward" "Spring and damper, and the torque of the reference motion",
    /// [`ControlLaw::Pd`] plus the torque of the reference motion, `ID(q_ref, qd_ref, qdd_ref)`.
    => LawTraits { model: ModelUse::Reference, ..PD };

    4 DiagonalInertia "diagonal-inertia"
    "A fixed inertia per joint for the commanded acceleration, and the torque that holds the arm",
    /// `tau = M0 (qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)) + ID(q, 0, 0)`: exact gravity and loads at the tip, inertia as
    /// the fixed `M0` per joint, no velocity terms. Equal to [`ControlLaw::ComputedTorque`] for an arm whose inertia really is
    /// `M0`.
    => WITH_WEIGHT;

    5 Impedance "impedance" "Spring and damper of a chosen stiffness, and all that the model knows",
    /// `tau = ID(q, qd, qdd_ref) + M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`: the model moves the arm, and each joint has a spring of
    /// stiffness `K = M0 Kp` and a damper `D = M0 Kd` about its reference. With an exact model, `M(q) e'' + D e' + K e` equals the
    /// torque from outside. A steady external torque moves a joint by `tau / K`, in any posture. A joint that is kept from its reference
    /// pushes with `K e`.
    => IMPEDANCE;

    6 Teach "teach" "Hand guiding: weight carried, friction compensated, soft walls at the limits",
    /// `tau = ID(q, 0, 0)` plus [`Teach`](super::Teach) while the arm runs: it is hand-guided, and follows no reference.
    /// [`ControlLaw::PdGravity`] while it is armed or held.
    => LawTraits {
        motion: MotionSource::Hand,
        watch_only_reports: Some("the hand that leads the arm is no collision"),
        ..WITH_WEIGHT
    };

    7 Split "split" "Impedance whose spring and damper are in the actuators' own loops",
    /// The torque of [`ControlLaw::Impedance`], with the spring and damper updated by the actuators' own loops between two ticks. Each actuator gets
    /// the torque, the measurement from which it was computed, and its [`Spring`]. The delay of the bus is not in that loop.
    => LawTraits {
        spring: SpringOwner::Drive,
        watch_only_reports: Some("the drives' own loops give torque that the watch does not see"),
        ..IMPEDANCE
    };
}

impl ControlLaw {
    /// The law with this number, if the number equals a law's code exactly. Parameters carry the law as a number.
    #[must_use]
    pub fn from_number(number: f32) -> Option<Self> {
        Self::ALL.into_iter().find(|law| f32::from(law.code()).to_bits() == number.to_bits())
    }

    /// True if the arm is hand-guided while it runs.
    #[inline]
    #[must_use]
    pub const fn is_hand_guided(self) -> bool {
        matches!(self.traits().motion, MotionSource::Hand)
    }

    /// The law of an arm that is armed or held: a hand-guided arm then stays where it is.
    #[inline]
    #[must_use]
    pub const fn standing(self) -> Self {
        if self.is_hand_guided() { Self::PdGravity } else { self }
    }
}

/// Spring and damper of one joint. They add `-K dq - D dqd` to a torque; `dq` and `dqd` are measured from the state for which that torque
/// was computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring<S> {
    /// `K`, N m/rad or N/m.
    pub stiffness: S,
    /// `D`, N m s/rad or N s/m.
    pub damping: S,
}

record! {
    /// Gains of one joint: they make an error of the joint behave as a mass on a spring with a damper.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Gains<S> {
        /// `Kp = omega^2`, 1/s^2.
        pub position: S,
        /// `Kd = 2 zeta omega`, 1/s.
        pub velocity: S,
        /// `M0`, kg m^2 or kg: converts an acceleration into a torque in the laws without a model of the inertia in the loop, and
        /// between two evaluations of [`super::EveryNth`].
        pub inertia: S,
    }
}

impl<S: Real> Gains<S> {
    /// From natural frequency (rad/s), damping ratio, and the joint's inertia (kg m^2 or kg).
    #[must_use]
    pub fn new(natural_frequency: f64, damping: f64, inertia: f64) -> Self {
        Self {
            position: S::literal(natural_frequency * natural_frequency),
            velocity: S::literal(2.0 * damping * natural_frequency),
            inertia: S::literal(inertia),
        }
    }

    /// Spring and damper that these gains make of a joint with the inertia `M0`: `K = M0 Kp`, `D = M0 Kd`.
    #[inline]
    #[must_use]
    pub fn spring(&self) -> Spring<S> {
        Spring { stiffness: self.inertia * self.position, damping: self.inertia * self.velocity }
    }
}
