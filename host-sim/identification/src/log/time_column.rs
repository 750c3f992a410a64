//! Selection of the time column.

use super::clock::Clock;
use super::grid::Problem;
use super::header::Finder;
use super::spec::{Key, listed};
use super::unit::Kind;
use super::vocabulary::Quantity;

impl Finder<'_> {
    pub(super) fn time(&mut self, positions: &[usize]) -> Result<(usize, Clock), Problem> {
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
        // Columns `sec` and `nanosec` without a prefix.
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
            // Prefer the time of measurement to the time of recording.
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

    /// True if time columns differ by less than half a step, relative to their first rows.
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
