//! Sets of columns: one quantity of all joints.

use super::fields::is_missing;
use super::grid::{Grid, Problem};
use super::name::{Id, Meaning, Names, Role};
use super::unit::Unit;
use super::vocabulary::Quantity;
use std::collections::BTreeMap;

/// A column and its meaning.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) place: usize,
    pub(super) meaning: Meaning,
}

/// One quantity of the joints, under one naming scheme.
#[derive(Clone, Debug)]
pub(super) struct Set {
    pub(super) role: Role,
    motor: bool,
    /// True if the headings are only the joints' names.
    pub(super) bare: bool,
    /// Index of each joint's column.
    pub(super) joints: Vec<Option<usize>>,
    /// Columns that belong to no joint of the robot.
    pub(super) extra: Vec<usize>,
    /// First number, if joints have numbers.
    pub(super) base: Option<u32>,
    /// The log contains the joints' names, so the columns are in their order.
    pub(super) ordered: bool,
}

impl Set {
    fn is_whole(&self) -> bool {
        self.joints.iter().all(Option::is_some)
    }

    fn rank(&self) -> (Role, bool, bool) {
        (self.role, self.bare, self.motor)
    }

    /// Indices of the columns, base first, without missing ones.
    pub(super) fn places(&self) -> Vec<usize> {
        self.joints.iter().flatten().copied().collect()
    }
}

/// All columns of a table that have a meaning.
pub(super) struct Sets<'a> {
    pub(super) head: &'a [String],
    pub(super) columns: Vec<Column>,
    joints: usize,
    /// Joint of each number, for each group that names its joints; `None` if the robot has no such joint.
    named: BTreeMap<String, BTreeMap<u32, Option<usize>>>,
}

/// Columns picked for a quantity.
pub(super) struct Picked {
    pub(super) set: Set,
    /// Complete sets that were not chosen.
    pub(super) passed: Vec<Set>,
}

impl<'a> Sets<'a> {
    /// Determines the meaning of every column.
    ///
    /// # Errors
    /// Two columns of the same meaning; joint names in the log that the robot does not have, or that change.
    pub(super) fn new(grid: &'a Grid, joints: &[String]) -> Result<Self, Problem> {
        let names = Names::new(joints);
        let head = &grid.head;
        let columns: Vec<Column> = head
            .iter()
            .enumerate()
            .filter_map(|(place, name)| {
                let mut meaning = names.meaning(name)?;
                let row = grid.units.get(place).and_then(|unit| Unit::parse(unit.trim_matches(['[', ']', '{', '}'])));
                meaning.unit = meaning.unit.or(row);
                // A unit is more reliable than a word: `effort [A]` is a current.
                meaning.quantity = match (meaning.quantity, meaning.unit.map(|unit| unit.kind)) {
                    (Quantity::Torque, Some(super::unit::Kind::Current)) => Quantity::Current,
                    (Quantity::Current, Some(super::unit::Kind::Torque | super::unit::Kind::Force)) => Quantity::Torque,
                    (quantity, _) => quantity,
                };
                Some(Column { place, meaning })
            })
            .collect();
        for (k, column) in columns.iter().enumerate() {
            let same = columns[..k]
                .iter()
                .find(|other| other.meaning == column.meaning && other.meaning.quantity != Quantity::Time);
            if let Some(other) = same {
                let (a, b) = (&head[other.place], &head[column.place]);
                let found = if a == b {
                    format!("the column {a:?} twice")
                } else {
                    format!("two columns of one meaning, {a:?} and {b:?}")
                };
                return Err((found, "each column once, or the one to use in --columns".to_owned()));
            }
        }
        let mut sets = Self { head, columns, joints: joints.len(), named: BTreeMap::new() };
        sets.named = sets.names(grid, &names, joints)?;
        Ok(sets)
    }

    /// Joints from the names in the rows.
    fn names(
        &self,
        grid: &Grid,
        names: &Names,
        joints: &[String],
    ) -> Result<BTreeMap<String, BTreeMap<u32, Option<usize>>>, Problem> {
        let mut groups: BTreeMap<String, BTreeMap<u32, Option<usize>>> = BTreeMap::new();
        let mut said: Vec<&str> = Vec::new();
        for column in self.columns.iter().filter(|column| column.meaning.quantity == Quantity::Name) {
            let Id::Number(number) = column.meaning.id else { continue };
            let mut values = grid.rows.iter().filter_map(|(line, row)| Some((*line, row.get(column.place)?)));
            let mut values = values.by_ref().filter(|(_, name)| !is_missing(name));
            let Some((_, name)) = values.next() else { continue };
            if let Some((line, other)) = values.find(|(_, other)| *other != name) {
                let found = format!("{other:?} in {:?} of line {line}, and {name:?} before", self.head[column.place]);
                return Err((found, "joints in one order".to_owned()));
            }
            said.push(name);
            groups.entry(column.meaning.group.clone()).or_default().insert(number, names.of(name));
        }
        for numbers in groups.values() {
            for joint in 0..self.joints {
                let count = numbers.values().filter(|known| **known == Some(joint)).count();
                if count != 1 {
                    let found = format!("joints {} in the log, {count} of them {:?}", said.join(", "), joints[joint]);
                    return Err((
                        found,
                        format!("the robot's joints {}, or --columns with an order", joints.join(", ")),
                    ));
                }
            }
        }
        Ok(groups)
    }

