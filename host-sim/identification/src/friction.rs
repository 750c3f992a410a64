//! Friction laws that are linear in their coefficients.
//!
//! `tau_f = o + b qd + s (c + d |load| + e sqrt|qd| + (g + h |load|) exp(-(qd / v_s)^2)) + a s^2`, where `s` is the direction of motion. A robot file
//! knows all terms except the root ([`JointLaw`]); literature: [`dynamics_core::control::FrictionTerms`].
//!
//! The sign of a noisy velocity near zero carries no information, so the direction follows the position: friction has reversed only after the joint
//! has moved back by `2 w`. `s` is the state of an element that sticks until it is stretched by `w`: `s' = clamp(s + dq / w, -1, 1)` (the
//! elasto-plastic element of Dahl and Prandtl in its simplest form). A joint at rest thus keeps the friction with which it came to rest, as a real
//! joint does.

/// Rule for the direction of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// Elasto-plastic element; its width `w` in rad or m.
    Hysteresis(f64),
    /// `tanh(qd / v)`, with `v` in rad/s or m/s.
    Smooth(f64),
}

/// A term of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// `1`, N m: a constant torque error.
    Offset,
    /// `qd`, N m s/rad.
    Viscous,
    /// `s`, N m.
    Coulomb,
    /// `s |load|`, dimensionless: gears whose friction grows with the load.
    Load,
    /// `s sqrt|qd|`, N m sqrt(s/rad).
    Root,
    /// `s exp(-(qd / v_s)^2)`, N m, with `v_s` in rad/s: Stribeck's rise towards rest.
    Stribeck(f64),
    /// `s |load| exp(-(qd / v_s)^2)`, dimensionless: a Stribeck rise that grows with the load.
    StribeckLoad(f64),
    /// `s^2`, N m: Coulomb torques that differ between the two directions.
    Asymmetric,
    /// 0: replaces a term, to measure the loss without it.
    Nothing,
}

impl Term {
    /// Name in reports.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Offset => "offset".to_owned(),
            Self::Viscous => "viscous".to_owned(),
            Self::Coulomb => "coulomb".to_owned(),
            Self::Load => "load".to_owned(),
            Self::Root => "root".to_owned(),
            Self::Stribeck(speed) => format!("stribeck {speed:.3}"),
            Self::StribeckLoad(speed) => format!("stribeck load {speed:.3}"),
            Self::Asymmetric => "asymmetric".to_owned(),
            Self::Nothing => "nothing".to_owned(),
        }
    }

    /// The function that the coefficient multiplies.
    #[must_use]
    pub fn value(self, s: f64, qd: f64, load: f64) -> f64 {
        match self {
            Self::Offset => 1.0,
            Self::Viscous => qd,
            Self::Coulomb => s,
            Self::Load => s * load.abs(),
            Self::Root => s * qd.abs().sqrt(),
            Self::Stribeck(speed) => s * bell(qd / speed),
            Self::StribeckLoad(speed) => s * load.abs() * bell(qd / speed),
            Self::Asymmetric => s * s,
            Self::Nothing => 0.0,
        }
    }

    /// True if the function depends on the load.
    #[must_use]
    pub const fn uses_load(self) -> bool {
        matches!(self, Self::Load | Self::StribeckLoad(_))
    }
}

fn bell(x: f64) -> f64 {
    (-x * x).exp()
}

/// Friction of one joint with the terms that a robot file knows. A term that is zero is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointLaw {
    /// Viscous friction, N m s/rad or N s/m.
    pub viscous: f64,
    /// Coulomb friction, N m or N.
    pub coulomb: f64,
    /// Growth of the Coulomb torque per unit of load.
    pub coulomb_load: f64,
    /// Rise from Coulomb friction to breakaway, N m or N, and its growth per unit of load.
    pub rise: (f64, f64),
    /// Stribeck velocity, rad/s or m/s; 0 without a rise.
    pub stribeck_speed: f64,
    /// Half the difference between the Coulomb torques of the two directions, N m or N.
    pub asymmetry: f64,
    /// Constant torque, N m or N.
    pub offset: f64,
}

