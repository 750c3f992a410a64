//! Friction of a joint, as robot files and simulated worlds describe it.

use dynamics_core::control::{Friction, FrictionTerms, LoadGrowth, Rise};

/// Friction of a joint, on the joint's side of the gear.
///
/// At the velocity `v` under the actuator's torque `tau`:
///
/// ```text
/// offset + viscous v + |s| asymmetry + s (C + (B - C) exp(-(v / stribeck_speed)^2)),    s the sign of v
/// C = coulomb + coulomb_load |tau|,    B = breakaway + breakaway_load |tau|
/// ```
///
/// All terms but the first two are zero or `None` if a file does not give them. Literature:
/// [`dynamics_core::control::FrictionTerms`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointFriction {
    /// Viscous coefficient, N m s/rad or N s/m.
    pub viscous: f64,
    /// Coulomb torque or force, N m or N: the mean of both directions.
    pub coulomb: f64,
    /// Growth of the Coulomb torque per unit of the actuator's torque.
    pub coulomb_load: f64,
    /// Level from which a motion starts.
    pub breakaway: Option<Breakaway>,
    /// Half the difference between the Coulomb torques of the two directions, N m or N: the positive one is `coulomb + asymmetry`.
    pub asymmetry: f64,
    /// Constant torque, N m or N: it acts at rest too.
    pub offset: f64,
}

/// Rise of friction from Coulomb's level to breakaway as the velocity vanishes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Breakaway torque or force without load, N m or N; not below Coulomb's.
    pub torque: f64,
    /// Stribeck velocity, rad/s or m/s: there the rise is down to `1/e`.
    pub speed: f64,
    /// Growth of the breakaway torque per unit of the actuator's torque.
    pub load: f64,
}

/// Terms of friction in addition to viscous and Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionPart {
    /// The rise towards rest.
    Breakaway,
    /// The growth of both levels with the load.
    Load,
    /// Different Coulomb torques in both directions.
    Asymmetry,
    /// The constant torque.
    Offset,
}

impl FrictionPart {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Breakaway, Self::Load, Self::Asymmetry, Self::Offset];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Breakaway => "breakaway",
            Self::Load => "load",
            Self::Asymmetry => "asymmetry",
            Self::Offset => "offset",
        }
    }

    /// Its keys in a joint's `friction`.
    #[must_use]
    pub const fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Breakaway => &["breakaway", "stribeck_speed", "breakaway_load"],
            Self::Load => &["coulomb_load", "breakaway_load"],
            Self::Asymmetry => &["asymmetry"],
            Self::Offset => &["offset"],
        }
    }
}

/// Greatest share of the Stribeck velocity within which the sign function of the feedforward changes. With it, feedforward reaches 99 % of the
/// rise before the rise begins to fall.
const SIGN_SHARE: f64 = 0.1;

impl JointFriction {
    /// Viscous and Coulomb friction.
    #[must_use]
    pub const fn new(viscous: f64, coulomb: f64) -> Self {
        Self { viscous, coulomb, coulomb_load: 0.0, breakaway: None, asymmetry: 0.0, offset: 0.0 }
    }

    /// True if the joint has dry friction, which can hold it at rest.
    #[must_use]
    pub fn is_dry(&self) -> bool {
        let rises = self.breakaway.is_some_and(|it| it.torque > 0.0 || it.load > 0.0);
        self.coulomb > 0.0 || self.coulomb_load > 0.0 || rises
    }

    /// Friction torque against the motion of a joint that carries no load, N m or N; at rest, the offset alone.
    #[must_use]
    pub fn torque(&self, qd: f64) -> f64 {
        self.torque_under(0.0, qd)
    }

    /// Friction torque against the motion while the actuator gives `drive`, N m or N; at rest, the offset alone.
    #[must_use]
    pub fn torque_under(&self, drive: f64, qd: f64) -> f64 {
        let sign = if qd == 0.0 { 0.0 } else { qd.signum() };
        self.viscous * qd + self.level(drive, qd) * sign + self.asymmetry * sign.abs() + self.offset
    }

    /// Dry friction at this velocity while the actuator gives `drive`, N m or N; at rest, the largest torque that it can hold.
    #[must_use]
    #[inline]
    pub fn level(&self, drive: f64, qd: f64) -> f64 {
        let coulomb = self.coulomb + self.coulomb_load * drive.abs();
        let Some(Breakaway { torque, speed, load }) = &self.breakaway else { return coulomb };
        let rise = torque + load * drive.abs() - coulomb;
        coulomb + rise * libm::exp(-(qd / speed) * (qd / speed))
    }

    /// True if the joint has terms in addition to viscous and Coulomb friction.
    #[must_use]
    pub fn has_terms(&self) -> bool {
        self.breakaway.is_some() || [self.coulomb_load, self.asymmetry, self.offset].iter().any(|part| *part != 0.0)
    }

    /// True if the joint has this term.
    #[must_use]
    pub fn has(&self, part: FrictionPart) -> bool {
        self.without(part) != *self
    }

    /// The same friction without a term.
    #[must_use]
    pub fn without(&self, part: FrictionPart) -> Self {
        match part {
            FrictionPart::Breakaway => Self { breakaway: None, ..*self },
            FrictionPart::Load => {
                let breakaway = self.breakaway.map(|breakaway| Breakaway { load: 0.0, ..breakaway });
                Self { breakaway, coulomb_load: 0.0, ..*self }
            }
            FrictionPart::Asymmetry => Self { asymmetry: 0.0, ..*self },
            FrictionPart::Offset => Self { offset: 0.0, ..*self },
        }
    }

    /// Torque that starts a motion in either direction without a load, or the Coulomb torque if that is larger, N m or N.
    #[must_use]
    pub fn starting(&self) -> f64 {
        self.breakaway.map_or(self.coulomb, |breakaway| breakaway.torque.max(self.coulomb)) + self.asymmetry.abs()
    }

    /// Viscous and Coulomb friction as the controller compensates it. Its sign function changes within the speed `smoothing` (rad/s
    /// or m/s), or within a tenth of the Stribeck velocity if that is less.
    #[must_use]
    pub fn feedforward(&self, smoothing: f64) -> Friction<f64> {
        let speed = self.breakaway.map_or(smoothing, |breakaway| smoothing.min(SIGN_SHARE * breakaway.speed));
        Friction { viscous: self.viscous, coulomb: self.coulomb, per_smoothing_speed: speed.recip() }
    }

    /// Further terms as the controller compensates them, for a joint with this torque limit (N m or N; infinite for none).
    #[must_use]
    pub fn terms(&self, torque: f64) -> FrictionTerms<f64> {
        let given = |part: f64| (part != 0.0).then_some(part);
        let rise = self.breakaway.map(|it| Rise { torque: it.torque - self.coulomb, per_speed: it.speed.recip() });
        let more = self.breakaway.map_or(0.0, |it| it.load - self.coulomb_load);
        let load = (self.coulomb_load != 0.0 || more != 0.0).then_some(LoadGrowth {
            coulomb: self.coulomb_load,
            rise: more,
            most: torque,
        });
        FrictionTerms { rise, load, asymmetry: given(self.asymmetry), offset: given(self.offset) }
    }
}
