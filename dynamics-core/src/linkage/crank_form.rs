//! The loop's only equation of motion, in terms of the crank's angle.

use super::plane::dot;
use super::{Coefficients, LinkageError, LinkagePosture};
use crate::scalar::Real;
use nalgebra::Vector2;

/// Equation of motion of the whole loop at the crank, at one angle `theta`:
///
/// `M = I(theta) thetadd + 1/2 I'(theta) thetad^2 + dV/dtheta`
///
/// It is eq. 12.216 with one coordinate. With the kinematic coefficients `k_i` of the links and `r_i'` of the mass centres,
///
/// ```text
/// I       = sum_i m_i r_i' . r_i' + I_i k_i^2
/// 1/2 I'  = sum_i m_i r_i' . r_i'' + I_i k_i k_i'
/// dV/dtheta = -sum_i m_i g . r_i'
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrankForm<S> {
    /// `I`, generalized inertia, kg m^2.
    pub inertia: S,
    /// `1/2 I'`, half its derivative by the crank's angle, kg m^2/rad.
    pub half_slope: S,
    /// `dV/dtheta`, moment at the crank that holds the loop at rest, N m.
    pub gravity: S,
}

impl<S: Real> CrankForm<S> {
    /// From a posture and its coefficients; `gravity` in the plane, m/s^2.
    #[must_use]
    pub fn new(posture: &LinkagePosture<S>, coefficients: &[Coefficients<S>; 3], gravity: &Vector2<S>) -> Self {
        let zero = S::zero();
        let mut form = Self { inertia: zero, half_slope: zero, gravity: zero };
        for (link, k) in posture.links.iter().zip(coefficients) {
            form.inertia += link.mass * dot(&k.centre, &k.centre) + link.inertia * k.turn * k.turn;
            form.half_slope += link.mass * dot(&k.centre, &k.centre_second) + link.inertia * k.turn * k.turn_second;
            form.gravity -= link.mass * dot(gravity, &k.centre);
        }
        form
    }

    /// Driving moment for this crank speed (rad/s) and acceleration (rad/s^2), N m: `M_0` of eq. 12.46, without the forces.
    #[must_use]
    pub fn moment(&self, speed: S, acceleration: S) -> S {
        self.inertia * acceleration + self.half_slope * speed * speed + self.gravity
    }

    /// Crank acceleration under this moment (N m), rad/s^2.
    ///
    /// # Errors
    /// [`LinkageError::NoInertia`].
    pub fn acceleration(&self, moment: S, speed: S) -> Result<S, LinkageError<S>> {
        if self.inertia > S::zero() {
            Ok((moment - self.half_slope * speed * speed - self.gravity) / self.inertia)
        } else {
            Err(LinkageError::NoInertia)
        }
    }

    /// `K = 1/2 I thetad^2`, J.
    #[must_use]
    pub fn kinetic_energy(&self, speed: S) -> S {
        S::literal(0.5) * self.inertia * speed * speed
    }
}