/// Friction law of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionLaw {
    /// Rule for the direction.
    pub direction: Direction,
    /// Its terms.
    pub terms: Vec<Term>,
}

impl FrictionLaw {
    /// A law of offset, viscous and Coulomb friction, and the terms in `more`.
    #[must_use]
    pub fn with(direction: Direction, more: &[Term]) -> Self {
        let terms = [Term::Offset, Term::Viscous, Term::Coulomb].into_iter().chain(more.iter().copied()).collect();
        Self { direction, terms }
    }

    /// The same law without an offset. The number of terms stays the same.
    #[must_use]
    pub fn without_offset(&self) -> Self {
        let of = |term: &Term| if *term == Term::Offset { Term::Nothing } else { *term };
        Self { direction: self.direction, terms: self.terms.iter().map(of).collect() }
    }

    /// Coefficient of the first term that `of` accepts; 0 if there is none.
    fn coefficient(&self, coefficients: &[f64], of: impl Fn(Term) -> bool) -> f64 {
        self.terms.iter().zip(coefficients).find(|(term, _)| of(**term)).map_or(0.0, |(_, c)| *c)
    }

    /// Stribeck velocity, rad/s or m/s, if the law has a rise.
    #[must_use]
    pub fn stribeck_speed(&self) -> Option<f64> {
        self.terms.iter().find_map(|term| if let Term::Stribeck(speed) = term { Some(*speed) } else { None })
    }

    /// The same law in the terms of a robot file. `None` if no robot file can express it: a root term, a rise below zero, a Coulomb torque that the
    /// asymmetry makes negative, or a growth outside `0..=0.5`.
    #[must_use]
    pub fn by_joint(&self, coefficients: &[f64]) -> Option<JointLaw> {
        let of = |wanted: fn(Term) -> bool| self.coefficient(coefficients, wanted);
        let law = JointLaw {
            viscous: of(|term| term == Term::Viscous).max(0.0),
            coulomb: of(|term| term == Term::Coulomb),
            coulomb_load: of(|term| term == Term::Load),
            rise: (of(|term| matches!(term, Term::Stribeck(_))), of(|term| matches!(term, Term::StribeckLoad(_)))),
            stribeck_speed: self.stribeck_speed().unwrap_or(0.0),
            asymmetry: of(|term| term == Term::Asymmetric),
            offset: of(|term| term == Term::Offset),
        };
        let share = 0.0..=0.5;
        let fits = !self.terms.contains(&Term::Root)
            && law.coulomb >= law.asymmetry.abs()
            && law.rise.0 >= 0.0
            && share.contains(&law.coulomb_load)
            && share.contains(&(law.coulomb_load + law.rise.1));
        fits.then_some(law)
    }

    /// Functions of all terms along a motion, unfiltered.
    ///
    /// | name | quantity | unit |
    /// |---|---|---|
    /// | `q`, `qd` | position and velocity of the joint, evenly in time | rad, m; per s |
    /// | `load` | torque of the bodies at this joint | N m, N |
    #[must_use]
    pub fn columns(&self, q: &[f64], qd: &[f64], load: &[f64]) -> Vec<Vec<f64>> {
        let s = self.direction.along(q, qd);
        let column = |term: &Term| (0..q.len()).map(|k| term.value(s[k], qd[k], load[k])).collect();
        self.terms.iter().map(column).collect()
    }
}

impl Direction {
    /// Direction at every sample, from -1 to 1. Before the first motion it is unknown, and 0.
    #[must_use]
    pub fn along(self, q: &[f64], qd: &[f64]) -> Vec<f64> {
        match self {
            Self::Smooth(speed) => qd.iter().map(|v| (v / speed).tanh()).collect(),
            Self::Hysteresis(width) => {
                let (mut s, mut before) = (0.0_f64, q.first().copied().unwrap_or(0.0));
                q.iter()
                    .map(|&q| {
                        s = (s + (q - before) / width).clamp(-1.0, 1.0);
                        before = q;
                        s
                    })
                    .collect()
            }
        }
    }

    /// Description for reports.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Hysteresis(width) => format!("turns over within {width:.1e} of way"),
            Self::Smooth(speed) => format!("tanh(qd / {speed:.1e})"),
        }
    }
}
