//! Parsing of column names.

use super::heading_words::{any, bracket, found, without, words};
use super::unit::{Kind, Unit};
use super::vocabulary::{
    ACTUAL, COMMANDED, DERIVED, FILLERS, MOTOR, OTHER, Quantity, STAMP_NANOSECONDS, STAMP_SECONDS, TIME, WORDS,
};

/// Origin of a value. Earlier variants are better for identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// Named as measured.
    Actual,
    /// Not marked as measured or commanded.
    Plain,
    /// Filtered or estimated.
    Derived,
    /// Named as commanded.
    Commanded,
}

/// Joint that a column belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Id {
    /// A joint of the robot, found by its name; counted from 0.
    Joint(usize),
    /// A number in the heading; the log may count from 0 or from 1.
    Number(u32),
    /// No joint.
    None,
}

/// Meaning of a column's name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Meaning {
    pub(super) quantity: Quantity,
    /// Word for the quantity; empty if the heading is only a joint's name.
    pub(super) word: String,
    pub(super) role: Role,
    /// True if the heading names the motor.
    pub(super) motor: bool,
    pub(super) id: Id,
    /// Prefix, such as a topic or a device.
    pub(super) group: String,
    pub(super) unit: Option<Unit>,
    /// True if the unit is a word of the name, not in brackets: `q_1_m` may mean something else.
    pub(super) loose: bool,
    /// Text in brackets that is not a known unit.
    pub(super) unknown_unit: Option<String>,
}

impl Meaning {
    fn plain(quantity: Quantity, word: String) -> Self {
        let group = String::new();
        Self {
            quantity,
            word,
            role: Role::Plain,
            motor: false,
            id: Id::None,
            group,
            unit: None,
            loose: false,
            unknown_unit: None,
        }
    }
}

/// Joint names split into words.
pub(super) struct Names {
    joints: Vec<Vec<String>>,
    /// Names without the word "joint", if more than a number remains.
    short: Vec<Vec<String>>,
}

impl Names {
    pub(super) fn new(joints: &[String]) -> Self {
        let joints: Vec<Vec<String>> = joints.iter().map(|name| words(name)).collect();
        let shorten = |name: &Vec<String>| -> Vec<String> {
            let short: Vec<String> = name.iter().filter(|word| *word != "joint").cloned().collect();
            let says = short.iter().any(|word| word.chars().any(char::is_alphabetic));
            if says { short } else { Vec::new() }
        };
        let short = joints.iter().map(shorten).collect();
        Self { joints, short }
    }

    /// Joint that a whole text names.
    pub(super) fn of(&self, text: &str) -> Option<usize> {
        let words = words(text);
        let by = |names: &[Vec<String>]| names.iter().position(|name| !name.is_empty() && *name == words);
        by(&self.joints).or_else(|| by(&self.short))
    }

    /// Joint named within words, and the remaining words.
    fn within(&self, words: &[String]) -> Option<(usize, Vec<String>)> {
        [&self.joints, &self.short].into_iter().find_map(|names| {
            let places = names.iter().enumerate().filter_map(|(k, name)| Some((k, name.len(), found(words, name)?)));
            let longest = places.max_by_key(|(_, length, _)| *length);
            longest.map(|(joint, length, begin)| (joint, without(words, begin, length)))
        })
    }

    /// Possible joints in these words, with the remaining words: by name, or by the only number.
    fn split(&self, words: &[String]) -> Vec<(Id, Vec<String>)> {
        let by_name = self.within(words).map(|(joint, left)| (Id::Joint(joint), left));
        let digits: Vec<usize> = (0..words.len()).filter(|k| words[*k].parse::<u32>().is_ok()).collect();
        let by_number = match digits.as_slice() {
            [k] => words[*k].parse().ok().map(|number| (Id::Number(number), without(words, *k, 1))),
            _ => None,
        };
        by_name.into_iter().chain(by_number).chain([(Id::None, words.to_vec())]).collect()
    }

    /// Meaning of a heading, including its unit.
    pub(super) fn meaning(&self, heading: &str) -> Option<Meaning> {
        let heading = heading.trim();
        if heading.starts_with('#') && heading[1..].parse::<u32>().is_ok() {
            return None;
        }
        if let Some((name, inner, rest)) = bracket(heading) {
            let unit = Unit::parse(inner);
            if let (Some(unit), Some(meaning)) = (unit, self.of_name(&format!("{name}{rest}"), unit)) {
                return Some(Meaning { unit: Some(unit), ..meaning });
            }
            if let Some(meaning) = self.of_name(heading, None) {
                return Some(meaning);
            }
            return self
                .of_name(&format!("{name}{rest}"), None)
                .map(|meaning| Meaning { unknown_unit: Some(inner.to_owned()), ..meaning });
        }
        self.of_name(heading, None)
            .or_else(|| self.with_unit_at_end(heading))
            .or_else(|| self.with_unit_inside(heading))
    }

    /// Parses headings such as `q1_deg`, `q1 / rad`, `time in ms`.
    fn with_unit_at_end(&self, heading: &str) -> Option<Meaning> {
        let ends = heading.char_indices().filter(|(_, c)| matches!(c, '/' | '_' | ' ' | '.' | '-'));
        let splits = ends.map(|(k, c)| (&heading[..k], &heading[k + c.len_utf8()..]));
        splits.filter(|(name, _)| !name.trim().is_empty()).find_map(|(name, end)| {
            let end = end.trim();
            let unit = Unit::parse(end.strip_prefix("in ").unwrap_or(end))?;
            let name = name.trim_end_matches([' ', '/', '_', ',']);
            let meaning = self.of_name(name.strip_suffix(" in").unwrap_or(name), Some(unit))?;
            Some(Meaning { unit: Some(unit), loose: true, ..meaning })
        })
    }

