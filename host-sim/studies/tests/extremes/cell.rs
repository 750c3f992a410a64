//! A cell: its outcome, its requirement, and its judgement.

/// Largest relative deviation from an expected number.
pub(crate) const PINNED_WITHIN: f64 = 0.02;

/// The expected numbers: `group,name,value`.
const EXPECTED: &str = include_str!("expected.csv");

/// Meaning of a cell that passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A bound from theory or from practical use holds, or the documented outcome occurred.
    Requirement,
    /// The number equals the one measured before; no requirement applies.
    Record,
}

impl Kind {
    /// Name in tables.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Requirement => "requirement",
            Self::Record => "record",
        }
    }
}

/// One extreme case with its result.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell {
    /// Group of the cell.
    pub(crate) group: &'static str,
    /// Name, unique in the group.
    pub(crate) name: String,
    /// Description of the test.
    pub(crate) done: String,
    /// Requirement or record.
    pub(crate) kind: Kind,
    /// Expected result: the number and its requirement, or the outcome in words.
    pub(crate) expected: String,
    /// Result that was found.
    pub(crate) found: String,
    /// The measured number; `None` for an outcome in words.
    pub(crate) value: Option<f64>,
    /// The number as a share of its upper bound.
    pub(crate) share: Option<f64>,
    /// The expected number from an earlier measurement, if any; long cells only have their requirement.
    pub(crate) pinned: Option<f64>,
    /// True if the outcome differs from the expected one, in either direction.
    pub(crate) moved: bool,
    /// True if the requirement holds and the outcome is the expected one.
    pub(crate) passed: bool,
    /// Reason for a failure.
    pub(crate) reason: Option<String>,
}

/// Outcome of a cell before it is judged.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// A number with its required range and unit; without a bound it is a record.
    Number { value: f64, least: f64, most: f64, unit: &'static str },
    /// A text, compared with the expected text.
    Words { found: String, expected: String },
}

impl Outcome {
    /// A number with an upper bound.
    pub(crate) fn at_most(value: f64, most: f64, unit: &'static str) -> Self {
        Self::Number { value, least: f64::NEG_INFINITY, most, unit }
    }

    /// A number with two bounds.
    pub(crate) fn between(value: f64, least: f64, most: f64, unit: &'static str) -> Self {
        Self::Number { value, least, most, unit }
    }

    /// A number without a requirement.
    pub(crate) fn record(value: f64, unit: &'static str) -> Self {
        Self::Number { value, least: f64::NEG_INFINITY, most: f64::INFINITY, unit }
    }

    /// Requirement, or record if nothing is required.
    fn kind(&self) -> Kind {
        match self {
            Self::Number { least, most, .. } if least.is_infinite() && most.is_infinite() => Kind::Record,
            Self::Number { .. } | Self::Words { .. } => Kind::Requirement,
        }
    }

    /// A text and the expected text.
    pub(crate) fn words(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Words { found: found.into(), expected: expected.into() }
    }
}

impl Cell {
    /// Verdict of a passing cell.
    pub(crate) const fn passes(&self) -> &'static str {
        match (self.kind, self.pinned) {
            (Kind::Requirement, _) => "pass",
            (Kind::Record, Some(_)) => "as before",
            (Kind::Record, None) => "noted",
        }
    }

    /// Judges an outcome; `reason` explains a requirement that cannot be met.
    pub(crate) fn new(
        group: &'static str,
        name: impl Into<String>,
        done: impl Into<String>,
        outcome: Outcome,
        reason: &str,
    ) -> Self {
        let (name, done) = (name.into(), done.into());
        let (pinned, kind) = (pinned(group, &name), outcome.kind());
        let mut share = None;
        let (expected, found, value, moved, holds) = match outcome {
            Outcome::Words { found, expected } => {
                let holds = found == expected;
                (expected, found, None, !holds, holds)
            }
            Outcome::Number { value, least, most, unit } => {
                let near = |pinned: f64| (value - pinned).abs() <= PINNED_WITHIN * pinned.abs();
                let moved = pinned.is_some_and(|pinned| !near(pinned));
                share = (most.is_finite() && least.is_infinite()).then(|| value / most);
                let holds = value >= least && value <= most;
                let required = match (least.is_finite(), most.is_finite()) {
                    (true, true) => Some(format!("in {} to {}", number(least, ""), number(most, ""))),
                    (true, false) => Some(format!("at least {}", number(least, ""))),
                    (false, true) => Some(format!("at most {}", number(most, ""))),
                    (false, false) => None,
                };
                let expected: Vec<String> = pinned.map(|x| number(x, unit)).into_iter().chain(required).collect();
                (expected.join(", "), number(value, unit), Some(value), moved, holds)
            }
        };
        let why = match (holds, moved) {
            (true, false) => None,
            (true, true) => Some("not the expected number".to_owned()),
            (false, _) => Some(reason.to_owned()),
        };
        Self {
            group,
            name,
            done,
            kind,
            expected,
            found,
            value,
            share,
            pinned,
            moved,
            passed: why.is_none(),
            reason: why,
        }
    }
}

/// Formats a number with three digits, with an exponent if it is very large or small.
pub(crate) fn number(x: f64, unit: &str) -> String {
    let size = x.abs();
    let text = if x == 0.0 {
        "0".to_owned()
    } else if (0.01..1e4).contains(&size) {
        let decimals = (2 - libm::floor(libm::log10(size)) as i32).max(0) as usize;
        format!("{x:.decimals$}")
    } else {
        format!("{x:.2e}")
    };
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

/// Expected number of a cell from the file.
fn pinned(group: &str, name: &str) -> Option<f64> {
    let mut rows = csv::ReaderBuilder::new().has_headers(true).from_reader(EXPECTED.as_bytes());
    let found = rows.records().flatten().find(|row| row.get(0) == Some(group) && row.get(1) == Some(name))?;
    found.get(2)?.parse().ok()
}
