//! Keys that a study sets or varies, and their values.

use crate::describe::diagnostics::{FileError, Source};
use crate::describe::study::{Key, Literal, Relative, Setting, Values, Vary};
use crate::read::shown::counted;
use crate::read::table::{Table, Value};
use std::collections::BTreeSet;
use std::ops::Range;

/// Most keys that vary: the Sobol sequence has directions for this many.
const VARY_MAX: usize = 32;
const KEY: &str =
    "a key of the scene such as \"plant.payload.mass\", or of its robot such as \"robot.joint.elbow.mass\"";
/// Most values of a list.
const LIST_MAX: usize = 100_000;
/// Largest magnitude up to which whole numbers are drawn exactly.
const WHOLE_MAX: i64 = 1 << 53;

/// `unset`, a list of keys, and `[set]`, keys in quotes with their values.
pub(super) fn settings(root: &Table<'_>, source: &Source) -> Result<Vec<Setting>, FileError> {
    const UNSET: &str = "a list of keys that the scene has, in quotes";
    let unset = root.get("unset").map_or(Ok(Vec::new()), |value| value.array(UNSET))?;
    let unset = unset.iter().map(|item| {
        let key = key(item, item.string(UNSET)?, item.span.clone())?;
        Ok(Setting { key, value: None })
    });
    let mut settings = unset.collect::<Result<Vec<_>, FileError>>()?;
    settings.extend(set(root, source)?);
    Ok(settings)
}

fn set(root: &Table<'_>, source: &Source) -> Result<Vec<Setting>, FileError> {
    let Some(table) = root.table("set")? else { return Ok(Vec::new()) };
    let mut settings = table
        .entries()
        .map(|(name, place, value)| {
            let text = source.text.get(value.span.clone()).unwrap_or_default();
            if value.is_table() && !text.starts_with('{') {
                return Err(value.error("found a table", "the whole path in quotes: \"plant.friction\" = true"));
            }
            Ok(Setting { key: key(&value, name, place)?, value: Some(text.to_owned()) })
        })
        .collect::<Result<Vec<_>, FileError>>()?;
    // In the order of the file.
    settings.sort_by_key(|setting| setting.key.place.start);
    Ok(settings)
}

/// `[[vary]]`.
pub(super) fn varied(root: &Table<'_>, source: &Source) -> Result<Vec<Vary>, FileError> {
    let Some(list) = root.get("vary") else { return Ok(Vec::new()) };
    let items = list.array("[[vary]] tables")?;
    if items.len() > VARY_MAX {
        return Err(list.error(format!("found {} tables", items.len()), format!("at most {VARY_MAX} keys that vary")));
    }
    let mut names = BTreeSet::new();
    items
        .iter()
        .map(|item| {
            let table = item.table()?;
            let vary = vary(&table, source)?;
            if !names.insert(vary.key.name.clone()) {
                return Err(table.error("key", format!("`{}` varies already", vary.key.name), "every key once"));
            }
            Ok(vary)
        })
        .collect()
}

fn key(value: &Value<'_>, name: &str, place: Range<usize>) -> Result<Key, FileError> {
    let bare = name.split('.').any(str::is_empty) || name.chars().any(char::is_control) || name == "robot";
    if bare {
        Err(value.error(format!("found the key {name:?}"), KEY))
    } else {
        Ok(Key { name: name.to_owned(), place })
    }
}

fn vary(table: &Table<'_>, source: &Source) -> Result<Vary, FileError> {
    const FORMS: [&str; 5] = ["uniform", "log_uniform", "normal", "whole", "list"];
    const EITHER: &str = "exactly one of `uniform`, `log_uniform`, `normal`, `whole`, `list`";
    table.only(&["key", "uniform", "log_uniform", "normal", "whole", "list", "relative", "steps"])?;
    let named = table.require("key", KEY)?;
    let key = key(&named, named.string(KEY)?, named.span.clone())?;
    let given: Vec<&str> = FORMS.into_iter().filter(|form| table.get(form).is_some()).collect();
    let &[form] = given.as_slice() else {
        let problem = given.first().map_or("missing".to_owned(), |first| format!("given beside `{first}`"));
        return Err(table.error(given.last().unwrap_or(&"uniform"), problem, EITHER));
    };
    let value = table.require(form, EITHER)?;
    let values = match form {
        "uniform" => range(&value, "[lowest, highest]", f64::NEG_INFINITY).map(|(lo, hi)| Values::Uniform(lo, hi))?,
        "log_uniform" => range(&value, "[lowest, highest], both above zero", f64::MIN_POSITIVE)
            .map(|(lo, hi)| Values::LogUniform(lo, hi))?,
        "normal" => normal(&value)?,
        "whole" => whole(&value)?,
        _ => Values::List(list(&value, source)?),
    };
    let relative = table.get("relative").map_or(Ok(Relative::Value), |value| value.named())?;
    if relative != Relative::Value && !values.are_numbers() {
        return Err(table.error("relative", "given beside values that are no numbers", "numbers alone in the list"));
    }
    Ok(Vary { steps: steps(table, &values)?, key, values, relative })
}

