//! Choices, and their representation in scene files.

use core::fmt;
use core::str::FromStr;
use dynamics_core::control::{Between, ControlLaw};
use dynamics_core::trig::Method;
use robot_compiler::kernel::Level;
use robot_compiler::names::{self, Named};
use robot_compiler::scene::ScalarChoice;
use serde::{Serialize, Serializer};
use toml_edit::{DocumentMut, Item, Table, value};

/// Set of terms in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

impl Named for TermSet {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("full", "Everything that the scene's model names", Self::Full),
        ("no-coriolis", "Everything but centrifugal and Coriolis terms", Self::NoCoriolis),
        (
            "diagonal",
            "Gravity as it is, inertia as the constant diagonal of the mass matrix at the start of the motion",
            Self::Diagonal,
        ),
        ("gravity", "Gravity, and feedback", Self::Gravity),
        ("none", "Feedback alone", Self::None),
    ];
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
        Self::NAMES.iter().map(|(.., terms)| *terms).find(|terms| terms.law() == law).unwrap_or(Self::Gravity)
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

/// One choice: a value on every axis. In JSON, the values have the names of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Floating-point type.
    #[serde(serialize_with = "by_name")]
    pub scalar: ScalarChoice,
    /// Method for sine and cosine.
    #[serde(serialize_with = "by_name")]
    pub trig: Method,
    /// Terms of the model.
    #[serde(serialize_with = "by_name")]
    pub terms: TermSet,
    /// True to feed friction forward, if the scene does so.
    #[serde(serialize_with = "as_switch")]
    pub friction: bool,
    /// True to include rotors, if the scene does so.
    #[serde(serialize_with = "as_switch")]
    pub rotors: bool,
    /// Evaluation schedule of the model.
    #[serde(serialize_with = "as_text")]
    pub every: Every,
    /// Level of the arm's kernel.
    #[serde(serialize_with = "by_name")]
    pub kernel: Level,
    /// Control rate, Hz.
    pub rate: f64,
}

fn by_name<T: Named, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(names::name(*value))
}

fn as_switch<S: Serializer>(is_on: &bool, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(switch(*is_on))
}

fn as_text<S: Serializer>(value: &Every, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(value)
}

const fn switch(is_on: bool) -> &'static str {
    if is_on { "on" } else { "off" }
}

impl Choice {
    /// The names of the values as cells of a table, in the order of the fields.
    #[must_use]
    pub fn cells(&self) -> [String; 8] {
        [
            names::name(self.scalar).to_owned(),
            names::name(self.trig).to_owned(),
            names::name(self.terms).to_owned(),
            switch(self.friction).to_owned(),
            switch(self.rotors).to_owned(),
            self.every.to_string(),
            names::name(self.kernel).to_owned(),
            self.rate.to_string(),
        ]
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
        for (key, choice) in [
            ("law", names::name(self.terms.law())),
            ("scalar", names::name(self.scalar)),
            ("trig", names::name(self.trig)),
            ("kernel", names::name(self.kernel)),
        ] {
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
