//! Meaning and unit of each column.

use super::Reading;
use super::clock::Clock;
use super::grid::{Grid, Problem};
use super::name::Role;
use super::sets::{Picked, Set, Sets};
use super::spec::{ColumnNames, Key, KeyColumns, listed};
use super::vocabulary::Quantity;

/// Indices of the columns to read.
pub(super) struct Places {
    /// Time, positions, velocities (or none), torques, in the order of reading.
    pub(super) all: Vec<usize>,
    /// Factor of each column: to rad, m, rad/s, m/s, N m, N or A. Time is converted by `clock`.
    pub(super) factors: Vec<f64>,
    /// True if velocity columns exist.
    pub(super) velocities: bool,
    /// True if the last columns are currents, false if they are torques.
    pub(super) currents: bool,
    /// Interpretation of the time column.
    pub(super) clock: Clock,
    /// Remarks for the report.
    pub(super) notes: Vec<String>,
}

impl Places {
    fn joints(&self) -> usize {
        (self.all.len() - 1) / if self.velocities { 3 } else { 2 }
    }

    pub(super) fn positions(&self) -> &[usize] {
        &self.all[1..=self.joints()]
    }

    pub(super) fn speeds(&self) -> &[usize] {
        &self.all[1 + self.joints()..self.all.len() - self.joints()]
    }

    pub(super) fn torques(&self) -> &[usize] {
        &self.all[self.all.len() - self.joints()..]
    }

    pub(super) fn find(grid: &Grid, reading: &Reading) -> Result<Self, Problem> {
        let sets = Sets::new(grid, &reading.joints)?;
        let mut finder = Finder { grid, reading, sets, notes: Vec::new(), bases: Vec::new() };
        if grid.head_line == 0 && reading.columns.is_none() {
            let expected = "a header of column names above them, or --columns 't=#1,q=#2-#4,tau=#5-#7' with your numbers of columns";
            return Err((format!("{} columns of numbers without names", grid.head.len()), expected.to_owned()));
        }
        let positions = finder.positions()?;
        let (currents, torques) = finder.torques()?;
        let speeds = finder.speeds()?;
        let (time, clock) = finder.time(&positions)?;
        finder.one_count()?;
        let kinds = [
            (Quantity::Position, &positions, Key::Position),
            (Quantity::Velocity, &speeds, Key::Velocity),
            if currents {
                (Quantity::Current, &torques, Key::Current)
            } else {
                (Quantity::Torque, &torques, Key::Torque)
            },
        ];
        let (mut all, mut factors) = (vec![time], vec![1.0]);
        for (quantity, places, key) in kinds {
            for (joint, place) in places.iter().enumerate() {
                all.push(*place);
                factors.push(finder.factor(quantity, joint, *place, key)?);
            }
        }
        finder.note_units(&all[1..]);
        Ok(Self { velocities: !speeds.is_empty(), all, factors, currents, clock, notes: finder.notes })
    }
}

pub(super) struct Finder<'a> {
    pub(super) grid: &'a Grid,
    pub(super) reading: &'a Reading,
    pub(super) sets: Sets<'a>,
    pub(super) notes: Vec<String>,
    /// For each quantity whose joints are numbered: its column names, the first number, and the number of columns that belong to no joint.
    bases: Vec<(String, u32, usize)>,
}

