//! Joint friction, as nature has it.

use super::dynamics::Arm;
use dynamics_core::JointSpec;
use nalgebra::SMatrix;

/// Viscous and Coulomb friction: `tau_f = b qd + c tanh(qd / v)`, opposed to the motion.
///
/// The hyperbolic tangent is a sign function that an explicit integrator can follow: within 1 % of the whole Coulomb
/// torque above `2.6 v`. A joint held by friction alone is not locked but creeps, at `v atanh(load / c)`: with the
/// speeds `v` used here, some hundredths of a millimetre or of a milliradian in a tenth of a second. There is no break-away torque above `c`.
///
/// `v` is 1 mrad/s (1 mm/s), or more where Runge-Kutta's fourth-order step `h` could not follow so steep a slope: its
/// stability ends at a decay rate of `2.78 / h`, and the steepest decay is `c (D^-1)_ii / v`. `v` keeps that below `0.5 / h`
/// at the start, which leaves room for the inertia to change fivefold on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFriction {
    /// Viscous coefficient `b`, N m s/rad or N s/m.
    pub viscous: f64,
    /// Coulomb torque or force `c`, N m or N.
    pub coulomb: f64,
    /// Speed scale `v` of the sign function, rad/s or m/s.
    pub sign_speed: f64,
}

/// Smallest speed scale, rad/s or m/s.
const SIGN_SPEED_MIN: f64 = 1e-3;

/// Greatest decay rate of the Coulomb term times the step.
const DECAY_PER_STEP: f64 = 0.5;

impl JointFriction {
    /// Torque opposed to the motion, N m or N.
    #[must_use]
    pub fn torque(&self, qd: f64) -> f64 {
        let sign = if self.coulomb > 0.0 { libm::tanh(qd / self.sign_speed) } else { 0.0 };
        self.viscous * qd + self.coulomb * sign
    }

    /// Friction of every joint from its `(viscous, coulomb)`, with the speed scale that the step `h` (s) allows at `q`.
    #[must_use]
    pub fn all<const N: usize>(coefficients: &[(f64, f64); N], arm: &Arm<N>, q: &[f64; N], h: f64) -> [Self; N] {
        let matrix = arm.terms(q, &[0.0; N]).mass_matrix;
        core::array::from_fn(|i| {
            let (viscous, coulomb) = coefficients[i];
            let steepest = coulomb * mobility(&matrix, i, &arm.joints[i]) * h / DECAY_PER_STEP;
            Self { viscous, coulomb, sign_speed: steepest.max(SIGN_SPEED_MIN) }
        })
    }
}

/// `(D^-1)_ii`: acceleration of joint `i` per unit of torque on it, the others free.
fn mobility<const N: usize>(matrix: &SMatrix<f64, N, N>, i: usize, joint: &JointSpec) -> f64 {
    let mut unit = [0.0; N];
    unit[i] = 1.0;
    let found = super::dynamics::solve(matrix, &unit);
    if found.pivot.iter().all(|&pivot| pivot > 0.0 && pivot.is_finite()) {
        found.qdd[i]
    } else {
        // The first step will report the singular matrix; until then the rotor alone bounds the acceleration.
        joint.rotor.reflected().recip().min(1.0)
    }
}
