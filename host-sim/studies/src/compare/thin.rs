//! Reduction of two runs to the size of about one and a half: fewer rows, with all peaks kept.

use report::column::{decode, encode};
use serde_json::{Map, Value, json};

/// Largest size of both runs' data, bytes.
const ROOM: usize = 1_250_000;
/// Largest number of rows that become one; more would leave no useful column.
const STRIDE_MAX: usize = 100;
/// Columns of which the lowest and highest values are kept.
const WITH_EXTREMES: [&str; 3] = ["error", "torque", "external"];
/// Columns that are drawn only for the first run.
const OF_FIRST: [&str; 6] = ["inertia", "rotor", "coriolis", "gravity", "friction", "contact"];

/// Both runs, with the letters A and B, and the number of rows that became one.
pub(super) fn both(a: &Value, b: &Value) -> ([Value; 2], usize) {
    let mut second = b.clone();
    second["letter"] = json!("B");
    second["terms"] = json!(false);
    if let Some(columns) = second["columns"].as_object_mut() {
        columns.retain(|name, _| !OF_FIRST.contains(&name.as_str()));
    }
    let first = a.clone();
    let size = |runs: &[Value; 2]| runs.iter().map(|run| run.to_string().len()).sum::<usize>();
    let whole = [first, second];
    let mut stride = 1;
    let mut runs = whole.clone();
    // Extremes need additional space, so the stride is found by trying.
    while size(&runs) > ROOM && stride < STRIDE_MAX {
        stride += 1;
        runs = whole.each_ref().map(|run| thinned(run, stride));
    }
    (runs, stride)
}

fn thinned(run: &Value, stride: usize) -> Value {
    let mut run = run.clone();
    run["stride"] = json!(run["stride"].as_u64().unwrap_or(1) * stride as u64);
    if let Some(columns) = run["columns"].as_object_mut() {
        for (name, joints) in columns.iter_mut() {
            for column in joints.as_array_mut().into_iter().flatten() {
                *column = fewer(column, stride, WITH_EXTREMES.contains(&name.as_str()));
            }
        }
    }
    for axis in run["tip_estimate"].as_array_mut().into_iter().flatten() {
        *axis = json!(encode(values(axis).into_iter().step_by(stride)));
    }
    run
}

fn values(text: &Value) -> Vec<f64> {
    decode(text.as_str().unwrap_or_default()).unwrap_or_default()
}

fn fewer(column: &Value, stride: usize, extremes: bool) -> Value {
    let at = values(&column["at"]);
    let mut made = Map::new();
    for (part, pick) in [("low", f64::min as fn(f64, f64) -> f64), ("high", f64::max)] {
        if extremes {
            let all = column.get(part).map_or_else(|| at.clone(), values);
            let of = |chunk: &[f64]| chunk.iter().copied().fold(f64::NAN, pick);
            made.insert(part.to_owned(), json!(encode(all.chunks(stride).map(of))));
        }
    }
    made.insert("at".to_owned(), json!(encode(at.into_iter().step_by(stride))));
    Value::Object(made)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::{both, values};
    use report::column::encode;
    use serde_json::{Value, json};

    fn run(rows: usize, peak: usize) -> Value {
        let column = |value: f64| json!({ "at": encode((0..rows).map(|row| if row == peak { value } else { 0.0 })) });
        json!({ "letter": "A", "stride": 2, "terms": true, "columns": { "q": [column(1.0)], "torque": [column(7.0)], "inertia": [column(1.0)] } })
    }

    #[test]
    fn two_runs_fit_and_keep_their_peaks() {
        let (small, stride) = both(&run(100, 3), &run(100, 3));
        assert_eq!((stride, &small[1]["letter"]), (1, &json!("B")));
        assert!(small[1]["columns"].get("inertia").is_none() && small[0]["columns"].get("inertia").is_some());
        let (large, stride) = both(&run(100_000, 54_321), &run(100_000, 3));
        assert!(stride > 1 && large[0].to_string().len() + large[1].to_string().len() < 1_250_000, "{stride}");
        assert_eq!(large[0]["stride"], json!(2 * stride));
        let high = values(&large[0]["columns"]["torque"][0]["high"]);
        assert_eq!(high.iter().position(|x| *x > 6.9), Some(54_321 / stride));
    }
}
