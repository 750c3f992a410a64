//! The torques of the control laws.

use super::Reference;
use super::config::ControllerConfig;
use super::law::{ControlLaw, Gains};
use crate::newton_euler::InverseDynamics;
use crate::scalar::{Real, Scalar};
use crate::scene::Live;
use crate::trig::{SinCos, Trig};

/// Inputs of a law.
pub(super) struct LawInputs<'a, S, const N: usize> {
    pub(super) reference: &'a Reference<S, N>,
    pub(super) q: &'a [S; N],
    pub(super) qd: &'a [S; N],
    pub(super) live: &'a Live<S, N>,
    /// Sine and cosine of `q`, if this tick has computed them already.
    pub(super) turn: Option<[SinCos<S>; N]>,
}

/// Sine and cosine of `q`, computed once in a tick.
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

/// Torques of [`ControlLaw::ComputedTorque`], before friction and limits.
///
/// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`
///
/// | name | quantity | unit | shape |
/// |---|---|---|---|
/// | `gains` | `Kp`, `Kd` | 1/s^2, 1/s | N |
/// | `turn` | gives sine and cosine of each joint | - | N |
/// | `reference` | desired motion | rad, rad/s, rad/s^2; m, .. | N |
/// | `q`, `qd` | measured state | rad, rad/s; m, m/s | N |
/// | `live` | the scene's live inputs | | |
/// | return | actuator torque or force | N m, N | N |
///
/// Written on [`Scalar`], like the recursions, so the whole law can be traced into one kernel that contains its gains as numbers.
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
    // Sine and cosine are computed only now, so that fewer values have to be kept meanwhile: saves 43 instructions a tick on a Cortex-M4F.
    dynamics.inverse_dynamics(&turn(), q, qd, &wanted, live)
}

/// Torques before friction and limits, N m or N. For a compliant arm the weight is carried and the motion damped, without any
/// stiffness: `tau = ID(q, 0, 0) - M0 Kd qd`. For a hand-guided arm the weight is carried and the speed decays through the arm's own inertia:
/// `tau = ID(q, 0, -qd / T)`.
#[inline]
pub(super) fn torques<S: Real, const N: usize>(
    (law, complies): (ControlLaw, bool),
    config: &ControllerConfig<S, N>,
    dynamics: &mut impl InverseDynamics<S, N>,
    trig: &impl Trig<S>,
    state: &LawInputs<'_, S, N>,
) -> [S; N] {
    let LawInputs { reference, q, qd, live, turn } = *state;
    let ControllerConfig { gains, posture_damping: through_model, teach, .. } = config;
    let zero = [S::zero(); N];
    // A compliant arm follows no wanted acceleration.
    let wanted: [S; N] = if complies { zero } else { wanted(gains, reference, q, qd) };
    // `law` is a constant in a firmware and `complies` is not: testing them separately removes the code of all other laws.
    let (at, turn) = match law {
        ControlLaw::Feedforward if !complies => (&reference.q, None),
        _ => (q, turn),
    };
    let damped;
    let (speed, acceleration) = match law {
        _ if complies => (&zero, &wanted),
        // As `computed_torque`, by a dynamics that may keep state.
        ControlLaw::ComputedTorque => (qd, &wanted),
        ControlLaw::Impedance | ControlLaw::Split => match through_model {
            None => (qd, &reference.qdd),
            Some(share) => {
                let of = |i: usize| *share * gains[i].velocity * (reference.qd[i] - qd[i]);
                damped = core::array::from_fn(|i| reference.qdd[i] + of(i));
                (qd, &damped)
            }
        },
        ControlLaw::Feedforward => (&reference.qd, &reference.qdd),
        ControlLaw::Teach => match teach {
            None => (&zero, &zero),
            Some(teach) => {
                damped = core::array::from_fn(|i| -(teach[i].slowing * qd[i]));
                (&zero, &damped)
            }
        },
        ControlLaw::Pd | ControlLaw::PdGravity | ControlLaw::DiagonalInertia => (&zero, &zero),
    };
    let of_model = match law {
        ControlLaw::Pd if !complies => zero,
        // One call for all laws: with two call sites the compiler would not inline the kernel into the tick.
        _ => dynamics.tick(|| known_or_new(trig, turn, at), at, speed, acceleration, live),
    };
    let with = |acceleration: [S; N]| core::array::from_fn(|i| of_model[i] + gains[i].inertia * acceleration[i]);
    match law {
        _ if complies => core::array::from_fn(|i| of_model[i] - gains[i].inertia * (gains[i].velocity * qd[i])),
        ControlLaw::ComputedTorque | ControlLaw::Teach => of_model,
        ControlLaw::DiagonalInertia => with(wanted),
        ControlLaw::Impedance | ControlLaw::Split if through_model.is_some() => {
            let rest = S::one() - through_model.unwrap_or(S::zero());
            with(core::array::from_fn(|i| {
                let Gains { position, velocity, .. } = gains[i];
                rest * velocity * (reference.qd[i] - qd[i]) + position * (reference.q[i] - q[i])
            }))
        }
        ControlLaw::Pd
        | ControlLaw::PdGravity
        | ControlLaw::Feedforward
        | ControlLaw::Impedance
        | ControlLaw::Split => with(spring(gains, reference, q, qd)),
    }
}
