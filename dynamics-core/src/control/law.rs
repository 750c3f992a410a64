//! The control laws and their properties. Their torques are in `law_torques.rs`.

use crate::fields::{record, words};
use crate::scalar::Real;

/// Control law: torques from the reference and the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlLaw {
    /// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`: the error obeys `e'' + Kd e' + Kp e = 0`.
    ComputedTorque,
    /// `tau = M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`, with a fixed inertia `M0` per joint: no model in the loop.
    Pd,
    /// [`ControlLaw::Pd`] plus the torque that holds the arm at rest at its position, `ID(q, 0, 0)`.
    PdGravity,
    /// `tau = M0 (qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)) + ID(q, 0, 0)`: exact gravity and loads at the tip, inertia as
    /// the fixed `M0` per joint, no velocity terms. Equal to [`ControlLaw::ComputedTorque`] for an arm whose inertia really is
    /// `M0`.
    DiagonalInertia,
    /// [`ControlLaw::Pd`] plus the torque of the reference motion, `ID(q_ref, qd_ref, qdd_ref)`.
    Feedforward,
    /// `tau = ID(q, qd, qdd_ref) + M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`: the model moves the arm, and each joint has a spring of
    /// stiffness `K = M0 Kp` and a damper `D = M0 Kd` about its reference. With an exact model, `M(q) e'' + D e' + K e` equals the
    /// torque from outside. A steady external torque moves a joint by `tau / K`, in any posture. A joint that is kept from its reference
    /// pushes with `K e`.
    Impedance,
    /// `tau = ID(q, 0, 0)` plus [`Teach`](super::Teach) while the arm runs: it is hand-guided, and follows no reference.
    /// [`ControlLaw::PdGravity`] while it is armed or held.
    Teach,
    /// The torque of [`ControlLaw::Impedance`], with the spring and damper updated by the actuators' own loops between two ticks. Each actuator gets
    /// the torque, the measurement from which it was computed, and its [`Spring`]. The delay of the bus is not in that loop.
    Split,
}

/// Properties of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LawTraits {
    /// Source of the motion while the arm runs.
    pub motion: MotionSource,
    /// The part of the model that the law uses.
    pub model: ModelUse,
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

impl ControlLaw {
    /// All control laws, in the order of [`ControlLaw::code`].
    pub const ALL: [Self; 8] = [
        Self::ComputedTorque,
        Self::Pd,
        Self::PdGravity,
        Self::Feedforward,
        Self::DiagonalInertia,
        Self::Impedance,
        Self::Teach,
        Self::Split,
    ];

    /// Stable number of the law, in hashes and on the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::ComputedTorque => 0,
            Self::Pd => 1,
            Self::PdGravity => 2,
            Self::Feedforward => 3,
            Self::DiagonalInertia => 4,
            Self::Impedance => 5,
            Self::Teach => 6,
            Self::Split => 7,
        }
    }

    /// The law with this number, if the number equals a law's code exactly. Parameters carry the law as a number.
    #[must_use]
    pub fn from_number(number: f32) -> Option<Self> {
        Self::ALL.into_iter().find(|law| f32::from(law.code()).to_bits() == number.to_bits())
    }

    /// Properties that the state machine, session, readers and reports use. Outside of this file and
    /// `law_torques.rs` no code distinguishes laws by name.
    #[must_use]
    pub const fn traits(self) -> LawTraits {
        let of_controller = LawTraits {
            motion: MotionSource::Reference,
            model: ModelUse::Motion,
            spring: SpringOwner::Controller,
            watch_only_reports: None,
        };
        match self {
            Self::ComputedTorque => LawTraits { spring: SpringOwner::Nobody, ..of_controller },
            Self::Pd => LawTraits { model: ModelUse::Nothing, spring: SpringOwner::Nobody, ..of_controller },
            Self::PdGravity | Self::DiagonalInertia => {
                LawTraits { model: ModelUse::Holding, spring: SpringOwner::Nobody, ..of_controller }
            }
            Self::Feedforward => LawTraits { model: ModelUse::Reference, spring: SpringOwner::Nobody, ..of_controller },
            Self::Impedance => of_controller,
            Self::Teach => LawTraits {
                motion: MotionSource::Hand,
                model: ModelUse::Holding,
                spring: SpringOwner::Nobody,
                watch_only_reports: Some("the hand that leads the arm is no collision"),
            },
            Self::Split => LawTraits {
                spring: SpringOwner::Drive,
                watch_only_reports: Some("the drives' own loops give torque that the watch does not see"),
                ..of_controller
            },
        }
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

    /// True if the model's inertia turns the feedback's acceleration into torques; otherwise the fixed `M0` does.
    #[must_use]
    pub const fn feeds_back_through_model(self) -> bool {
        match self {
            Self::ComputedTorque => true,
            Self::Pd
            | Self::PdGravity
            | Self::DiagonalInertia
            | Self::Feedforward
            | Self::Impedance
            | Self::Teach
            | Self::Split => false,
        }
    }

    /// True if the law carries the arm's weight at its current position: `ID(q, 0, 0)`, alone or as part of a larger term.
    #[must_use]
    pub const fn carries_weight(self) -> bool {
        match self {
            Self::ComputedTorque
            | Self::PdGravity
            | Self::DiagonalInertia
            | Self::Impedance
            | Self::Teach
            | Self::Split => true,
            Self::Pd | Self::Feedforward => false,
        }
    }
}

words!(ControlLaw {
    ComputedTorque = 0, Pd = 1, PdGravity = 2, Feedforward = 3, DiagonalInertia = 4, Impedance = 5, Teach = 6, Split = 7
});

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