impl Finder<'_> {
    pub(super) fn given(&self, key: Key) -> Option<&KeyColumns> {
        self.reading.columns.as_ref().and_then(|columns: &ColumnNames| columns.given(key))
    }

    pub(super) fn by_hand(&self, key: Key) -> Result<Option<Vec<usize>>, Problem> {
        self.given(key).map(|given| given.places(&self.grid.head, &self.reading.joints)).transpose()
    }

    fn names(&self, set: &Set) -> String {
        self.sets.span(&set.places())
    }

    /// Name of the first joint's column with `{}` for its number; a list of all names if joints have no numbers.
    fn pattern(&self, set: &Set) -> String {
        let places = set.places();
        let names: Vec<&str> = places.iter().map(|place| self.grid.head[*place].as_str()).collect();
        let first = names.first().copied().unwrap_or("");
        match set.base.and_then(|base| first.rfind(&base.to_string()).map(|at| (at, base.to_string().len()))) {
            Some((at, length)) => format!("{}{{}}{}", &first[..at], &first[at + length..]),
            None => names.join(","),
        }
    }

    /// Returns the columns of a set, and adds remarks on choices that are not evident.
    fn take(&mut self, picked: &Picked, what: &str) -> Vec<usize> {
        let set = &picked.set;
        let places = set.places();
        let names = self.names(set);
        let joints = &self.reading.joints;
        if let Some(passed) = picked.passed.first().filter(|_| set.role != Role::Plain) {
            let of = if set.role == Role::Actual { "measured" } else { "filtered" };
            self.notes.push(format!("{what}: {names} ({of}), not {}", self.names(passed)));
        }
        if set.bare {
            self.notes.push(format!("{what}: {names} have no word for their quantity and are taken as {what}"));
        }
        if set.ordered {
            let order: Vec<String> =
                places.iter().zip(joints).map(|(k, joint)| format!("{} is {joint}", self.grid.head[*k])).collect();
            self.notes.push(format!("{what} in the order of the log's names: {}", order.join(", ")));
        } else if set.base == Some(0) {
            let first = places.first().map_or("", |k| self.grid.head[*k].as_str());
            let name = joints.first().map_or("", String::as_str);
            self.notes.push(format!("{what} count from 0: {first} is joint 1 ({name})"));
        }
        if !set.extra.is_empty() {
            let extra: Vec<&str> = set.extra.iter().map(|k| self.grid.head[*k].as_str()).collect();
            self.notes.push(format!("{what}: {} left out, the robot has {} joints", extra.join(", "), joints.len()));
        }
        if let Some(base) = set.base {
            self.bases.push((names, base, set.extra.len()));
        }
        places
    }

    fn missing(&self, quantity: Quantity, name: &str, unit: &str) -> Problem {
        let partial = self.sets.partial(quantity);
        let joint = partial.as_ref().and_then(|set| set.joints.iter().position(Option::is_none)).unwrap_or(0);
        let base = partial.and_then(|set| set.base).unwrap_or(1) as usize;
        let (joints, column) = (&self.reading.joints, joint + base);
        let expected = format!("a column `{name}_{column}` for joint {} ({}), {unit}", joint + 1, joints[joint]);
        (listed(&self.grid.head), format!("{expected}; other names: --columns '{name}=NAME_{{}}'"))
    }

    fn positions(&mut self) -> Result<Vec<usize>, Problem> {
        if let Some(places) = self.by_hand(Key::Position)? {
            return Ok(places);
        }
        let picked = self
            .sets
            .pick(Quantity::Position, "q")?
            .ok_or_else(|| self.missing(Quantity::Position, "q", "rad or m"))?;
        if picked.set.role == Role::Commanded {
            let found = format!("commanded positions only: {}", self.names(&picked.set));
            return Err((found, "measured positions, or --columns 'q=..' if these are what you want".to_owned()));
        }
        Ok(self.take(&picked, "positions"))
    }

    fn speeds(&mut self) -> Result<Vec<usize>, Problem> {
        if let Some(places) = self.by_hand(Key::Velocity)? {
            return Ok(places);
        }
        // A commanded velocity is not a measurement; the derivative of the positions is better.
        match self.sets.pick(Quantity::Velocity, "qd")?.filter(|picked| picked.set.role != Role::Commanded) {
            Some(picked) => Ok(self.take(&picked, "velocities")),
            None => Ok(Vec::new()),
        }
    }

    /// Columns of torques (false) or of currents (true).
    fn torques(&mut self) -> Result<(bool, Vec<usize>), Problem> {
        let n = self.reading.joints.len();
        let constant = format!("--torque-per-ampere K1,..,K{n} in N m/A");
        if let Some(places) = self.by_hand(Key::Torque)? {
            return Ok((false, places));
        }
        if let Some(places) = self.by_hand(Key::Current)? {
            if self.reading.per_ampere.is_none() {
                return Err(("currents by --columns i=.., and no torque per ampere".to_owned(), constant));
            }
            return Ok((true, places));
        }
        let torque = self.sets.pick(Quantity::Torque, "tau")?;
        let current = self.sets.pick(Quantity::Current, "i")?;
        let (currents, picked) = match (torque, current) {
            (None, None) => {
                let partial =
                    self.sets.partial(Quantity::Torque).is_none() && self.sets.partial(Quantity::Current).is_some();
                return Err(if partial {
                    self.missing(Quantity::Current, "current", "A (or `tau_1` .. in N m)")
                } else {
                    self.missing(Quantity::Torque, "tau", "N m or N")
                });
            }
            (Some(torque), None) => (false, torque),
            (None, Some(current)) => (true, current),
            (Some(torque), Some(current)) if self.reading.currents_meant => {
                self.notes.push(format!(
                    "torques by --torque-per-ampere from {}, not {}",
                    self.names(&current.set),
                    self.names(&torque.set)
                ));
                (true, current)
            }
            (Some(torque), Some(current)) if torque.set.role == Role::Actual => {
                self.notes.push(format!(
                    "torques: {} (measured), not the currents {}",
                    self.names(&torque.set),
                    self.names(&current.set)
                ));
                (false, torque)
            }
            (Some(torque), Some(current)) => {
                let found =
                    format!("torques `{}` and currents `{}`", self.names(&torque.set), self.names(&current.set));
                let commanded = if torque.set.role == Role::Commanded { " (a target, not a measurement)" } else { "" };
                let pattern = self.pattern(&torque.set);
                let expected = format!(
                    "one of them: {constant} for the currents, or --columns 'tau={pattern}' for the torques{commanded}"
                );
                return Err((found, expected));
            }
        };
        if currents && self.reading.per_ampere.is_none() {
            let found = format!("currents ({}) and no torque per ampere", self.names(&picked.set));
            return Err((found, format!("{constant}, or columns `tau_1` ..")));
        }
        if picked.set.role == Role::Commanded {
            let names = self.names(&picked.set);
            self.notes.push(format!("torques: {names} are commanded, none was measured"));
        }
        Ok((currents, self.take(&picked, if currents { "currents" } else { "torques" })))
    }

    /// Rejects a log that counts one quantity from 0 and another from 1 if columns are left over.
    fn one_count(&self) -> Result<(), Problem> {
        let differ = self.bases.iter().find(|(_, base, _)| *base != self.bases[0].1);
        match differ.filter(|_| self.bases.iter().any(|(.., extra)| *extra > 0)) {
            None => Ok(()),
            Some((names, ..)) => Err((
                format!(
                    "`{}` and `{names}`: one counts from 0 and one from 1, and there are more columns than joints",
                    self.bases[0].0
                ),
                "which columns belong to the joints: --columns 'q=NAME_1,NAME_2,..'".to_owned(),
            )),
        }
    }
}
