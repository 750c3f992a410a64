//! Units and conversion factors of the columns.

use super::grid::Problem;
use super::header::Finder;
use super::heading_words::bracket;
use super::spec::{Key, KeyColumns};
use super::unit::{self, Kind, Unit};
use super::vocabulary::Quantity;

const ALL: &[Kind] =
    &[Kind::Time, Kind::Angle, Kind::Length, Kind::AngularSpeed, Kind::Speed, Kind::Torque, Kind::Force, Kind::Current];

impl Finder<'_> {
    /// Unit of a column: from its heading, from the row of units, or from the user.
    pub(super) fn unit(&self, place: usize, given: Option<&KeyColumns>) -> Result<Option<Unit>, Problem> {
        let name = &self.grid.head[place];
        let by_hand = given.and_then(|given| given.unit);
        let (heading, loose, unknown) = match self.sets.columns.iter().find(|column| column.place == place) {
            Some(column) => (column.meaning.unit, column.meaning.loose, column.meaning.unknown_unit.clone()),
            // A column that the user names may have a heading without a meaning.
            None => match bracket(name) {
                Some((_, inner, _)) => {
                    let unit = Unit::parse(inner);
                    (unit, false, unit.is_none().then(|| inner.to_owned()))
                }
                None => (name.rsplit_once(['_', ' ']).and_then(|(_, end)| Unit::parse(end)), true, None),
            },
        };
        if let Some(unknown) = unknown.filter(|_| by_hand.is_none()) {
            let expected = format!("one of {}; or by hand, --columns 'q[deg]=..'", unit::listed(ALL));
            return Err((format!("the unit {unknown:?} of {name:?}"), expected));
        }
        let row = Unit::parse(self.grid.units.get(place).map_or("", |text| text.trim_matches(['[', ']', '{', '}'])));
        // A word of the heading that only looks like a unit yields to the user's unit.
        let mut unit = heading.filter(|_| !(loose && by_hand.is_some())).or(row);
        for other in [row, by_hand].into_iter().flatten() {
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

    pub(super) fn factor(&self, quantity: Quantity, joint: usize, place: usize, key: Key) -> Result<f64, Problem> {
        let turns = self.reading.turns[joint];
        let degrees = self.reading.degrees && turns && matches!(quantity, Quantity::Position | Quantity::Velocity);
        let name = &self.grid.head[place];
        let kinds: &[Kind] = match (quantity, turns) {
            (Quantity::Position, true) => &[Kind::Angle],
            (Quantity::Position, false) => &[Kind::Length],
            // `qd [deg]` is not strictly a velocity unit, but clear.
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

    /// True if the heading gives the position of a joint in degrees. Its velocity without a unit is then in degrees per second.
    fn angles_in_degrees(&self, joint: usize) -> bool {
        let place = match self.by_hand(Key::Position) {
            Ok(Some(places)) => places.get(joint).copied(),
            _ => self.sets.pick(Quantity::Position, "q").ok().flatten().and_then(|picked| picked.set.joints[joint]),
        };
        let unit = place.and_then(|place| self.unit(place, self.given(Key::Position)).ok().flatten());
        unit.is_some_and(|unit| unit.name == "deg")
    }

    /// Adds a remark that names the units that were converted.
    pub(super) fn note_units(&mut self, places: &[usize]) {
        let mut said: Vec<(&str, Vec<usize>)> = Vec::new();
        for place in places {
            let by_hand = [Key::Position, Key::Velocity, Key::Torque, Key::Current].map(|key| self.given(key));
            let unit = std::iter::once(None)
                .chain(by_hand)
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
        let joints = self.reading.joints.len();
        let follows = |k: usize, place: usize| {
            let unit = self.unit(place, self.given(Key::Velocity));
            self.reading.turns[k] && !self.reading.degrees && unit == Ok(None) && self.angles_in_degrees(k)
        };
        if places.len() == 3 * joints && (0..joints).any(|k| follows(k, places[joints + k])) {
            let names = self.sets.span(&places[joints..2 * joints]);
            self.notes.push(format!("{names} taken in deg/s, as the positions are in deg"));
        }
    }

    fn is_given(&self, given: &KeyColumns, place: usize) -> bool {
        given.places(&self.grid.head, &self.reading.joints).is_ok_and(|places| places.contains(&place))
    }
}