/// Number of values in a grid; 0 if neither the values nor `steps` give it.
fn steps(table: &Table<'_>, values: &Values) -> Result<u64, FileError> {
    let given = table.get("steps");
    match (values, given) {
        (Values::List(list), None) => Ok(list.len() as u64),
        (Values::Whole(low, high), None) => Ok(high.abs_diff(*low) + 1),
        (Values::Uniform(..) | Values::LogUniform(..), Some(value)) => {
            const STEPS: &str = "a whole number of steps, 2 to 1,000,000";
            match value.count(1_000_000, STEPS)? {
                1 => Err(value.error("found 1", STEPS)),
                steps => Ok(steps.into()),
            }
        }
        (Values::Uniform(..) | Values::LogUniform(..) | Values::Normal { .. }, None) => Ok(0),
        (_, Some(value)) => Err(value.error("given beside other values", "`steps` beside `uniform` or `log_uniform`")),
    }
}

fn range(value: &Value<'_>, expected: &str, least: f64) -> Result<(f64, f64), FileError> {
    match value.numbers(2, expected)?[..] {
        [lo, hi] if lo < hi && lo >= least => Ok((lo, hi)),
        [lo, hi] => Err(value.error(format!("found {lo} to {hi}"), format!("{expected}, the lower one first"))),
        _ => Err(value.error("not two numbers", expected)),
    }
}

fn normal(value: &Value<'_>) -> Result<Values, FileError> {
    const EXPECTED: &str = "{ mean, deviation, within = [lowest, highest] }";
    if !value.is_table() {
        return Err(value.error("found no table", EXPECTED));
    }
    let table = value.table()?;
    table.only(&["mean", "deviation", "within"])?;
    let mean = table.require("mean", EXPECTED)?.finite("the mean")?;
    let deviation = table.require("deviation", EXPECTED)?.positive("the standard deviation, above zero")?;
    let within = table.get("within").map_or(Ok((f64::NEG_INFINITY, f64::INFINITY)), |value| {
        range(&value, "[lowest, highest]", f64::NEG_INFINITY)
    })?;
    // Farther out, a tail has no digits left to draw from.
    const FAR: f64 = 5.0;
    if within.0 > mean + FAR * deviation || within.1 < mean - FAR * deviation {
        return Err(table.error("within", "farther than five deviations from the mean", "a range about the mean"));
    }
    Ok(Values::Normal { mean, deviation, within })
}

fn whole(value: &Value<'_>) -> Result<Values, FileError> {
    const EXPECTED: &str = "[lowest, highest] in whole numbers, the lower one first";
    let (low, high) = range(value, EXPECTED, -(WHOLE_MAX as f64))?;
    if low.fract() != 0.0 || high.fract() != 0.0 || high > WHOLE_MAX as f64 {
        return Err(value.error(format!("found {low} to {high}"), EXPECTED));
    }
    Ok(Values::Whole(low as i64, high as i64))
}

fn list(value: &Value<'_>, source: &Source) -> Result<Vec<Literal>, FileError> {
    const EXPECTED: &str = "1 to 100,000 values";
    let items = value.array(EXPECTED)?;
    if !(1..=LIST_MAX).contains(&items.len()) {
        return Err(value.error(format!("found {}", counted(items.len(), "value", "values")), EXPECTED));
    }
    items
        .iter()
        .map(|item| {
            let toml = source.text.get(item.span.clone()).unwrap_or_default().to_owned();
            let number = item.number("").ok();
            let cell = match (number, item.is_string()) {
                (Some(_), _) => toml.clone(),
                (None, true) => item.string("")?.to_owned(),
                // Lists and tables are put on one line.
                (None, false) => toml.split_whitespace().collect::<Vec<_>>().join(" "),
            };
            if cell.chars().any(char::is_control) {
                return Err(item.error("found a control character", "values of characters that can be printed"));
            }
            if number.is_some_and(|number| !number.is_finite()) {
                return Err(item.error("found a number that is not finite", "finite numbers"));
            }
            Ok(Literal { toml, cell, number })
        })
        .collect()
}
