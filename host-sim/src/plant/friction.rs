//! Joint friction of the simulated arm.

use super::dynamics::Arm;

/// Friction of a joint at the velocity `v`, under the actuator's torque `tau`: `offset + viscous v + asymmetry |sign(v)| + sign(v) level`,
/// opposed to the motion.
///
/// The level is the Coulomb torque `c`, which a load may raise to `c + l_c |tau|`. With a [`Breakaway`], Stribeck's rise towards rest
/// replaces it: `c + (s - c) exp(-(v / v_s)^2)`, where `s = s_0 + l |tau|`.
///
/// The sign is exact: it has no width that depends on the step. A joint that comes to rest is held there without motion, as long as the
/// rest of the arm loads it by at most the level at `v = 0`; `stiction` has the details. What holds it is between the torques of both
/// directions, `offset + asymmetry - level` and `offset + asymmetry + level`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointFriction {
    /// Viscous coefficient, N m s/rad or N s/m.
    pub viscous: f64,
    /// Coulomb torque or force `c`, N m or N: the mean of both directions.
    pub coulomb: f64,
    /// Breakaway level, if there is one.
    pub breakaway: Option<Breakaway>,
    /// Gain `l_c` of the Coulomb torque per unit of the actuator's torque.
    pub coulomb_load: f64,
    /// Half the difference of the Coulomb torques of both directions, N m or N.
    pub asymmetry: f64,
    /// Constant torque, N m or N.
    pub offset: f64,
}

/// Friction's rise towards rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Level `s_0` without load, N m or N; not below the Coulomb torque.
    pub torque: f64,
    /// Stribeck velocity `v_s`, rad/s or m/s.
    pub speed: f64,
    /// Gain `l` of the level per unit of the actuator's torque.
    pub load: f64,
}

impl JointFriction {
    /// Viscous and Coulomb friction.
    #[must_use]
    pub const fn new(viscous: f64, coulomb: f64) -> Self {
        Self { viscous, coulomb, breakaway: None, coulomb_load: 0.0, asymmetry: 0.0, offset: 0.0 }
    }

    /// True if the joint has dry friction, which can hold it at rest.
    #[must_use]
    pub fn is_dry(&self) -> bool {
        let rises = self.breakaway.is_some_and(|it| it.torque > 0.0 || it.load > 0.0);
        self.coulomb > 0.0 || self.coulomb_load > 0.0 || rises
    }

    /// True if the level depends on torque or velocity.
    pub(super) fn varies(&self) -> bool {
        self.breakaway.is_some() || self.coulomb_load != 0.0
    }

    /// Middle between the friction of both directions, N m or N: a constant torque on a joint that slides or is held.
    pub(super) fn constant(&self) -> f64 {
        self.asymmetry + self.offset
    }

    /// Torque opposed to the motion of a joint that carries no load, N m or N; at rest, the offset alone.
    #[must_use]
    pub fn torque(&self, qd: f64) -> f64 {
        self.torque_under(0.0, qd)
    }

    /// Torque opposed to the motion while the actuator gives `drive`, N m or N; at rest, the offset alone.
    #[must_use]
    pub fn torque_under(&self, drive: f64, qd: f64) -> f64 {
        let sign = if qd == 0.0 { 0.0 } else { qd.signum() };
        self.viscous * qd + self.level(drive, qd) * sign + self.asymmetry * sign * sign + self.offset
    }

    /// Dry friction of a joint that moves at this velocity while the actuator gives `drive`, N m or N; at rest, the largest that it can hold.
    #[must_use]
    #[inline]
    pub fn level(&self, drive: f64, qd: f64) -> f64 {
        #[cfg(test)]
        super::calls::count(super::calls::Effect::Friction);
        let coulomb = self.coulomb + self.coulomb_load * drive.abs();
        let Some(Breakaway { torque, speed, load }) = &self.breakaway else { return coulomb };
        #[cfg(test)]
        super::calls::count(super::calls::Effect::Breakaway);
        let rise = torque + load * drive.abs() - coulomb;
        coulomb + rise * libm::exp(-(qd / speed) * (qd / speed))
    }
}

/// Acceleration of each joint per unit of torque on it at `q`, the others free: the diagonal of the inverse inertia matrix.
#[must_use]
pub fn mobility<const N: usize>(arm: &Arm<N>, q: &[f64; N]) -> [f64; N] {
    let matrix = arm.terms(q, &[0.0; N]).mass_matrix;
    core::array::from_fn(|i| {
        let mut unit = [0.0; N];
        unit[i] = 1.0;
        let found = super::factors::solve(&matrix, &unit);
        if found.pivot.iter().all(|&pivot| pivot > 0.0 && pivot.is_finite()) {
            found.qdd[i]
        } else {
            // The first step will report the singular matrix. Until then the rotor alone bounds the acceleration.
            arm.joints[i].rotor.reflected().recip().min(1.0)
        }
    })
}