    /// Parses headings such as `q_deg_1`, `speed_rad_s_2`.
    fn with_unit_inside(&self, heading: &str) -> Option<Meaning> {
        let parts: Vec<&str> = heading.split(['_', ' ']).collect();
        let spans = (1..parts.len()).flat_map(|begin| [2, 1].map(|length| (begin, begin + length)));
        spans.filter(|(_, end)| *end < parts.len()).find_map(|(begin, end)| {
            let unit = Unit::parse(&parts[begin..end].join("_"))?;
            let name = [&parts[..begin], &parts[end..]].concat().join("_");
            let meaning = self.of_name(&name, Some(unit))?;
            Some(Meaning { unit: Some(unit), loose: true, ..meaning })
        })
    }

    /// Meaning of a name without its unit. The last parts of a path contain quantity and joint.
    fn of_name(&self, name: &str, unit: Option<Unit>) -> Option<Meaning> {
        let parts: Vec<&str> = name.split(['/', '.', ':']).filter(|part| !part.trim().is_empty()).collect();
        // The longest ending that names a stamp is used, so that seconds and nanoseconds share a group.
        let stamp = (1..=parts.len()).rev().find_map(|count| {
            let (group, core) = parts.split_at(parts.len() - count);
            let text = words(&core.join(" ")).join(" ");
            let known = [(Quantity::StampSeconds, STAMP_SECONDS), (Quantity::StampNanoseconds, STAMP_NANOSECONDS)];
            let quantity =
                known.iter().find(|(_, known)| known.contains(&text.as_str())).map(|(quantity, _)| *quantity)?;
            Some(Meaning { group: group.join("/"), ..Meaning::plain(quantity, text) })
        });
        if stamp.is_some() {
            return stamp;
        }
        (1..=parts.len()).find_map(|count| {
            let (group, core) = parts.split_at(parts.len() - count);
            let group = group.join("/");
            let above = words(&group);
            if any(&above, OTHER) {
                return None;
            }
            let mut meaning = self.of_core(&words(&core.join(" ")), unit)?;
            if meaning.role == Role::Plain {
                meaning.role = if any(&above, COMMANDED) {
                    Role::Commanded
                } else if any(&above, ACTUAL) {
                    Role::Actual
                } else {
                    Role::Plain
                };
            }
            // A joint quantity needs a joint, whose name may be in the part before.
            let whole = meaning.id != Id::None
                || !matches!(
                    meaning.quantity,
                    Quantity::Position | Quantity::Velocity | Quantity::Torque | Quantity::Current | Quantity::Name
                );
            whole.then_some(Meaning { group, ..meaning })
        })
    }

    fn of_core(&self, core: &[String], unit: Option<Unit>) -> Option<Meaning> {
        let text = core.join(" ");
        for (quantity, known) in [(Quantity::Time, TIME), (Quantity::Tick, &["tick", "ticks"])] {
            if known.contains(&text.as_str()) {
                return Some(Meaning::plain(quantity, text));
            }
        }
        self.split(core).into_iter().find_map(|(id, left)| {
            let named = matches!(id, Id::Joint(_)) || any(&left, &["joint", "joints", "jnt", "j", "axis"]);
            let role = if any(&left, COMMANDED) {
                Role::Commanded
            } else if any(&left, DERIVED) {
                Role::Derived
            } else if any(&left, ACTUAL) {
                Role::Actual
            } else {
                Role::Plain
            };
            let motor = any(&left, MOTOR);
            let says = |word: &&String| {
                let word = word.as_str();
                ![ACTUAL, DERIVED, COMMANDED, FILLERS, MOTOR].iter().any(|list| list.contains(&word))
            };
            let rest: Vec<&str> = left.iter().filter(says).map(String::as_str).collect();
            let known =
                |text: &str| WORDS.iter().find(|(_, words)| words.contains(&text)).map(|(quantity, _)| *quantity);
            let (quantity, word, role) = match rest.as_slice() {
                // `sensed_1` is a measured position.
                [] if named || left.iter().any(|word| word == "sensed") => (of_unit(unit), String::new(), role),
                // In `current position`, "current" is an adjective.
                ["current", other] if known(other).is_some() => (known(other)?, (*other).to_owned(), Role::Actual),
                rest => {
                    let word = rest.join(" ");
                    (known(&word)?, word, role)
                }
            };
            // The d-axis current produces no torque.
            let other = quantity == Quantity::Current && left.iter().any(|word| word == "d");
            (!other).then(|| Meaning { role, motor, id, ..Meaning::plain(quantity, word) })
        })
    }
}

/// Quantity of a column whose heading is only a joint's name, from its unit.
fn of_unit(unit: Option<Unit>) -> Quantity {
    match unit.map(|unit| unit.kind) {
        Some(Kind::AngularSpeed | Kind::Speed) => Quantity::Velocity,
        Some(Kind::Torque | Kind::Force) => Quantity::Torque,
        Some(Kind::Current) => Quantity::Current,
        _ => Quantity::Position,
    }
}

#[cfg(test)]
mod tests;
