//! Units of a log's time column.

use super::fields::number;
use super::grid::Problem;
use crate::statistics::median;

/// Interpretation of a time column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Clock {
    /// Multiply by this factor to get s.
    Factor(f64),
    /// Unknown unit, to be inferred from the steps or from the date.
    Judge,
    /// Whole seconds; the column with this index has the nanoseconds.
    Stamp(usize),
}

/// Units of time: name, range of usual steps in this unit (2 kHz to 5 Hz; 10 kHz for the finer units), and factor to s.
const UNITS: [(&str, f64, f64, f64); 3] = [("ms", 0.5, 200.0, 1e-3), ("us", 100.0, 2e5, 1e-6), ("ns", 1e5, 2e8, 1e-9)];
/// Usual steps in s: 100 kHz to 5 Hz.
const SECONDS: (f64, f64) = (1e-5, 0.2);
/// Seconds since 1970 that are dates of this century.
const DATES: (f64, f64) = (9.4e8, 4.1e9);
/// A first time beyond this, in the column's unit, is a date. The log's time then starts at zero, because a double has too few digits for both date
/// and steps.
const DATE: f64 = 1e8;

impl Clock {
    /// Time of the rows, s, from the fields of the column (and of the nanoseconds), and a remark if the unit was inferred.
    ///
    /// # Errors
    /// The index of the row and what is wrong with it.
    pub(super) fn seconds(self, fields: &[(&str, &str)]) -> Result<(Vec<f64>, Option<String>), (usize, Problem)> {
        let wrong = |k: usize, text: &str| {
            let found = if text.is_empty() { "nothing".to_owned() } else { format!("{text:?}") };
            let date = text.len() > 7 && (text.matches(':').count() == 2 || text.matches('-').count() == 2);
            let expected = if date { "time as a number: s, ms, us or ns" } else { "a finite number" };
            (k, (found, expected.to_owned()))
        };
        let mut time = column(fields.iter().map(|(text, _)| *text), &wrong)?;
        match self {
            Self::Factor(factor) => {
                time.raw.iter_mut().for_each(|t| *t *= factor);
                Ok((time.raw, None))
            }
            Self::Stamp(_) => {
                let nanos = column(fields.iter().map(|(_, text)| *text), &wrong)?;
                let all = time.raw.iter().zip(&nanos.raw).map(|(s, ns)| s + 1e-9 * (ns + nanos.origin));
                Ok((all.collect(), None))
            }
            Self::Judge => {
                let (factor, note) = time.judged().map_err(|problem| (0, problem))?;
                time.raw.iter_mut().for_each(|t| *t *= factor);
                Ok((time.raw, note))
            }
        }
    }
}

/// A column of numbers relative to an origin. The origin is zero unless the numbers are dates.
struct Counted {
    origin: f64,
    raw: Vec<f64>,
}

fn column<'t>(
    texts: impl Iterator<Item = &'t str> + Clone,
    wrong: &dyn Fn(usize, &str) -> (usize, Problem),
) -> Result<Counted, (usize, Problem)> {
    // Nanoseconds since 1970 have more digits than a double.
    let whole: Option<Vec<i128>> = texts.clone().map(|text| text.parse().ok()).collect();
    if let Some(whole) = whole {
        let first = whole.first().copied().unwrap_or(0);
        let origin = if first.unsigned_abs() > DATE as u128 { first } else { 0 };
        return Ok(Counted { origin: origin as f64, raw: whole.iter().map(|t| (t - origin) as f64).collect() });
    }
    let numbers = texts.enumerate().map(|(k, text)| number(text).ok_or_else(|| wrong(k, text)));
    let raw = numbers.collect::<Result<Vec<f64>, _>>()?;
    let first = raw.first().copied().unwrap_or(0.0);
    let origin = if first.abs() > DATE { first } else { 0.0 };
    Ok(Counted { origin, raw: raw.iter().map(|t| t - origin).collect() })
}

