//! Tables of the numbers in both summaries and their differences, joint by joint.

use super::Side;
use report::{Cell, Table};
use serde_json::Value;
use sim::run::numbers::engineering;

/// A per-joint number of `summary.json`: its name in a table, the JSON pointer of its list, and its unit or the key of the joint's unit.
type ComparedQuantity = (&'static str, &'static str, &'static str);

const ERRORS: [ComparedQuantity; 4] = [
    ("rms", "/tracking_rms", "position_unit"),
    ("max", "/tracking_max", "position_unit"),
    ("at rest", REST_ERROR, "position_unit"),
    ("settles in", SETTLING_TIME, "s"),
];
const TORQUES: [ComparedQuantity; 3] = [
    ("rms", "/torque_rms", "torque_unit"),
    ("peak", "/torque_peak", "torque_unit"),
    ("chatter", "/torque_chatter", "torque_unit"),
];
const WORK: [ComparedQuantity; 2] = [("given", "/work/given", "J"), ("taken back", "/work/taken_back", "J")];

const REST_ERROR: &str = "/rest_error";
const SETTLING_TIME: &str = "/settling_time";

/// Ratio above which a change is shown as `60 times` instead of `+5900 %`.
const TIMES: f64 = 2.0;

/// All tables.
pub(super) fn all(a: &Side, b: &Side) -> [Table; 4] {
    [
        table("Position error", &ERRORS, a, b),
        table("Torque or force", &TORQUES, a, b),
        table("Work of the torques", &WORK, a, b),
        limits(a, b),
    ]
}

/// Change from A to B: in percent of A, or as a ratio.
pub(super) fn change(before: f64, after: f64) -> String {
    let (before, after) = (before.abs(), after.abs());
    if before.to_bits() == after.to_bits() {
        return "the same".to_owned();
    }
    match after / before {
        ratio if !ratio.is_finite() => "more".to_owned(),
        ratio if ratio >= 9.95 => format!("{ratio:.0} times"),
        ratio if ratio >= TIMES => format!("{ratio:.1} times"),
        ratio => format!("{:+.1} %", 100.0 * (ratio - 1.0)),
    }
}

fn table(caption: &str, quantities: &[ComparedQuantity], a: &Side, b: &Side) -> Table {
    let head: Vec<String> = std::iter::once("joint".to_owned())
        .chain(quantities.iter().flat_map(|(name, ..)| [format!("A {name}"), format!("B {name}"), "change".to_owned()]))
        .collect();
    let mut table = Table::new(caption, &head);
    for (index, joint) in a.joints().iter().enumerate() {
        let mut row = vec![Cell::from(a.name(index))];
        for (_, list, unit) in quantities {
            let unit = joint[*unit].as_str().unwrap_or(unit);
            let values = [a, b].map(|side| (side, side.number(list, index)));
            row.extend(values.map(|(side, value)| match value {
                Some(x) => Cell::number(engineering(x, unit), x),
                None => missing(side, list, index).into(),
            }));
            row.push(match values {
                [(_, Some(before)), (_, Some(after))] => change(before, after).into(),
                _ => "".into(),
            });
        }
        table.row(row);
    }
    table
}

/// Reason why a number is missing.
fn missing(side: &Side, list: &str, joint: usize) -> &'static str {
    match list {
        SETTLING_TIME if side.number(REST_ERROR, joint).is_some() => "unsettled",
        SETTLING_TIME | REST_ERROR => "no rest",
        _ => "none",
    }
}

/// Numbers of ticks in which limits acted.
fn limits(a: &Side, b: &Side) -> Table {
    let mut table = Table::new("Ticks in which a limit acted", &["joint", "in A", "in B"]);
    for joint in 0..a.joints().len() {
        let cells = [a, b].map(|side| {
            let all = side.summary["limits"].get(joint).and_then(Value::as_object);
            let counts = all.into_iter().flatten().filter_map(|(name, count)| Some((name, count.as_u64()?)));
            let acted = counts.filter(|(_, count)| *count > 0);
            let words: Vec<String> = acted.map(|(name, count)| format!("{} {count}", name.replace('_', " "))).collect();
            let warns = !words.is_empty();
            Cell::from(if warns { words.join(", ") } else { "none".to_owned() }).warning(warns)
        });
        table.row(std::iter::once(a.name(joint).into()).chain(cells).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::change;

    #[test]
    fn a_large_change_reads_as_times_and_a_small_one_in_percent() {
        assert_eq!(change(1.0, 60.455), "60 times");
        assert_eq!(change(-1.0, 3.44), "3.4 times");
        assert_eq!(change(1.0, 1.5), "+50.0 %");
        assert_eq!(change(2.0, 1.0), "-50.0 %");
        assert_eq!(change(2.0, -2.0), "the same");
        assert_eq!(change(0.0, 1.0), "more");
    }
}
