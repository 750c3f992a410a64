//! Which column is what, and in which unit.

use super::Reading;
use super::clock::Clock;
use super::grid::{Grid, Problem};
use super::name::{Quantity, Role};
use super::sets::{Picked, Set, Sets};
use super::spec::{ColumnNames, Given, Key, listed};
use super::unit::{self, Kind, Unit};

/// Places of columns in a file.
pub(super) struct Places {
    /// Time, positions, velocities (or none), torques; the order of what is read.
    pub(super) all: Vec<usize>,
    /// Factor of each: to rad, m, rad/s, m/s, N m, N or A. That of time is in `clock`.
    pub(super) factors: Vec<f64>,
    /// True if velocities are there.
    pub(super) velocities: bool,
    /// True if the last ones are currents.
    pub(super) currents: bool,
    /// How time is counted.
    pub(super) clock: Clock,
    /// Remarks for the reader of the report.
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

struct Finder<'a> {
    grid: &'a Grid,
    reading: &'a Reading,
    sets: Sets<'a>,
    notes: Vec<String>,
    /// First number, and number of columns of no joint, of the quantities whose joints have numbers.
    bases: Vec<(String, u32, usize)>,
}

impl Finder<'_> {
    fn given(&self, key: Key) -> Option<&Given> {
        self.reading.columns.as_ref().and_then(|columns: &ColumnNames| columns.given(key))
    }

    fn by_hand(&self, key: Key) -> Result<Option<Vec<usize>>, Problem> {
        self.given(key).map(|given| given.places(&self.grid.head, &self.reading.joints)).transpose()
    }

    fn names(&self, set: &Set) -> String {
        self.sets.span(&set.places())
    }

    /// The name of the first joint's column with `{}` for its number; a list of all names if joints have no numbers.
    fn pattern(&self, set: &Set) -> String {
        let places = set.places();
        let names: Vec<&str> = places.iter().map(|place| self.grid.head[*place].as_str()).collect();
        let first = names.first().copied().unwrap_or("");
        match set.base.and_then(|base| first.rfind(&base.to_string()).map(|at| (at, base.to_string().len()))) {
            Some((at, length)) => format!("{}{{}}{}", &first[..at], &first[at + length..]),
            None => names.join(","),
        }
    }

    /// Takes a set, and remarks on what is not evident.
    fn take(&mut self, picked: &Picked, what: &str) -> Vec<usize> {
        let set = &picked.set;
        let places = set.places();
        let names = self.names(set);
        let joints = &self.reading.joints;
        if let Some(passed) = picked.passed.first().filter(|_| set.role != Role::Plain) {
            let of = if set.role == Role::Actual { "measured" } else { "filtered" };
            self.notes.push(format!("{what}: {names} ({of}), not {}", self.names(passed)));
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
        let (number, joints) = (joint + 1, &self.reading.joints);
        let expected = format!("a column `{name}_{number}` for joint {number} ({}), {unit}", joints[joint]);
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
        // A reference is no measurement: the derivative of positions is better.
        match self.sets.pick(Quantity::Velocity, "qd")?.filter(|picked| picked.set.role != Role::Commanded) {
            Some(picked) => Ok(self.take(&picked, "velocities")),
            None => Ok(Vec::new()),
        }
    }

    /// Torques, or currents: the flag.
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

    /// Refuses numbers from 0 in one quantity and from 1 in another if columns are left over.
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

    /// Unit of a column: in its heading or in the row below.
    fn unit(&self, place: usize, given: Option<&Given>) -> Result<Option<Unit>, Problem> {
        let column = self.sets.columns.iter().find(|column| column.place == place);
        let name = &self.grid.head[place];
        if let Some(unknown) = column.and_then(|column| column.meaning.unknown_unit.as_ref()) {
            return Err((format!("the unit {unknown:?} of {name:?}"), format!("one of {}", unit::listed(ALL))));
        }
        let heading = column.and_then(|column| column.meaning.unit).or_else(|| {
            // A column by hand may have a name that means nothing.
            let open = name.rfind(['[', '('])?;
            Unit::parse(&name[open..])
        });
        let text = self.grid.units.get(place).map_or("", |text| text.trim_matches(['[', ']', '{', '}']));
        let row = Unit::parse(text);
        let mut unit = heading.or(row);
        for other in [row, given.and_then(|given| given.unit)].into_iter().flatten() {
            if let Some(known) = unit.filter(|known| *known != other) {
                return Err((
                    format!("two units of {name:?}: {} and {}", known.name, other.name),
                    "one unit".to_owned(),
                ));
            }
            unit = Some(other);
        }
        Ok(unit)
    }

    fn factor(&self, quantity: Quantity, joint: usize, place: usize, key: Key) -> Result<f64, Problem> {
        let turns = self.reading.turns[joint];
        let degrees = self.reading.degrees && turns && matches!(quantity, Quantity::Position | Quantity::Velocity);
        let name = &self.grid.head[place];
        let kinds: &[Kind] = match (quantity, turns) {
            (Quantity::Position, true) => &[Kind::Angle],
            (Quantity::Position, false) => &[Kind::Length],
            // "qd [deg]" is loose, and clear.
            (Quantity::Velocity, true) => &[Kind::AngularSpeed, Kind::Angle],
            (Quantity::Velocity, false) => &[Kind::Speed, Kind::Length],
            (Quantity::Current, _) => &[Kind::Current],
            (_, true) => &[Kind::Torque],
            (_, false) => &[Kind::Force],
        };
        let Some(unit) = self.unit(place, self.given(key))? else {
            let follows = quantity == Quantity::Velocity && turns && self.angles_in_degrees(joint);
            return Ok(if degrees || follows { 1f64.to_radians() } else { 1.0 });
        };
        if !kinds.contains(&unit.kind) {
            let kind = if turns { "revolute" } else { "prismatic" };
            let found = format!(
                "{name:?} in {}, and joint {} ({}) is {kind}",
                unit.name,
                joint + 1,
                self.reading.joints[joint]
            );
            return Err((found, format!("one of {}", unit::listed(kinds))));
        }
        if degrees && !unit.name.contains("deg") {
            return Err((format!("{name:?} in {}, and --degrees", unit.name), "one of both".to_owned()));
        }
        Ok(unit.factor)
    }

    /// True if the position of a joint is in degrees by its heading: its velocity without a unit is then in degrees too.
    fn angles_in_degrees(&self, joint: usize) -> bool {
        let place = match self.by_hand(Key::Position) {
            Ok(Some(places)) => places.get(joint).copied(),
            _ => self.sets.pick(Quantity::Position, "q").ok().flatten().and_then(|picked| picked.set.joints[joint]),
        };
        let unit = place.and_then(|place| self.unit(place, self.given(Key::Position)).ok().flatten());
        unit.is_some_and(|unit| unit.name == "deg")
    }

    /// Names the units that were converted.
    fn note_units(&mut self, places: &[usize]) {
        let mut said: Vec<(&str, Vec<usize>)> = Vec::new();
        for place in places {
            let unit = [
                None,
                self.given(Key::Position),
                self.given(Key::Velocity),
                self.given(Key::Torque),
                self.given(Key::Current),
            ]
            .into_iter()
            .find_map(|given| self.unit(*place, given.filter(|given| self.is_given(given, *place))).ok().flatten());
            let Some(unit) = unit.filter(|unit| (unit.factor - 1.0).abs() > 1e-12) else { continue };
            match said.iter_mut().find(|(name, _)| *name == unit.name) {
                Some((_, places)) => places.push(*place),
                None => said.push((unit.name, vec![*place])),
            }
        }
        for (name, places) in said {
            self.notes.push(format!("{} converted from {name}", self.sets.span(&places)));
        }
    }

    fn is_given(&self, given: &Given, place: usize) -> bool {
        given.places(&self.grid.head, &self.reading.joints).is_ok_and(|places| places.contains(&place))
    }

    fn time(&mut self, positions: &[usize]) -> Result<(usize, Clock), Problem> {
        let mut candidates: Vec<(usize, Clock)> = Vec::new();
        if let Some(places) = self.by_hand(Key::Time)? {
            let place = places[0];
            return Ok((place, self.clock(place)?));
        }
        let group_of = |place: usize| {
            self.sets.columns.iter().find(|column| column.place == place).map(|column| column.meaning.group.as_str())
        };
        let group = positions.first().and_then(|place| group_of(*place)).unwrap_or("");
        let of =
            |quantity: Quantity| self.sets.columns.iter().filter(move |column| column.meaning.quantity == quantity);
        for seconds in of(Quantity::StampSeconds) {
            let beside = |other: &&super::sets::Column| other.meaning.group == seconds.meaning.group;
            if let Some(nanos) = of(Quantity::StampNanoseconds).find(beside) {
                candidates.push((seconds.place, Clock::Stamp(nanos.place)));
            }
        }
        // `sec` and `nanosec` by themselves.
        let nanos = of(Quantity::StampNanoseconds).next().map(|column| column.place);
        for column in of(Quantity::Time) {
            let whole = matches!(column.meaning.word.as_str(), "sec" | "secs" | "seconds");
            match nanos.filter(|_| whole && candidates.is_empty()) {
                Some(nanos) => candidates.push((column.place, Clock::Stamp(nanos))),
                None => candidates.push((column.place, self.clock(column.place)?)),
            }
        }
        let stamp = |(place, _): &&(usize, Clock)| {
            let name = self.grid.head[*place].to_lowercase();
            name.contains("stamp") && name.contains("header") && name.contains(&group.to_lowercase())
        };
        let stamps: Vec<&(usize, Clock)> = candidates.iter().filter(stamp).collect();
        let chosen = match (candidates.as_slice(), stamps.as_slice()) {
            ([], _) => None,
            ([one], _) => Some(*one),
            // The time of the measurement, not that at which it was recorded.
            (_, [stamp]) => Some(**stamp),
            (many, _) => {
                if !self.alike(many) {
                    let names: Vec<String> =
                        many.iter().map(|(place, _)| format!("`{}`", self.grid.head[*place])).collect();
                    let found = format!("{} columns of time that differ: {}", many.len(), names.join(", "));
                    return Err((found, "one: --columns 't=NAME'".to_owned()));
                }
                Some(many[0])
            }
        };
        if let Some((place, clock)) = chosen {
            if candidates.len() > 1 {
                let others: Vec<&str> =
                    candidates.iter().filter(|(k, _)| *k != place).map(|(k, _)| self.grid.head[*k].as_str()).collect();
                self.notes.push(format!("time: {}, not {}", self.grid.head[place], others.join(", ")));
            }
            return Ok((place, clock));
        }
        match (of(Quantity::Tick).next(), self.reading.tick_rate) {
            (Some(tick), Some(rate)) => Ok((tick.place, Clock::Factor(1.0 / rate))),
            (Some(_), None) => Err(("time in ticks".to_owned(), "a column `time` in s, or --tick-rate HZ".to_owned())),
            (None, _) => Err((
                listed(&self.grid.head),
                "a column `time` (or `t`), s; another name: --columns 't=NAME'".to_owned(),
            )),
        }
    }

    /// True if columns of time differ by less than half a step, from their first rows on.
    fn alike(&self, candidates: &[(usize, Clock)]) -> bool {
        let all: Option<Vec<Vec<f64>>> = candidates.iter().map(|(place, clock)| self.seconds(*place, *clock)).collect();
        let Some(all) = all else { return false };
        let from_start = |time: &[f64], k: usize| time[k] - time[0];
        all.iter().skip(1).all(|other| {
            let half = 0.5 * from_start(&all[0], all[0].len() - 1) / all[0].len() as f64;
            (0..other.len()).all(|k| (from_start(other, k) - from_start(&all[0], k)).abs() < half)
        })
    }

    fn seconds(&self, place: usize, clock: Clock) -> Option<Vec<f64>> {
        let beside = if let Clock::Stamp(nanos) = clock { nanos } else { place };
        let rows = self.grid.rows.iter().map(|(_, row)| row);
        let fields: Vec<(&str, &str)> =
            rows.map(|row| (row.get(place).unwrap_or(""), row.get(beside).unwrap_or(""))).collect();
        clock.seconds(&fields).ok().map(|(time, _)| time).filter(|time| !time.is_empty())
    }

    fn clock(&self, place: usize) -> Result<Clock, Problem> {
        match self.unit(place, self.given(Key::Time))? {
            Some(unit) if unit.kind == Kind::Time => Ok(Clock::Factor(unit.factor)),
            Some(unit) => {
                Err((format!("{:?} in {}", self.grid.head[place], unit.name), "time in s, ms, us or ns".to_owned()))
            }
            None => Ok(Clock::Judge),
        }
    }
}

const ALL: &[Kind] =
    &[Kind::Time, Kind::Angle, Kind::Length, Kind::AngularSpeed, Kind::Speed, Kind::Torque, Kind::Force, Kind::Current];
