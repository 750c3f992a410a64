//! Laws of friction, linear in their coefficients.
//!
//! `tau_f = o + b qd + s (c + d |load| + e sqrt|qd| + g exp(-|qd| / v_s)) + a |qd|`, where `s` stands for the direction.
//!
//! The sign of a velocity that is noise says nothing. So the direction follows the position: a joint that turns back by less than twice
//! `w` has not turned its friction over yet. `s` is the play of an element that sticks until it is stretched by `w`,
//! `s' = clamp(s + dq / w, -1, 1)` (Dahl's and Prandtl's elasto-plastic element in its simplest form). A joint at rest thus keeps the
//! friction with which it came to rest, which is what drives it when nothing moves.

/// How the direction of motion is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// The elasto-plastic element, its width in rad or m.
    Hysteresis(f64),
    /// `tanh(qd / v)`, with `v` in rad/s or m/s.
    Smooth(f64),
}

/// A term of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// `1`, N m: a constant error of the torque.
    Offset,
    /// `qd`, N m s/rad.
    Viscous,
    /// `s`, N m.
    Coulomb,
    /// `s |load|`, without unit: gears that rub more under load.
    Load,
    /// `s sqrt|qd|`, N m sqrt(s/rad).
    Root,
    /// `s exp(-|qd| / v_s)`, N m, with `v_s` in rad/s: Stribeck's rise towards rest.
    Stribeck(f64),
    /// `|qd|`, N m s/rad: more friction one way than the other.
    Asymmetric,
}

impl Term {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Offset => "offset".to_owned(),
            Self::Viscous => "viscous".to_owned(),
            Self::Coulomb => "coulomb".to_owned(),
            Self::Load => "load".to_owned(),
            Self::Root => "root".to_owned(),
            Self::Stribeck(speed) => format!("stribeck {speed}"),
            Self::Asymmetric => "asymmetric".to_owned(),
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
            Self::Stribeck(speed) => s * (-qd.abs() / speed).exp(),
            Self::Asymmetric => qd.abs(),
        }
    }
}

/// The law of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// How the direction is told.
    pub direction: Direction,
    /// Its terms.
    pub terms: Vec<Term>,
}

impl Law {
    /// Offset, viscous and Coulomb friction, and these terms.
    #[must_use]
    pub fn with(direction: Direction, more: &[Term]) -> Self {
        let terms = [Term::Offset, Term::Viscous, Term::Coulomb].into_iter().chain(more.iter().copied()).collect();
        Self { direction, terms }
    }

    /// The functions of every term along a motion, before any filter.
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
    /// Direction between -1 and 1 at every sample; before the first motion it is not known, and 0.
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

    /// In words.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Hysteresis(width) => format!("turns over within {width:.1e} of way"),
            Self::Smooth(speed) => format!("tanh(qd / {speed:.1e})"),
        }
    }
}
