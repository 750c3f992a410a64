//! Time scaling to torque limits.

use super::Motion;
use super::bounds::{Bounds, largest};
use super::error::MotionError;
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::Trig;

/// Torque limits of the drives, and the number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueLimits<S, const N: usize> {
    /// Greatest actuator torque or force per joint, N m or N; infinity means "no limit". Subtract the share that
    /// friction and feedback need.
    pub torque: [S; N],
    /// Number of equal steps of the motion; torques are sampled at the boundaries of the steps.
    pub steps: u32,
}

impl<S: Real, const N: usize> Motion<S, N> {
    /// The factor `k` for [`Motion::stretched`] at which some joint just reaches its torque limit at a sampled moment and
    /// none exceeds it; below 1 if the motion can be faster, 0 if no torque depends on the speed.
    ///
    /// Slowed by `k`, the motion needs the torque `tau_d / k^2 + tau_s`: `tau_s = ID(q, 0, 0)` holds the arm still, and
    /// `tau_d = ID(q, qd, qdd) - tau_s` is quadratic in the speed. So
    /// `k^2 = max (tau_d / (L - tau_s) where tau_d > 0, -tau_d / (L + tau_s) where tau_d < 0)` over moments and joints.
    /// (Hollerbach, *Dynamic Scaling of Manipulator Trajectories*, 1984.) It holds for scenes whose velocity terms are absent
    /// or live; a wrench or payload is read from `live` and stays constant.
    ///
    /// Cost: two inverse dynamics a step.
    ///
    /// # Errors
    /// A limit that is NaN or not above zero; no steps; a torque that is NaN or infinite; a position at which holding
    /// still takes the whole torque limit.
    pub fn torque_scale(
        &self,
        dynamics: &impl InverseDynamics<S, N>,
        trig: &impl Trig<S>,
        live: &Live<S, N>,
        limits: &TorqueLimits<S, N>,
    ) -> Result<S, MotionError> {
        let zero = S::zero();
        for joint in 0..N {
            if limits.torque[joint] > zero {
                continue;
            }
            return Err(MotionError::BadBound { what: "torque", joint });
        }
        let steps = match i32::try_from(limits.steps) {
            Ok(steps @ 1..) => steps,
            _ => {
                let value = f64::from(limits.steps);
                return Err(MotionError::OutOfRange {
                    what: "number of steps",
                    value,
                    wanted: "between 1 and 2^31 - 1",
                });
            }
        };
        let step = self.duration() / S::from_i32(steps);
        let mut squared = zero;
        for i in 0..=steps {
            let t = step * S::from_i32(i);
            let r = self.sample(t);
            let turn = trig.sin_cos_all(&r.q);
            let holding = dynamics.inverse_dynamics(&turn, &r.q, &[zero; N], &[zero; N], live);
            let moving = dynamics.inverse_dynamics(&turn, &r.q, &r.qd, &r.qdd, live);
            for joint in 0..N {
                let needed = squared_scale(holding[joint], moving[joint], limits.torque[joint]);
                squared = largest(squared, needed.map_err(|problem| problem.at(joint, t.to_f64()))?);
            }
        }
        Ok(squared.sqrt())
    }

    /// The same path, slowed until the torque limits hold at every sampled moment; as it is, if they hold already.
    ///
    /// Made for [`super::Timing::Fastest`] and [`Motion::fastest`]: a motion within velocity and acceleration bounds
    /// then keeps to torque limits too, and is as fast as one factor for the whole motion allows. Between the sampled
    /// moments a torque may exceed its limit by its change in half a step.
    ///
    /// # Errors
    /// As [`Motion::torque_scale`].
    pub fn scale_to_torque(
        &self,
        dynamics: &impl InverseDynamics<S, N>,
        trig: &impl Trig<S>,
        live: &Live<S, N>,
        limits: &TorqueLimits<S, N>,
    ) -> Result<Self, MotionError> {
        let factor = self.torque_scale(dynamics, trig, live, limits)?;
        if factor > S::one() {
            self.stretched(factor * S::literal(1.0 + Bounds::<S, N>::MARGIN))
        } else {
            Ok(self.clone())
        }
    }
}

/// Fault of one torque.
enum Problem {
    NotFinite,
    TooSmall { holding: f64, limit: f64 },
}

impl Problem {
    fn at(self, joint: usize, time: f64) -> MotionError {
        match self {
            Self::NotFinite => MotionError::TorqueNotFinite { joint, time },
            Self::TooSmall { holding, limit } => MotionError::TorqueTooSmall { joint, time, holding, limit },
        }
    }
}

/// The least `k^2` for one joint at one moment.
fn squared_scale<S: Real>(holding: S, moving: S, limit: S) -> Result<S, Problem> {
    if !(holding.is_finite() && moving.is_finite()) {
        return Err(Problem::NotFinite);
    }
    if holding.abs() >= limit {
        return Err(Problem::TooSmall { holding: holding.to_f64(), limit: limit.to_f64() });
    }
    let dynamic = moving - holding;
    let room = if dynamic > S::zero() { limit - holding } else { limit + holding };
    Ok(dynamic.abs() / room)
}
