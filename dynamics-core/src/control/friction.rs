//! Friction feedforward.

use crate::fields::record;
use crate::scalar::Real;

record! {
    /// Viscous and Coulomb friction of one joint, as the controller compensates it.
    ///
    /// `tau_f = b qd + c s(qd / v)`, with `s(x) = x (3 - x^2) / 2` on `[-1, 1]` and the sign of `x` outside: a sign function whose
    /// slope is continuous, so the torque does not chatter about rest. No division and no root: `1 / v` is stored.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Friction<S> {
        /// Viscous coefficient `b`, N m s/rad or N s/m.
        pub viscous: S,
        /// Coulomb torque or force `c`, N m or N.
        pub coulomb: S,
        /// `1 / v`, where `v` is the speed at which the whole Coulomb torque acts, s/rad or s/m.
        pub per_smoothing_speed: S,
    }
}

record! {
    /// Terms of one joint's friction in addition to [`Friction`]. If the configuration is a constant, an absent term adds no
    /// instruction.
    ///
    /// ```text
    /// tau_f = o + b qd + a s^2 + s L,    s = s(qd / v),    e = exp(-(qd / v_s)^2)
    /// L     = c + r e + (l + m e) |tau + s (c + r e)|
    /// ```
    ///
    /// `tau` is the torque of the control law. The gears are also loaded by the friction torque that is added to it. The friction model
    /// is that of Armstrong-Hélouvry, Dupont and Canudas de Wit, *A survey of models, analysis tools and compensation methods for the control of
    /// machines with friction*, Automatica 30, 1994 (Stribeck curve with the exponent 2 of Bo and Pavelescu), with levels that grow
    /// with the load as measured on industrial arms by Bittencourt and Gunnarsson, *Static friction in a robot joint*, Journal of
    /// Dynamic Systems, Measurement, and Control 134, 2012.
    ///
    /// All of it follows the velocity of the reference. A reference at rest gets the offset `o` and nothing else, so stiction that is
    /// overestimated cannot drive a resting arm. [`FrictionTerms::bound`] bounds it.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct FrictionTerms<S> {
        /// Rise of the level towards rest.
        pub rise: Option<Rise<S>>,
        /// Growth of the level with the load.
        pub load: Option<LoadGrowth<S>>,
        /// Half the difference `a` between the Coulomb torques of the two directions, N m or N: the positive one is `c + a`.
        pub asymmetry: Option<S>,
        /// Constant torque `o`, N m or N: it acts at rest too.
        pub offset: Option<S>,
    }
}

record! {
    /// Rise of the friction level from Coulomb's torque to breakaway as the velocity vanishes.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Rise<S> {
        /// Breakaway torque less Coulomb's `r`, N m or N.
        pub torque: S,
        /// `1 / v_s`, where `v_s` is the Stribeck velocity, at which `1/e` of the rise is left, s/rad or s/m.
        pub per_speed: S,
    }
}

record! {
    /// Growth of the friction level per unit of load.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct LoadGrowth<S> {
        /// Growth `l` of Coulomb's torque.
        pub coulomb: S,
        /// Growth `m` of the rise: that of the breakaway torque is `l + m`.
        pub rise: S,
        /// Greatest load that counts, N m or N: the joint's torque limit.
        pub most: S,
    }
}

impl<S: Real> Friction<S> {
    /// Torque that compensates friction at the velocity `qd`, N m or N; NaN for NaN.
    #[inline]
    pub fn torque(&self, qd: S) -> S {
        let x = (qd * self.per_smoothing_speed).saturated(S::one());
        let (once, cubed) = (S::literal(1.5) * self.coulomb, S::literal(0.5) * self.coulomb);
        self.viscous * qd + x * (once - cubed * (x * x))
    }

    /// Torque that compensates friction with these terms at the velocity `qd` under the load `tau`, N m or N. NaN if `qd` is NaN, or if `tau`
    /// is NaN and the friction grows with the load.
    ///
    /// Continuous in both, with a continuous slope in `qd` without a load. At rest it is the offset.
    #[inline]
    pub fn torque_with(&self, terms: &FrictionTerms<S>, qd: S, tau: S) -> S {
        let x = (qd * self.per_smoothing_speed).saturated(S::one());
        let sign = x * (S::literal(1.5) - S::literal(0.5) * (x * x));
        let bell = terms.rise.map(|rise| bell(qd * rise.per_speed));
        let mut level = self.coulomb;
        if let (Some(rise), Some(bell)) = (&terms.rise, bell) {
            level += rise.torque * bell;
        }
        if let Some(load) = &terms.load {
            let carried = (tau + sign * level).abs().clamp_symmetric(load.most);
            let growth = match bell {
                Some(bell) => load.coulomb + load.rise * bell,
                None => load.coulomb,
            };
            level += growth * carried;
        }
        let mut torque = self.viscous * qd + sign * level;
        if let Some(asymmetry) = terms.asymmetry {
            torque += asymmetry * (sign * sign);
        }
        if let Some(offset) = terms.offset {
            torque += offset;
        }
        torque
    }
}

impl<S: Real> FrictionTerms<S> {
    /// No term.
    pub const NONE: Self = Self { rise: None, load: None, asymmetry: None, offset: None };

    /// Upper bound of the magnitude of [`Friction::torque_with`] at speeds up to `speed`, under any load, N m or N.
    pub fn bound(&self, friction: &Friction<S>, speed: S) -> S {
        let most = |a: S, b: S| if a < b { b } else { a };
        let (rise, load) = (self.rise.map_or(S::zero(), |rise| rise.torque), self.load);
        let level = most(friction.coulomb, friction.coulomb + rise);
        let growth = load.map_or(S::zero(), |load| most(load.coulomb, load.coulomb + load.rise) * load.most);
        let constant = |part: Option<S>| part.map_or(S::zero(), S::abs);
        friction.viscous * speed.abs() + level + growth + constant(self.asymmetry) + constant(self.offset)
    }
}

/// `exp(-x^2)` to within 5.8e-4, by Taylor's cubic of `exp(-x^2 / 8)` to the eighth power: no division, and nothing to overflow. It
/// falls from 1 at 0 to 0 where the cubic has its zero, at 3.57, and stays there.
#[inline]
fn bell<S: Real>(x: S) -> S {
    // The cubic's zero.
    let far = S::literal(1.596_071_637_983_321_5);
    let y = (S::literal(0.125) * (x * x)).saturated(far);
    let root = S::one() - y * (S::one() - y * (S::literal(0.5) - S::literal(1.0 / 6.0) * y));
    let square = root * root;
    let fourth = square * square;
    fourth * fourth
}
