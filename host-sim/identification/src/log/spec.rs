//! Columns that the user names.

use super::grid::Problem;
use super::heading_words::{bracket, words};
use super::unit::Unit;

/// Columns of a log by name, as `--columns` gives them: `q=pos_{},tau=effort_{},t=stamp`.
///
/// Keys are `t`, `q`, `qd`, `tau` and `i` (currents). A key may have a unit: `tau[mNm]=..`. A key of joints has one name for each joint, base first,
/// or one pattern. In a pattern `{}` is a joint's number, from 0 or from 1, or its name. `#3` is the third column, `#2-#7` the second to the seventh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColumnNames(Vec<KeyColumns>);

/// One key with its columns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct KeyColumns {
    pub(super) key: Key,
    pub(super) unit: Option<Unit>,
    pub(super) names: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    Time,
    Position,
    Velocity,
    Torque,
    Current,
}

const KEYS: [(&str, Key); 5] =
    [("t", Key::Time), ("q", Key::Position), ("qd", Key::Velocity), ("tau", Key::Torque), ("i", Key::Current)];

impl ColumnNames {
    /// Reads `KEY=NAME,NAME,..,KEY=..`.
    ///
    /// # Errors
    /// A description of: an unknown key, a key given twice, an unknown unit, a key without names, or both torques and currents.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut all: Vec<KeyColumns> = Vec::new();
        for part in text.split(',') {
            let part = part.trim();
            let Some((key, name)) = part.split_once('=') else {
                let last =
                    all.last_mut().ok_or_else(|| format!("{part:?} has no key; expected t=, q=, qd=, tau= or i="))?;
                last.names.push(part.to_owned());
                continue;
            };
            let (word, unit) = match key.trim().split_once('[') {
                Some((word, unit)) => (word.trim(), Some(unit.trim_end_matches(']'))),
                None => (key.trim(), None),
            };
            let known = KEYS.iter().find(|(known, _)| *known == word).map(|(_, key)| *key);
            let key = known.ok_or_else(|| format!("{word:?} is no key; expected t, q, qd, tau or i"))?;
            if all.iter().any(|given| given.key == key) {
                return Err(format!("the key {word:?} twice"));
            }
            let parsed = unit.map(|unit| Unit::parse(unit).ok_or_else(|| format!("{unit:?} is no unit that is known")));
            all.push(KeyColumns { key, unit: parsed.transpose()?, names: vec![name.trim().to_owned()] });
        }
        if let Some(empty) = all.iter().find(|given| given.names.iter().any(String::is_empty)) {
            return Err(format!("{:?} has an empty name", empty.key));
        }
        if [Key::Torque, Key::Current].iter().all(|key| all.iter().any(|given| given.key == *key)) {
            return Err("tau and i both; expected torques or currents".to_owned());
        }
        Ok(Self(all))
    }

    pub(super) fn given(&self, key: Key) -> Option<&KeyColumns> {
        self.0.iter().find(|given| given.key == key)
    }
}

impl KeyColumns {
    /// Indices of the columns: one per joint of `joints`, or one for time.
    ///
    /// # Errors
    /// A name that no column has, or a number of columns that is not the number of joints.
    pub(super) fn places(&self, head: &[String], joints: &[String]) -> Result<Vec<usize>, Problem> {
        let count = if self.key == Key::Time { 1 } else { joints.len() };
        let key = KEYS.iter().find(|(_, key)| *key == self.key).map_or("", |(word, _)| word);
        if let [pattern] = self.names.as_slice()
            && pattern.contains("{}")
        {
            return by_pattern(pattern, head, joints)
                .map_err(|(found, expected)| (format!("--columns {key}: {found}"), expected));
        }
        let mut places = Vec::new();
        for name in &self.names {
            if let Some((first, last)) = name.split_once('-').and_then(|(a, b)| Some((index(a)?, index(b)?))) {
                places.extend(first..=last);
            } else {
                places.push(place(name, head).ok_or_else(|| {
                    (
                        format!("--columns {key}: no column {name:?} in {}", listed(head)),
                        "names of columns as the header writes them".to_owned(),
                    )
                })?);
            }
        }
        if let Some(beyond) = places.iter().find(|place| **place >= head.len()) {
            return Err((
                format!("--columns {key}: #{} of {} columns", beyond + 1, head.len()),
                "a column that is there".to_owned(),
            ));
        }
        if places.len() != count {
            let expected = if self.key == Key::Time {
                "one column".to_owned()
            } else {
                format!("{count} columns, one for each joint")
            };
            return Err((format!("--columns {key}: {} columns", places.len()), expected));
        }
        Ok(places)
    }
}

