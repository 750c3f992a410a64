//! Meaning of a column's name.

use super::unit::{Kind, Unit};
use super::vocabulary::{
    ACTUAL, COMMANDED, DERIVED, FILLERS, MOTOR, OTHER, Quantity, STAMP_NANOSECONDS, STAMP_SECONDS, TIME, WORDS,
};

/// Who says the value: the better to identify from, the earlier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// Named as measured.
    Actual,
    /// Named neither way.
    Plain,
    /// Filtered or estimated.
    Derived,
    /// Named as commanded.
    Commanded,
}

/// Joint of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Id {
    /// A joint of the robot, from 0, by its name.
    Joint(usize),
    /// A number, from 0 or from 1.
    Number(u32),
    /// None: a column that is not of a joint.
    None,
}

/// Meaning of a column's name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Meaning {
    pub(super) quantity: Quantity,
    /// The word for the quantity; empty if the column has the joint's name only.
    pub(super) word: String,
    pub(super) role: Role,
    /// The value is said to be the motor's.
    pub(super) motor: bool,
    pub(super) id: Id,
    /// Prefix: topic, device.
    pub(super) group: String,
    pub(super) unit: Option<Unit>,
    /// The unit is a word of the name, not in brackets: `q_1_m` may mean something else.
    pub(super) loose: bool,
    /// Brackets with a word that is no unit.
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

/// Words of a name: parts of it between other characters, digits and letters, and at the humps of camel case. In lower case.
pub(super) fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last: Option<char> = None;
    for c in text.chars() {
        if c.is_alphanumeric() {
            let begins = last
                .is_none_or(|last| last.is_numeric() != c.is_numeric() || (last.is_lowercase() && c.is_uppercase()));
            if begins {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(c.to_lowercase());
            }
        }
        last = c.is_alphanumeric().then_some(c);
    }
    words
}

fn without(words: &[String], begin: usize, length: usize) -> Vec<String> {
    [&words[..begin], &words[begin + length..]].concat()
}

fn found(words: &[String], part: &[String]) -> Option<usize> {
    (!part.is_empty()).then(|| words.windows(part.len()).position(|window| window == part)).flatten()
}

fn any(words: &[String], of: &[&str]) -> bool {
    words.iter().any(|word| of.contains(&word.as_str()))
}

/// Words of the joints' names.
pub(super) struct Names {
    joints: Vec<Vec<String>>,
    /// Without the word "joint", if more than a number is left.
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

    /// The joint that a whole text names.
    pub(super) fn of(&self, text: &str) -> Option<usize> {
        let words = words(text);
        let by = |names: &[Vec<String>]| names.iter().position(|name| !name.is_empty() && *name == words);
        by(&self.joints).or_else(|| by(&self.short))
    }

    /// A joint named within words, and what is left of them.
    fn within(&self, words: &[String]) -> Option<(usize, Vec<String>)> {
        [&self.joints, &self.short].into_iter().find_map(|names| {
            let places = names.iter().enumerate().filter_map(|(k, name)| Some((k, name.len(), found(words, name)?)));
            let longest = places.max_by_key(|(_, length, _)| *length);
            longest.map(|(joint, length, begin)| (joint, without(words, begin, length)))
        })
    }

    /// The joint of these words, and what is left of them: by name, or by the only number.
    fn split(&self, words: &[String]) -> Vec<(Id, Vec<String>)> {
        let by_name = self.within(words).map(|(joint, left)| (Id::Joint(joint), left));
        let digits: Vec<usize> = (0..words.len()).filter(|k| words[*k].parse::<u32>().is_ok()).collect();
        let by_number = match digits.as_slice() {
            [k] => words[*k].parse().ok().map(|number| (Id::Number(number), without(words, *k, 1))),
            _ => None,
        };
        by_name.into_iter().chain(by_number).chain([(Id::None, words.to_vec())]).collect()
    }

    /// The meaning of a heading, and of the unit in it.
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

    /// `q1_deg`, `q1 / rad`, `time in ms`.
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

    /// `q_deg_1`, `speed_rad_s_2`.
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

    /// The meaning of a name without its unit. The last parts of a path hold quantity and joint.
    fn of_name(&self, name: &str, unit: Option<Unit>) -> Option<Meaning> {
        let parts: Vec<&str> = name.split(['/', '.', ':']).filter(|part| !part.trim().is_empty()).collect();
        // A stamp is the longest end that names one: seconds and nanoseconds are then of one group.
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
            // A quantity of joints needs a joint; its name may be in the part before.
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
                // "sensed_1" is a position that was measured.
                [] if named || left.iter().any(|word| word == "sensed") => (of_unit(unit), String::new(), role),
                // The current position: an adjective.
                ["current", other] if known(other).is_some() => (known(other)?, (*other).to_owned(), Role::Actual),
                rest => {
                    let word = rest.join(" ");
                    (known(&word)?, word, role)
                }
            };
            // The d-axis current makes no torque.
            let other = quantity == Quantity::Current && left.iter().any(|word| word == "d");
            (!other).then(|| Meaning { role, motor, id, ..Meaning::plain(quantity, word) })
        })
    }
}

/// The quantity of a column that has a joint's name only.
fn of_unit(unit: Option<Unit>) -> Quantity {
    match unit.map(|unit| unit.kind) {
        Some(Kind::AngularSpeed | Kind::Speed) => Quantity::Velocity,
        Some(Kind::Torque | Kind::Force) => Quantity::Torque,
        Some(Kind::Current) => Quantity::Current,
        _ => Quantity::Position,
    }
}

/// The last bracket that holds more than a number: what is before, in and after it.
pub(super) fn bracket(heading: &str) -> Option<(&str, &str, &str)> {
    let open = heading.rfind(['[', '(', '{'])?;
    let close = open + heading[open..].find([']', ')', '}'])?;
    // "qd / (rad/s)" and "[N m]" are units; "[0]" and "[1, 2]" are indices.
    let inner = heading[open + 1..close].trim();
    let name = heading[..open].trim_end_matches([' ', '/', '_']);
    let says = inner.chars().any(|c| !c.is_numeric() && !c.is_whitespace() && c != ',');
    (says && !name.trim().is_empty()).then_some((name, inner, &heading[close + 1..]))
}

#[cfg(test)]
mod tests;