impl Counted {
    /// Factor to s, and a remark if the unit was inferred and is not s.
    fn judged(&self) -> Result<(f64, Option<String>), Problem> {
        let steps = self.raw.windows(2).map(|t| t[1] - t[0]).filter(|step| *step > 0.0);
        let step = median(steps.collect());
        let said = |name: &str, factor: f64| {
            let by = if self.origin == 0.0 { "by its steps" } else { "by its date" };
            (factor, Some(format!("time in {name}, judged {by}: {} s", short(step * factor))))
        };
        let is_date = |factor: f64| (DATES.0..DATES.1).contains(&(self.origin * factor));
        if let Some((name, .., factor)) = UNITS.iter().find(|(.., factor)| is_date(*factor)) {
            return Ok(said(name, *factor));
        }
        if is_date(1.0) || (SECONDS.0..=SECONDS.1).contains(&step) {
            return Ok((1.0, None));
        }
        let fit: Vec<_> = UNITS.iter().filter(|(_, least, most, _)| (*least..=*most).contains(&step)).collect();
        match fit.as_slice() {
            // Later checks of the time report the problem.
            [] => Ok((1.0, None)),
            [(name, .., factor)] => Ok(said(name, *factor)),
            many => {
                let names: Vec<&str> = many.iter().map(|(name, ..)| *name).collect();
                let found = format!("time in steps of {}, without a unit: {}?", short(step), names.join(" or "));
                Err((found, "the unit in the header (`time [us]`), or --columns 't[us]=time'".to_owned()))
            }
        }
    }
}

/// Formats with at most six digits.
fn short(x: f64) -> String {
    let text = format!("{x:.5e}");
    text.parse::<f64>().map_or(text, |x| x.to_string())
}

#[cfg(test)]
mod tests {
    use super::Clock;

    fn read(clock: Clock, first: &str, second: &str, third: &str) -> Result<(Vec<f64>, bool), String> {
        let fields = [(first, "0"), (second, "0"), (third, "0")];
        clock.seconds(&fields).map(|(time, note)| (time, note.is_some())).map_err(|(_, (found, _))| found)
    }

    #[test]
    fn units_of_time_are_judged_if_only_one_fits() {
        let judged = |a, b, c| read(Clock::Judge, a, b, c);
        assert_eq!(judged("0", "0.005", "0.01").unwrap(), (vec![0.0, 0.005, 0.01], false));
        for [a, b, c] in [["0", "5", "10"], ["0", "5000", "10000"], ["0", "5000000", "10000000"]] {
            let (time, noted) = judged(a, b, c).unwrap();
            assert!((time[2] - 0.01).abs() < 1e-12 && noted, "{a} {b}: {time:?}");
        }
        // Dates in nanoseconds are read exactly, although a double cannot hold the whole number.
        let (time, noted) = judged("1764143064123456789", "1764143064128456790", "1764143064133456788").unwrap();
        assert!(
            noted && (time[1] - 0.005_000_001).abs() < 1e-15 && (time[2] - 0.009_999_999).abs() < 1e-15,
            "{time:?}"
        );
        let (time, noted) = judged("1764143064.25", "1764143064.255", "1764143064.26").unwrap();
        assert!((time[2] - 0.01).abs() < 1e-6 && !noted);
        assert!(judged("0", "150", "300").unwrap_err().contains("ms or us"));
    }

    #[test]
    fn stamps_in_two_columns_are_one_time() {
        let fields = [("1764143064", "990000000"), ("1764143065", "0"), ("1764143065", "10000000")];
        let (time, _) = Clock::Stamp(1).seconds(&fields).unwrap();
        assert!((time[1] - time[0] - 0.01).abs() < 1e-9 && (time[2] - time[0] - 0.02).abs() < 1e-9, "{time:?}");
    }

    #[test]
    fn dates_and_holes_are_named() {
        let fields = [("2026-11-25 10:00:00", "")];
        let (k, (found, expected)) = Clock::Judge.seconds(&fields).unwrap_err();
        assert!(k == 0 && found.contains("2026-11-25") && expected.contains("as a number"), "{found} {expected}");
        assert_eq!(Clock::Factor(1.0).seconds(&[("", "")]).unwrap_err().1.0, "nothing");
    }
}
