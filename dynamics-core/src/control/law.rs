//! The control laws.

use super::Reference;
use super::config::ControllerConfig;
use crate::fields::{record, words};
use crate::newton_euler::InverseDynamics;
use crate::scalar::{Real, Scalar};
use crate::scene::Live;
use crate::trig::{SinCos, Trig};

/// Control law: torques from the reference and the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`: the error obeys `e'' + Kd e' + Kp e = 0`.
    ComputedTorque,
    /// `tau = M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`, with a fixed inertia `M0` per joint: no model in the loop.
    Pd,
    /// [`Law::Pd`] plus the torque that holds the arm still where it is, `ID(q, 0, 0)`.
    PdGravity,
    /// `tau = M0 (qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)) + ID(q, 0, 0)`: gravity and the loads at the tip
    /// exactly, inertia as the fixed `M0` per joint, no velocity terms. [`Law::ComputedTorque`] of an arm whose inertia
    /// really is `M0`.
    DiagonalInertia,
    /// [`Law::Pd`] plus the torque of the reference motion, `ID(q_ref, qd_ref, qdd_ref)`.
    Feedforward,
    /// `tau = ID(q, qd, qdd_ref) + M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`: the model moves the arm, and each joint is a spring of
    /// the stiffness `K = M0 Kp` with a damper `D = M0 Kd` about its reference. With an exact model `M(q) e'' + D e' + K e` is the
    /// torque from outside: a steady one moves a joint by `tau / K`, in any posture, and a joint that is kept from its reference
    /// pushes with `K e`.
    Impedance,
    /// `tau = ID(q, 0, 0)` plus [`Teach`](super::Teach) while the arm runs: it is led by hand, and follows no reference.
    /// [`Law::PdGravity`] while it is armed or held.
    Teach,
    /// The torque of [`Law::Impedance`], whose spring and damper the actuators' own loops renew between two ticks: each is told the
    /// torque, the measurement that it follows from, and its [`Spring`]. The bus's delay is outside of that loop.
    Split,
}

/// Properties of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LawTraits {
    /// Source of the motion while the arm runs.
    pub motion: MotionSource,
    /// Torque that the law asks of the model.
    pub model: ModelUse,
    /// Owner of the spring and damper that each joint has for itself.
    pub spring: SpringOwner,
    /// Reason why the collision watch may only report beside this law; `None` where it may act.
    pub watch_only_reports: Option<&'static str>,
}

/// Source of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionSource {
    /// A trajectory: the law follows its reference.
    Reference,
    /// A person who leads the arm by hand: the reference is where the arm is.
    Hand,
}

/// Torque that a law asks of the model.
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

/// Owner of the spring and the damper that each joint has for itself, with a stiffness in N m/rad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringOwner {
    /// The law has no such spring.
    Nobody,
    /// The controller, in each tick.
    Controller,
    /// The drive's own loop, between two ticks.
    Drive,
}

impl Law {
    /// All of them, by [`Law::code`].
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

    /// The law with this number as a parameter carries it, to the bit.
    #[must_use]
    pub fn from_number(number: f32) -> Option<Self> {
        Self::ALL.into_iter().find(|law| f32::from(law.code()).to_bits() == number.to_bits())
    }

    /// Properties that machine, session, readers and reports ask for. Outside of this file no code tells laws apart by name.
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

    /// True if a hand leads the arm while it runs.
    #[inline]
    #[must_use]
    pub const fn is_led(self) -> bool {
        matches!(self.traits().motion, MotionSource::Hand)
    }

