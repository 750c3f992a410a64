//! Choices, and their representation in scene files.

use clap::ValueEnum;
use core::fmt;
use core::str::FromStr;
use dynamics_core::control::{Between, ControlLaw};
use dynamics_core::trig::Method;
use robot_compiler::kernel::Level;
use robot_compiler::names;
use robot_compiler::scene::ScalarChoice;
use serde::Serialize;
use toml_edit::{DocumentMut, Item, Table, value};

/// Set of terms in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum TermSet {
    /// Everything that the scene's model names.
    Full,
    /// Everything but centrifugal and Coriolis terms.
    NoCoriolis,
    /// Gravity as it is, inertia as the constant diagonal of the mass matrix at the start of the motion.
    Diagonal,
    /// Gravity, and feedback.
    Gravity,
    /// Feedback alone.
    None,
}

impl TermSet {
    /// Control law that uses exactly these terms.
    pub(super) const fn law(self) -> ControlLaw {
        match self {
            Self::Full | Self::NoCoriolis => ControlLaw::ComputedTorque,
            Self::Diagonal => ControlLaw::DiagonalInertia,
            Self::Gravity => ControlLaw::PdGravity,
            Self::None => ControlLaw::Pd,
        }
    }

    /// The largest set of terms for a law; [`TermSet::Gravity`] for a law without a set.
    pub(super) fn of(law: ControlLaw) -> Self {
        Self::value_variants().iter().copied().find(|terms| terms.law() == law).unwrap_or(Self::Gravity)
    }
}

/// Evaluation schedule of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Every {
    /// Number of ticks between evaluations.
    pub ticks: u32,
    /// Torque between two evaluations.
    pub between: Between,
}

impl Every {
    /// Evaluation in every tick.
    pub const TICK: Self = Self { ticks: 1, between: Between::Hold };
}

impl FromStr for Every {
    type Err = String;

    /// Parse `1`, `4:hold`, `4:extrapolate`; `4` means `4:hold`.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("{text}: expected ticks, 1 to 1000, such as 1, 4:hold or 4:extrapolate");
        let (ticks, between) = text.split_once(':').unwrap_or((text, "hold"));
        let ticks: u32 = ticks.parse().ok().filter(|ticks| (1..=1000).contains(ticks)).ok_or_else(expected)?;
        let between = names::named(between).map_err(|_| expected())?;
        Ok(if ticks == 1 { Self::TICK } else { Self { ticks, between } })
    }
}

impl fmt::Display for Every {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.ticks {
            1 => f.write_str("1"),
            ticks => write!(f, "{ticks}:{}", names::name(self.between)),
        }
    }
}

/// One choice: a value on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Floating-point type.
    pub scalar: ScalarChoice,
    /// Method for sine and cosine.
    pub trig: Method,
    /// Terms of the model.
    pub terms: TermSet,
    /// True to feed friction forward, if the scene does so.
    pub friction: bool,
    /// True to include rotors, if the scene does so.
    pub rotors: bool,
    /// Evaluation schedule of the model.
    pub every: Every,
    /// Level of the arm's kernel.
    pub kernel: Level,
    /// Control rate, Hz.
    pub rate: f64,
}

/// Name of a value on the command line.
pub(crate) fn name(of: impl ValueEnum) -> String {
    of.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// A choice with the names of the command line, for tables and JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Named {
    /// Floating-point type.
    pub scalar: String,
    /// Method for sine and cosine.
    pub trig: String,
    /// Terms of the model.
    pub terms: String,
    /// `on` or `off`.
    pub friction: &'static str,
    /// `on` or `off`.
    pub rotors: &'static str,
    /// Evaluation schedule of the model.
    pub every: String,
    /// Level of the arm's kernel.
    pub kernel: String,
    /// Control rate, Hz.
    pub rate: f64,
}

impl Named {
    /// The names as cells of a table, in the order of the fields.
    pub(super) fn cells(&self) -> [String; 8] {
        [
            self.scalar.clone(),
            self.trig.clone(),
            self.terms.clone(),
            self.friction.to_owned(),
            self.rotors.to_owned(),
            self.every.clone(),
            self.kernel.clone(),
            self.rate.to_string(),
        ]
    }
}

impl Choice {
    /// The choice with names instead of values.
    #[must_use]
    pub fn named(&self) -> Named {
        let switch = |on: bool| if on { "on" } else { "off" };
        Named {
            scalar: names::name(self.scalar).to_owned(),
            trig: names::name(self.trig).to_owned(),
            terms: name(self.terms),
            friction: switch(self.friction),
            rotors: switch(self.rotors),
            every: self.every.to_string(),
            kernel: self.kernel.name().to_owned(),
            rate: self.rate,
        }
    }

    /// The choice with every ineffective axis at its simplest value: without model terms, evaluation settings have no effect.
    #[must_use]
    pub fn plain(self) -> Self {
        match self.terms {
            TermSet::None => Self { trig: Method::Polynomial, every: Every::TICK, kernel: Level::Exact, ..self },
            _ => self,
        }
    }

    /// Writes the choice into a scene file with the rate `rate` (Hz).
    pub(crate) fn write(&self, scene: &mut DocumentMut, rate: f64) {
        let named = self.named();
        let law = names::name(self.terms.law());
        for (key, choice) in [("law", law), ("scalar", &named.scalar), ("trig", &named.trig), ("kernel", &named.kernel)]
        {
            put(scene, "control", key, value(choice));
        }
        #[allow(clippy::float_cmp, reason = "the very number of the file stays as it was written")]
        if self.rate != rate {
            put(scene, "control", "rate", value(self.rate));
            // The step was a divisor of the old period; the default divides every period.
            remove(scene, "plant", "step");
        }
        remove(scene, "control", "model_every");
        remove(scene, "control", "model_between");
        if self.every != Every::TICK {
            put(scene, "control", "model_every", value(i64::from(self.every.ticks)));
            put(scene, "control", "model_between", value(names::name(self.every.between)));
        }
        let absent =
            [(self.terms == TermSet::NoCoriolis, "coriolis"), (!self.friction, "friction"), (!self.rotors, "rotor")];
        for (_, key) in absent.into_iter().filter(|(is_absent, _)| *is_absent) {
            put(scene, "model", key, value("absent"));
        }
    }
}

/// Sets a key in a table of the file, and creates the table if it is missing. A comment after the old value stays.
pub(crate) fn put(scene: &mut DocumentMut, table: &str, key: &str, item: Item) {
    let table = scene.entry(table).or_insert_with(|| Item::Table(Table::new()));
    let Some(table) = table.as_table_like_mut() else { return };
    match (table.get_mut(key).and_then(Item::as_value_mut), item) {
        (Some(old), Item::Value(mut new)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        (_, item) => {
            table.insert(key, item);
        }
    }
}

/// Removes a key from a table of the file.
pub(crate) fn remove(scene: &mut DocumentMut, table: &str, key: &str) {
    if let Some(table) = scene.get_mut(table).and_then(Item::as_table_like_mut) {
        table.remove(key);
    }
}