    fn of(&self, quantity: Quantity) -> Vec<Set> {
        type Key<'k> = (Role, bool, &'k str, &'k str, bool, &'k str);
        let mut groups: BTreeMap<Key<'_>, Vec<&Column>> = BTreeMap::new();
        for column in self.columns.iter().filter(|column| column.meaning.quantity == quantity) {
            let meaning = &column.meaning;
            let by_name = matches!(meaning.id, Id::Joint(_));
            let unit = meaning.unit.map_or("", |unit| unit.name);
            let key = (meaning.role, meaning.motor, meaning.word.as_str(), meaning.group.as_str(), by_name, unit);
            groups.entry(key).or_default().push(column);
        }
        let sets: Vec<Set> = groups.values().map(|columns| self.set(columns)).collect();
        if sets.iter().any(Set::is_whole) {
            return sets;
        }
        // Joints of one quantity in several groups: one device per joint.
        let mut merged: BTreeMap<(Role, bool, bool), Vec<&Column>> = BTreeMap::new();
        for ((role, motor, _, _, by_name, _), columns) in &groups {
            merged.entry((*role, *motor, *by_name)).or_default().extend(columns);
        }
        let distinct = |columns: &&Vec<&Column>| {
            columns
                .iter()
                .enumerate()
                .all(|(k, column)| columns[..k].iter().all(|other| other.meaning.id != column.meaning.id))
        };
        let whole = merged.values().filter(distinct).map(|columns| self.set(columns)).filter(Set::is_whole);
        whole.collect::<Vec<_>>().into_iter().chain(sets).collect()
    }

    fn set(&self, columns: &[&Column]) -> Set {
        let first = &columns[0].meaning;
        let numbers = columns.iter().filter_map(|column| match column.meaning.id {
            Id::Number(number) => Some(number),
            _ => None,
        });
        let base = numbers.min().map(|least| u32::from(least > 0));
        let named = self.named.get(&first.group).filter(|_| base.is_some());
        let (mut joints, mut extra) = (vec![None; self.joints], Vec::new());
        for column in columns {
            let joint = match (column.meaning.id, named) {
                (Id::Joint(joint), _) => Some(joint),
                (Id::Number(number), Some(named)) => named.get(&number).copied().flatten(),
                (Id::Number(number), None) => Some((number - base.unwrap_or(0)) as usize),
                (Id::None, _) => None,
            };
            match joint.and_then(|joint| joints.get_mut(joint)) {
                Some(place) => *place = Some(column.place),
                None => extra.push(column.place),
            }
        }
        let base = base.filter(|_| named.is_none());
        Set {
            role: first.role,
            motor: first.motor,
            bare: first.word.is_empty() && first.role != Role::Actual,
            joints,
            extra,
            base,
            ordered: named.is_some(),
        }
    }

    /// First and last names of columns.
    pub(super) fn span(&self, places: &[usize]) -> String {
        match places {
            [] => String::new(),
            [one] => self.head[*one].clone(),
            [first, .., last] => format!("{} .. {}", self.head[*first], self.head[*last]),
        }
    }

    /// The best complete set of a quantity, or none.
    ///
    /// # Errors
    /// Two sets of the same rank.
    pub(super) fn pick(&self, quantity: Quantity, key: &str) -> Result<Option<Picked>, Problem> {
        let mut whole: Vec<Set> = self.of(quantity).into_iter().filter(Set::is_whole).collect();
        whole.sort_by_key(Set::rank);
        let Some(best) = whole.first().map(Set::rank) else { return Ok(None) };
        let equal: Vec<String> = whole
            .iter()
            .filter(|set| set.rank() == best)
            .map(|set| format!("`{}`", self.span(&set.places())))
            .collect();
        if equal.len() > 1 {
            let found = format!("{} kinds of columns for {key}: {}", equal.len(), equal.join(" and "));
            return Err((found, format!("one of them: name it, --columns '{key}=..'")));
        }
        let mut whole = whole.into_iter();
        Ok(whole.next().map(|set| Picked { set, passed: whole.collect() }))
    }

    /// The incomplete set of a quantity with the most joints.
    pub(super) fn partial(&self, quantity: Quantity) -> Option<Set> {
        self.of(quantity).into_iter().max_by_key(|set| set.places().len())
    }
}
