//! Joint friction of the simulated arm.

use super::dynamics::Arm;
use super::tanh::{ONE_FROM, tanh, tanh_of_vectors};
use dynamics_core::JointSpec;
use nalgebra::SMatrix;
pub use robot_compiler::{Breakaway, JointFriction as FrictionLaw};

/// Viscous and Coulomb friction: `tau_f = b qd + c tanh(qd / v)`, opposed to the motion.
///
/// The hyperbolic tangent is a sign function that an explicit integrator can follow: above `2.6 v` it is within 1 % of
/// the whole Coulomb torque. A joint held by friction alone is not locked but creeps, at `v atanh(load / c)`: with the
/// speeds `v` used here, some hundredths of a millimetre or of a milliradian in a tenth of a second.
///
/// With a [`Breakaway`], Stribeck's rise towards rest replaces `c`: `c + (s - c) exp(-(qd / v_s)^2)`, where
/// `s = s_0 + l |tau|` is the breakaway level under the actuator's torque `tau`.
///
/// A load may raise the Coulomb torque too, `c + l_c |tau|`; an asymmetry `a` adds `a tanh(qd / v)^2`, and an offset a constant.
///
/// `v` is 1 mrad/s (1 mm/s), or more if Runge-Kutta's fourth-order step `h` cannot follow so steep a slope: its
/// stability ends at a decay rate of `2.78 / h`, and the steepest decay is `c (D^-1)_ii / v`. `v` keeps this decay
/// below `0.5 / h` at the start. This leaves room for the inertia to change fivefold on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFriction {
    /// Viscous coefficient `b`, N m s/rad or N s/m.
    pub viscous: f64,
    /// Coulomb torque or force `c`, N m or N.
    pub coulomb: f64,
    /// Speed scale `v` of the sign function, rad/s or m/s. Where the breakaway's rise begins to fall, the sign function is not yet complete:
    /// friction reaches 83 % of the excess over Coulomb if the Stribeck velocity is `5 v`, and 93 % if it is `10 v`.
    pub sign_speed: f64,
    /// Breakaway level, if it is more than `c`.
    pub breakaway: Option<Breakaway>,
    /// Gain `l_c` of the Coulomb torque per unit of the actuator's torque.
    pub coulomb_load: f64,
    /// Half the difference of the Coulomb torques of both directions, N m or N.
    pub asymmetry: f64,
    /// Constant torque, N m or N.
    pub offset: f64,
}

/// Smallest speed scale, rad/s or m/s.
const SIGN_SPEED_MIN: f64 = 1e-3;

/// Greatest decay rate of the Coulomb term times the step.
const DECAY_PER_STEP: f64 = 0.5;

impl JointFriction {
    /// Torque opposed to the motion of a joint that carries no load, N m or N.
    #[must_use]
    pub fn torque(&self, qd: f64) -> f64 {
        self.torque_under(0.0, qd)
    }

    /// Torque opposed to the motion while the actuator gives `drive`, N m or N.
    #[must_use]
    #[inline]
    pub fn torque_under(&self, drive: f64, qd: f64) -> f64 {
        self.torque_with(sign(qd / self.sign_speed), drive, qd)
    }

    /// As [`JointFriction::torque_under`], with the sign of the velocity at hand.
    #[inline]
    fn torque_with(&self, sign: f64, drive: f64, qd: f64) -> f64 {
        #[cfg(test)]
        super::calls::count(super::calls::Effect::Friction);
        let coulomb = self.coulomb + self.coulomb_load * drive.abs();
        let level = match &self.breakaway {
            None => coulomb,
            Some(Breakaway { torque, speed, load }) => {
                #[cfg(test)]
                super::calls::count(super::calls::Effect::Breakaway);
                let rise = torque + load * drive.abs() - coulomb;
                coulomb + rise * libm::exp(-(qd / speed) * (qd / speed))
            }
        };
        let even = self.viscous * qd + level * if level > 0.0 { sign } else { 0.0 };
        if self.asymmetry == 0.0 && self.offset == 0.0 {
            even
        } else {
            even + self.asymmetry * sign * sign + self.offset
        }
    }

    /// Whether viscous and Coulomb friction are all.
    pub(super) fn is_plain(&self) -> bool {
        self.breakaway.is_none() && [self.coulomb_load, self.asymmetry, self.offset].iter().all(|term| *term == 0.0)
    }