    /// The law of an arm that is armed or held: one that is led by hand then stands where it is.
    #[inline]
    #[must_use]
    pub const fn standing(self) -> Self {
        if self.is_led() { Self::PdGravity } else { self }
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

    /// True if the arm's weight is carried where the arm is, `ID(q, 0, 0)` or as part of more.
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

words!(Law {
    ComputedTorque = 0, Pd = 1, PdGravity = 2, Feedforward = 3, DiagonalInertia = 4, Impedance = 5, Teach = 6, Split = 7
});

/// Spring and damper of one joint: `-K dq - D dqd` beside a torque, `dq` and `dqd` from where that torque was worked out.
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
        /// `M0`, the inertia that turns an acceleration into a torque in the laws without a model of the inertia in the loop, and
        /// between two evaluations of [`super::EveryNth`], kg m^2 or kg.
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

/// Inputs of a law.
pub(super) struct State<'a, S, const N: usize> {
    pub(super) reference: &'a Reference<S, N>,
    pub(super) q: &'a [S; N],
    pub(super) qd: &'a [S; N],
    pub(super) live: &'a Live<S, N>,
    /// Sine and cosine of `q`, where this tick has computed them already.
    pub(super) turn: Option<[SinCos<S>; N]>,
}

/// Sine and cosine of `q`, worked out once in a tick.
#[inline]
fn known_or_new<S: Real, const N: usize>(
    trig: &impl Trig<S>,
    turn: Option<[SinCos<S>; N]>,
    q: &[S; N],
) -> [SinCos<S>; N] {
    match turn {
        Some(turn) => turn,
        None => trig.sin_cos_all(q),
    }
}

/// The acceleration that corrects the error of each joint, rad/s^2 or m/s^2.
///
/// `Kd (qd_ref - qd) + Kp (q_ref - q)`
#[inline]
fn spring<S: Scalar, const N: usize>(
    gains: &[Gains<S>; N],
    reference: &Reference<S, N>,
    q: &[S; N],
    qd: &[S; N],
) -> [S; N] {
    core::array::from_fn(|i| {
        gains[i].velocity * (reference.qd[i] - qd[i]) + gains[i].position * (reference.q[i] - q[i])
    })
}

/// The acceleration of each joint that follows the reference and corrects the error, rad/s^2 or m/s^2.
///
/// `qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)`
#[inline]
fn wanted<S: Scalar, const N: usize>(
    gains: &[Gains<S>; N],
    reference: &Reference<S, N>,
    q: &[S; N],
    qd: &[S; N],
) -> [S; N] {
    let spring = spring(gains, reference, q, qd);
    core::array::from_fn(|i| reference.qdd[i] + spring[i])
}

/// Torques of [`Law::ComputedTorque`], before friction and limits.
///
/// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`
///
/// | name | quantity | unit | shape |
/// |---|---|---|---|
/// | `gains` | `Kp`, `Kd` | 1/s^2, 1/s | N |
/// | `turn` | gives sine and cosine of each joint | - | N |
/// | `reference` | where the arm should be | rad, rad/s, rad/s^2; m, .. | N |
/// | `q`, `qd` | where it is | rad, rad/s; m, m/s | N |
/// | `live` | the scene's live inputs | | |
/// | return | actuator torque or force | N m, N | N |
///
/// On a [`Scalar`], as the recursions are: the whole law can be traced into one kernel, with its gains as numbers in it.
/// Cost: one inverse dynamics and `6 N` operations.
#[inline]
pub fn computed_torque<S: Scalar, const N: usize>(
    gains: &[Gains<S>; N],
    dynamics: &impl InverseDynamics<S, N>,
    turn: impl FnOnce() -> [SinCos<S>; N],
    reference: &Reference<S, N>,
    (q, qd): (&[S; N], &[S; N]),
    live: &Live<S, N>,
) -> [S; N] {
    let wanted = wanted(gains, reference, q, qd);
    // Sine and cosine only now: fewer values have to be kept meanwhile. 43 instructions a tick on a Cortex-M4F.
    dynamics.inverse_dynamics(&turn(), q, qd, &wanted, live)
}

/// Torques before friction and limits, N m or N; an arm that complies has its weight carried and its motion damped, without any
/// stiffness: `tau = ID(q, 0, 0) - M0 Kd qd`. An arm that is led by hand has its weight carried and its speed fall, by its own inertia:
/// `tau = ID(q, 0, -qd / T)`.
#[inline]
pub(super) fn torques<S: Real, const N: usize>(
    (law, complies): (Law, bool),
    config: &ControllerConfig<S, N>,
    dynamics: &mut impl InverseDynamics<S, N>,
    trig: &impl Trig<S>,
    state: &State<'_, S, N>,
) -> [S; N] {
    let State { reference, q, qd, live, turn } = *state;
    let ControllerConfig { gains, posture_damping: through_model, teach, .. } = config;
    let zero = [S::zero(); N];
    // Nothing is wanted of an arm that complies.
    let wanted: [S; N] = if complies { zero } else { wanted(gains, reference, q, qd) };
    // `law` is a constant of a firmware and `complies` is not: asked apart, what other laws need is left out.
    let (at, turn) = match law {
        Law::Feedforward if !complies => (&reference.q, None),
        _ => (q, turn),
    };
    let damped;
    let (speed, acceleration) = match law {
        _ if complies => (&zero, &wanted),
        // `computed_torque`, by a dynamics that may keep state.
        Law::ComputedTorque => (qd, &wanted),
        Law::Impedance | Law::Split => match through_model {
            None => (qd, &reference.qdd),
            Some(share) => {
                let of = |i: usize| *share * gains[i].velocity * (reference.qd[i] - qd[i]);
                damped = core::array::from_fn(|i| reference.qdd[i] + of(i));
                (qd, &damped)
            }
        },
        Law::Feedforward => (&reference.qd, &reference.qdd),
        Law::Teach => match teach {
            None => (&zero, &zero),
            Some(teach) => {
                damped = core::array::from_fn(|i| -(teach[i].slowing * qd[i]));
                (&zero, &damped)
            }
        },
        Law::Pd | Law::PdGravity | Law::DiagonalInertia => (&zero, &zero),
    };
    let of_model = match law {
        Law::Pd if !complies => zero,
        // One call for all: called from two places, the kernel would not become part of the tick.
        _ => dynamics.tick(|| known_or_new(trig, turn, at), at, speed, acceleration, live),
    };
    let with = |acceleration: [S; N]| core::array::from_fn(|i| of_model[i] + gains[i].inertia * acceleration[i]);
    match law {
        _ if complies => core::array::from_fn(|i| of_model[i] - gains[i].inertia * (gains[i].velocity * qd[i])),
        Law::ComputedTorque | Law::Teach => of_model,
        Law::DiagonalInertia => with(wanted),
        Law::Impedance | Law::Split if through_model.is_some() => {
            let rest = S::one() - through_model.unwrap_or(S::zero());
            with(core::array::from_fn(|i| {
                let Gains { position, velocity, .. } = gains[i];
                rest * velocity * (reference.qd[i] - qd[i]) + position * (reference.q[i] - q[i])
            }))
        }
        Law::Pd | Law::PdGravity | Law::Feedforward | Law::Impedance | Law::Split => {
            with(spring(gains, reference, q, qd))
        }
    }
}