/// `#3` is column 2, counted from 0.
fn index(text: &str) -> Option<usize> {
    text.trim().strip_prefix('#')?.parse::<usize>().ok()?.checked_sub(1)
}

/// Index of the column with this name: exact, ignoring case, or without its unit.
fn place(name: &str, head: &[String]) -> Option<usize> {
    let same = |plain: fn(&str) -> String| {
        let mut found = (0..head.len()).filter(|k| plain(&head[*k]) == plain(name));
        // An ambiguous name matches no column.
        found.next().filter(|_| found.next().is_none())
    };
    let bare = |text: &str| bracket(text).map_or(text, |(name, ..)| name).trim().to_lowercase();
    same(str::to_owned).or_else(|| same(str::to_lowercase)).or_else(|| same(bare)).or_else(|| index(name))
}

fn by_pattern(pattern: &str, head: &[String], joints: &[String]) -> Result<Vec<usize>, Problem> {
    let fill = |with: &dyn Fn(usize) -> String| -> Vec<Option<usize>> {
        (0..joints.len()).map(|joint| place(&pattern.replace("{}", &with(joint)), head)).collect()
    };
    let ways = [
        fill(&|joint| joint.to_string()),
        fill(&|joint| (joint + 1).to_string()),
        fill(&|joint| format!("{joint:02}")),
        fill(&|joint| format!("{:02}", joint + 1)),
        fill(&|joint| joints[joint].clone()),
        fill(&|joint| words(&joints[joint]).into_iter().filter(|word| word != "joint").collect::<Vec<_>>().join("_")),
    ];
    // Count from 0 if a column with number 0 exists.
    if let Some(whole) = ways.iter().find(|way| way.iter().all(Option::is_some)) {
        return Ok(whole.iter().flatten().copied().collect());
    }
    let found = format!("no columns {:?}, .. and none of joints' names", pattern.replace("{}", "1"));
    Err((found, format!("a pattern of the {} joints' columns, of {}", joints.len(), listed(head))))
}

/// List of the columns for a message.
pub(super) fn listed(head: &[String]) -> String {
    const MOST: usize = 24;
    let names: Vec<&str> = head.iter().take(MOST).map(String::as_str).collect();
    let more = if head.len() > MOST { format!(" and {} more", head.len() - MOST) } else { String::new() };
    format!("the columns {}{more}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::{ColumnNames, Key};

    fn head() -> Vec<String> {
        ["stamp", "pos_0", "pos_1", "Eff 1 [Nm]", "Eff 2 [Nm]", "vel_lift", "vel_turn"].map(str::to_owned).to_vec()
    }

    fn places(text: &str, key: Key) -> Result<Vec<usize>, String> {
        let joints = ["turn".to_owned(), "lift".to_owned()];
        let given = ColumnNames::parse(text)?;
        given.given(key).unwrap().places(&head(), &joints).map_err(|(found, expected)| format!("{found}; {expected}"))
    }

    #[test]
    fn patterns_lists_and_numbers_name_columns() {
        let all = "t=stamp, q=pos_{}, tau[N m]=Eff 1 [Nm],Eff 2 [Nm], qd=vel_{}";
        assert_eq!(places(all, Key::Time), Ok(vec![0]));
        assert_eq!(places(all, Key::Position), Ok(vec![1, 2]));
        assert_eq!(places(all, Key::Torque), Ok(vec![3, 4]));
        assert_eq!(places(all, Key::Velocity), Ok(vec![6, 5]));
        assert_eq!(places("tau=eff 1,Eff 2", Key::Torque), Ok(vec![3, 4]));
        assert_eq!(places("q=#2-#3", Key::Position), Ok(vec![1, 2]));
        assert_eq!(places("q=#3,#2", Key::Position), Ok(vec![2, 1]));
    }

    #[test]
    fn what_names_no_columns_is_refused() {
        for (text, key, said) in [
            ("pos_{}", Key::Position, "no key"),
            ("x=pos_{}", Key::Position, "no key; expected t, q"),
            ("q=a,q=b", Key::Position, "twice"),
            ("q[furlong]=pos_{}", Key::Position, "no unit"),
            ("q=", Key::Position, "empty name"),
            ("tau=a,i=b", Key::Torque, "torques or currents"),
            ("q=joint_{}", Key::Position, "no columns"),
            ("q=pos_0", Key::Position, "1 columns; 2 columns"),
            ("q=pos_0,pos_7", Key::Position, "no column \"pos_7\""),
            ("tau=Eff 1,Eff 9", Key::Torque, "no column \"Eff 9\""),
            ("q=#1-#9", Key::Position, "#8 of 7"),
            ("t=pos_0,pos_1", Key::Time, "one column"),
        ] {
            let problem = places(text, key).unwrap_err();
            assert!(problem.contains(said), "{text}: {problem}");
        }
    }
}