    /// Friction of every joint from its `(viscous, coulomb)`, with a speed scale suited to the step `h` (s) at `q`.
    #[must_use]
    pub fn all<const N: usize>(coefficients: &[(f64, f64); N], arm: &Arm<N>, q: &[f64; N], h: f64) -> [Self; N] {
        let laws = coefficients.map(|(viscous, coulomb)| FrictionLaw { viscous, coulomb, ..FrictionLaw::default() });
        Self::of_laws(&laws, arm, q, h)
    }

    /// As [`JointFriction::all`], with breakaway.
    #[must_use]
    pub fn of_laws<const N: usize>(laws: &[FrictionLaw; N], arm: &Arm<N>, q: &[f64; N], h: f64) -> [Self; N] {
        let matrix = arm.terms(q, &[0.0; N]).mass_matrix;
        Self::moving(laws, arm, h, |i| mobility(&matrix, i, &arm.joints[i]))
    }

    /// As [`JointFriction::of_laws`], for joints with the friction on their rotors alone.
    #[must_use]
    pub fn on_motors<const N: usize>(laws: &[FrictionLaw; N], arm: &Arm<N>, h: f64) -> [Self; N] {
        Self::moving(laws, arm, h, |i| arm.joints[i].rotor.reflected().recip())
    }

    /// Friction of every joint from its law; `mobility` is the joint's acceleration per unit of torque.
    fn moving<const N: usize>(
        laws: &[FrictionLaw; N],
        arm: &Arm<N>,
        h: f64,
        mobility: impl Fn(usize) -> f64,
    ) -> [Self; N] {
        core::array::from_fn(|i| {
            let FrictionLaw { viscous, coulomb, breakaway, coulomb_load, asymmetry, offset } = laws[i];
            let limit = arm.joints[i].limits.torque;
            let loaded = |level: f64, load: f64| level + if limit.is_finite() { load * limit } else { 0.0 };
            let most =
                breakaway.map_or(loaded(coulomb, coulomb_load), |Breakaway { torque, load, .. }| loaded(torque, load));
            let steepest = (most + asymmetry.abs()) * mobility(i) * h / DECAY_PER_STEP;
            let sign_speed = steepest.max(SIGN_SPEED_MIN);
            Self { viscous, coulomb, sign_speed, breakaway, coulomb_load, asymmetry, offset }
        })
    }
}

/// Take friction at these velocities off the torques of the actuators.
pub(super) fn oppose<const N: usize>(friction: &[JointFriction; N], qd: &[f64; N], torque: &mut [f64; N]) {
    let ratio: [f64; N] = core::array::from_fn(|i| qd[i] / friction[i].sign_speed);
    let fast = ratio.iter().all(|ratio| ratio.abs() > ONE_FROM);
    let signs = if fast { ratio.map(|ratio| 1.0_f64.copysign(ratio)) } else { tanh_of_vectors(&ratio) };
    for i in 0..N {
        torque[i] -= friction[i].torque_with(signs[i], torque[i], qd[i]);
    }
}

/// The hyperbolic tangent, without computing where it is one to the last bit, as it is at most speeds.
#[inline]
fn sign(x: f64) -> f64 {
    if x.abs() > ONE_FROM { 1.0_f64.copysign(x) } else { tanh(&[x])[0] }
}

/// `(D^-1)_ii`: acceleration of joint `i` per unit of torque on it, the others free.
fn mobility<const N: usize>(matrix: &SMatrix<f64, N, N>, i: usize, joint: &JointSpec) -> f64 {
    let mut unit = [0.0; N];
    unit[i] = 1.0;
    let found = super::dynamics::solve(matrix, &unit);
    if found.pivot.iter().all(|&pivot| pivot > 0.0 && pivot.is_finite()) {
        found.qdd[i]
    } else {
        // The first step will report the singular matrix. Until then the rotor alone bounds the acceleration.
        joint.rotor.reflected().recip().min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::sign;

    #[test]
    fn the_sign_has_the_bits_of_the_hyperbolic_tangent_everywhere() {
        let near = [20.499_999, 20.5, 20.500_001, 21.9, 22.1, 1e300, f64::INFINITY, 0.0, 1e-310, 0.3, 19.2];
        let spaced = (0..40_000).map(|k| f64::from(k) * 1e-3);
        for x in near.into_iter().chain(spaced).flat_map(|x| [x, -x]) {
            assert_eq!(sign(x).to_bits(), libm::tanh(x).to_bits(), "{x}");
        }
        assert!(sign(f64::NAN).is_nan());
    }
}
