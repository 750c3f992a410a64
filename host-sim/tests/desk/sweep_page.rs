//! A study's page in a real browser: it shows the numbers of the study's files.
#![allow(clippy::float_cmp, reason = "a page shows the very numbers")]

use crate::browser::{Browser, FLAT};
use crate::pages::{WINDOWS, handed_over, open, rows};
use crate::sweep::{cells, folder};
use serde_json::{Value, json};
use sim::parallel::Jobs;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::sweep::Prepared;
use studies::sweep::results::Results;
use studies::sweep::store::{self, Progress, STUDY, Shard};

/// Title of the table of worst runs, and title of the table of failed runs.
pub(crate) const WORST: &str = "The worst runs, and the command that repeats each in full";
pub(crate) const FAILING: &str = "The first runs that failed, and the command that repeats each in full";
/// The fixture's metrics as a page names them.
pub(crate) const LABELS: [&str; 3] = ["tracking_max / rad", "torque_peak.1 / (N m)", "settling_time / s"];

pub(crate) fn fixture() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/study.toml")
}

/// Runs a study with this many runs. Returns its folder, and its results as JSON.
pub(crate) fn studied(name: &str, study: &Path, runs: u64) -> (PathBuf, Value) {
    let out = folder(name);
    let prepared = Prepared::load(study, Some(runs)).unwrap();
    let (jobs, stop) = (Jobs::new(Some(1)).unwrap(), AtomicBool::new(false));
    let progress = Progress { shard: Shard::WHOLE, jobs: &jobs, stop: &stop, after_block: &|_| {} };
    store::write(&prepared, &out, &progress).unwrap();
    Results::of(&prepared, &out).unwrap().write(&out, &prepared).unwrap();
    let json = serde_json::from_str(&fs::read_to_string(out.join("results.json")).unwrap()).unwrap();
    (out, json)
}

pub(crate) fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

/// Numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    let of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e');
    text.split(|c| !of_number(c)).filter_map(|word| word.parse().ok()).collect()
}

/// Asserts that a text contains these numbers with three digits, and `unsettled` for each missing one.
fn says(text: &str, values: &[Value]) {
    let (found, expected) = (numbers(text), values.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
    let near = |(shown, exact): (&f64, &f64)| (shown - exact).abs() <= 0.005 * exact.abs();
    assert!(found.len() == expected.len() && found.iter().zip(&expected).all(near), "{text}: {values:?}");
    assert_eq!(text.matches("unsettled").count(), values.len() - expected.len(), "{text}: {values:?}");
}

/// Numbers of a share with its interval in percent.
fn share(share: &Value) -> [Value; 4] {
    let percent = |key: &str| json!(100.0 * share[key].as_f64().unwrap());
    [share["count"].clone(), share["of"].clone(), percent("low"), percent("high")]
}

#[test]
fn a_studys_page_shows_the_numbers_of_its_files_on_a_desk_and_on_a_phone() {
    let Some(mut browser) = Browser::start("sweep", FLAT) else { return };
    let (out, results) = studied("page", &fixture(), 40);
    let table = cells(&out.join("runs.csv"));
    assert_eq!(results["runs"], table.len() - 1);
    for window in WINDOWS {
        open(&mut browser, &out.join("report.html"), window);
        let lead = browser.value("document.querySelector('.lead').textContent");
        let (runs, failed) = lead.as_str().unwrap().split_once("; failed: ").unwrap();
        says(runs, &[results["runs"].clone(), results["ends"]["complete"].clone()]);
        says(failed.split_once(" %)").unwrap().0, &share(&results["failures"]));
        shows_the_distributions(&mut browser, &results, &table);
        shows_the_correlations(&mut browser, &results);
        shows_the_worst_runs(&mut browser, &results, &table, &out);
        shows_the_failing_runs(&mut browser, &results, &table, &out);
        draws_the_histograms(&mut browser, &results);
        draws_the_correlations(&mut browser, &results);
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

pub(crate) fn shows_the_distributions(browser: &mut Browser, results: &Value, table: &[Vec<String>]) {
    let metrics = list(&results["metrics"]);
    let mut shown = rows(browser, "Figures");
    shows_what_broke_off(&shown.pop().unwrap(), results, table);
    assert_eq!((shown.len(), metrics.len()), (3, 3));
    for ((row, metric), label) in shown.iter().zip(metrics).zip(LABELS) {
        assert_eq!(
            (row[0].0.as_str(), label.split_once(" / ").unwrap().0),
            (label, metric["metric"].as_str().unwrap())
        );
        let limited = metric["limit"].is_number();
        says(&row[1].0, if limited { std::slice::from_ref(&metric["limit"]) } else { &[] });
        let failures = share(&metric["failures"]);
        says(&row[2].0, if limited { &failures } else { &[] });
        let at = |share: &str| metric["quantiles"][share].clone();
        says(&row[3].0, &[at("p50")]);
        says(&row[4].0, &[at("p05"), at("p95")]);
        says(&row[5].0, &[at("p99")]);
        let unsettled = metric["infinite"].as_u64().unwrap() > 0;
        says(&row[6].0, &[if unsettled { Value::Null } else { metric["max"].clone() }]);
        let worst: Vec<String> = list(&metric["worst"]).iter().map(|run| run["index"].to_string()).collect();
        assert_eq!(row[7].0, worst.join(", "));
    }
}

/// Checks the row of incomplete runs against `results.json` and the table of runs.
fn shows_what_broke_off(row: &[(String, Option<f64>)], results: &Value, table: &[Vec<String>]) {
    let end = table[0].iter().position(|name| name == "end").unwrap();
    let broken_off: Vec<&str> =
        table[1..].iter().filter(|row| row[end] != "complete").map(|row| row[0].as_str()).collect();
    let found = &results["broken_off"];
    assert_eq!((&found["share"]["count"], &found["share"]["of"]), (&json!(broken_off.len()), &results["runs"]));
    let first = &broken_off[..broken_off.len().min(5)];
    assert_eq!(list(&found["first"]).iter().map(Value::to_string).collect::<Vec<_>>(), first);
    let texts: Vec<&str> = row.iter().map(|cell| cell.0.as_str()).collect();
    let first = if first.is_empty() { "-".to_owned() } else { first.join(", ") };
    assert_eq!(texts[..2], ["end", "in a fault, or diverged"]);
    assert_eq!(texts[3..], ["-", "-", "-", "-", &first]);
    says(texts[2], &share(&found["share"]));
}

/// The correlation of a metric with a key.
fn correlation<'a>(results: &'a Value, metric: &str, key: &str) -> &'a Value {
    let list = list(&results["sensitivities"]);
    &list.iter().find(|found| found["metric"] == metric && found["key"] == key).unwrap()["correlation"]
}

/// Asserts two digits after the decimal point.
fn rounded(shown: &[f64], found: &Value) {
    for (shown, key) in shown.iter().zip(["value", "low", "high"]) {
        assert!((shown - found[key].as_f64().unwrap()).abs() < 0.005_001, "{shown}: {found}");
    }
}

fn shows_the_correlations(browser: &mut Browser, results: &Value) {
    let title = "Rank correlation of figures with keys (95 % interval), and the share of a figure's variance that a key explains alone";
    let keys = ["plant.masses.2", "robot.joint.1.mass", "actuators.delay"];
    let shown = rows(browser, title);
    assert_eq!(shown.len(), 3);
    for row in shown {
        assert_eq!(row.len(), 1 + keys.len());
        for ((shown, _), key) in row[1..].iter().zip(keys) {
            let found = correlation(results, &row[0].0, key);
            let shown = numbers(shown);
            assert_eq!(shown.len(), if found.is_null() { 0 } else { 4 }, "{shown:?}: {found}");
            if !found.is_null() {
                rounded(&shown, found);
                assert!((shown[3] - 100.0 * found["share"].as_f64().unwrap()).abs() < 0.501, "{shown:?}: {found}");
            }
        }
    }
}

fn shows_the_worst_runs(browser: &mut Browser, results: &Value, table: &[Vec<String>], out: &Path) {
    let shown = rows(browser, WORST);
    let of_metric = |metric| list(&results["metrics"][metric]["worst"]).iter().map(move |worst| (metric, worst));
    let expected: Vec<_> = (0..3).flat_map(of_metric).collect();
    assert_eq!(shown.len(), expected.len());
    for (row, (metric, worst)) in shown.iter().zip(expected) {
        let index = worst["index"].as_u64().unwrap();
        let of_table = table[1 + usize::try_from(index).unwrap()][5 + metric].parse::<f64>().unwrap();
        assert_eq!(table[0][5 + metric], results["metrics"][metric]["metric"].as_str().unwrap());
        assert_eq!((row[0].0.as_str(), row[1].0.as_str()), (LABELS[metric], index.to_string().as_str()));
        assert_eq!(row[2].1, worst["figure"].as_f64());
        assert_eq!(row[2].1, Some(of_table).filter(|x| x.is_finite()));
        says(&row[2].0, std::slice::from_ref(&worst["figure"]));
        assert_eq!(row[3].0, command(out, index));
    }
    assert_eq!(handed_over(browser, WORST), shown.iter().map(|row| row[3].0.clone()).collect::<Vec<_>>());
}

fn command(out: &Path, index: u64) -> String {
    format!("newtau sweep {} --replay {index} --out out/run_{index}", out.join(STUDY).display())
}

fn shows_the_failing_runs(browser: &mut Browser, results: &Value, table: &[Vec<String>], out: &Path) {
    let failed = table[1..].iter().filter(|row| row.last().unwrap() == "0").map(|row| row[0].parse().unwrap());
    let failed: Vec<u64> = failed.take(10).collect();
    assert_eq!(results["failing"], json!(failed));
    let shown: Vec<Vec<String>> =
        rows(browser, FAILING).into_iter().map(|row| row.into_iter().map(|cell| cell.0).collect()).collect();
    assert_eq!(shown, failed.iter().map(|index| vec![index.to_string(), command(out, *index)]).collect::<Vec<_>>());
    assert_eq!(handed_over(browser, FAILING), failed.iter().map(|index| command(out, *index)).collect::<Vec<_>>());
}

/// Expression for the figure with this caption.
fn figure(caption: &str) -> String {
    format!(
        "[...document.querySelectorAll('figure')].find((figure) => figure.querySelector('figcaption').textContent === {})",
        json!(caption)
    )
}

/// Texts of the points or bars of a figure, with numbers of their drawn shapes. Asserts that none of them has a command, can be reached with the
/// keyboard, or looks clickable.
fn said(browser: &mut Browser, caption: &str, shape: &str) -> Vec<(String, f64)> {
    let figure = figure(caption);
    let pressed =
        "part.tabIndex >= 0 || part.dataset.command !== undefined || getComputedStyle(part).cursor === 'pointer'";
    let pressed = format!("[...{figure}.querySelectorAll('svg *')].filter((part) => {pressed}).length");
    assert_eq!(browser.value(&pressed), 0, "{caption}");
    let found = browser.value(&format!(
        "[...{figure}.querySelectorAll('.point')].map((point) => \
         [point.querySelector('title').textContent, Number(point.lastChild.getAttribute('{shape}')), point.ariaLabel])"
    ));
    let point = |point: &Value| {
        assert_eq!(point[0], point[2], "a reader hears what a pointer finds");
        (point[0].as_str().unwrap().to_owned(), point[1].as_f64().unwrap())
    };
    list(&found).iter().map(point).collect()
}

fn draws_the_histograms(browser: &mut Browser, results: &Value) {
    for metric in list(&results["metrics"]).iter().filter(|metric| metric["finite"].as_u64().unwrap() > 0) {
        let histogram = &metric["histogram"];
        let counts: Vec<f64> = list(&histogram["counts"]).iter().map(|count| count.as_f64().unwrap()).collect();
        assert_eq!(counts.iter().sum::<f64>(), metric["finite"].as_f64().unwrap());
        let [low, high] = ["low", "high"].map(|end| histogram[end].as_f64().unwrap());
        let caption = format!("Runs by {}", metric["metric"].as_str().unwrap());
        let points = said(browser, &caption, "cy");
        assert_eq!(points.len(), counts.len());
        let label = LABELS.iter().find(|label| label.starts_with(metric["metric"].as_str().unwrap())).unwrap();
        lists_its_points(browser, &caption, &points, label);
        draws_its_limit(browser, &caption, metric);
        let most = counts.iter().copied().fold(0.0, f64::max);
        let height_of = |sought: f64| points[counts.iter().position(|count| *count == sought).unwrap()].1;
        let (foot, top) = (height_of(0.0), height_of(most));
        for (place, ((said, height), count)) in points.iter().zip(&counts).enumerate() {
            let end = |place: usize| json!(low + (high - low) * place as f64 / counts.len() as f64);
            says(said, &[end(place), end(place + 1), json!(count)]);
            assert!((foot - height - (foot - top) * count / most).abs() < 0.11, "{said} at {height}");
        }
    }
}

/// Checks that a figure repeats its points as text in a list, for users without a pointer.
fn lists_its_points(browser: &mut Browser, caption: &str, points: &[(String, f64)], label: &str) {
    let lines =
        browser.value(&format!("[...{}.querySelectorAll('li')].map((line) => line.textContent)", figure(caption)));
    assert_eq!(list(&lines).len(), points.len());
    for (line, (said, _)) in list(&lines).iter().zip(points) {
        assert!(line.as_str().unwrap().starts_with(&format!("{said}: {label} ")), "{line}: {said}");
    }
}

/// Checks that the limit is the only dashed line of a histogram, at the right position. A figure without a limit has none.
fn draws_its_limit(browser: &mut Browser, caption: &str, metric: &Value) {
    let figure = figure(caption);
    let dashed = browser.value(&format!(
        "[...{figure}.querySelectorAll('path.line')].filter((line) => line.hasAttribute('stroke-dasharray')) \
         .map((line) => line.getAttribute('d'))"
    ));
    let names = browser.value(&format!(
        "[...{figure}.querySelectorAll('.legend span')].map((name) => [name.textContent, name.className.split(' ').pop()])"
    ));
    let quantiles: Vec<_> = list(&names).iter().filter(|name| name[1] == "quantile" || name[1] == "median").collect();
    let expected = [("p05", Some(5)), ("p50", None), ("p95", Some(95))];
    let expected: Vec<_> = expected.into_iter().filter(|(key, _)| !metric["quantiles"][key].is_null()).collect();
    assert_eq!(quantiles.len(), expected.len(), "{names}");
    for (name, (key, percent)) in quantiles.iter().zip(expected) {
        let values: Vec<_> = percent.map(|x| json!(x)).into_iter().chain([metric["quantiles"][key].clone()]).collect();
        says(name[0].as_str().unwrap(), &values);
    }
    let names = list(&names).iter().filter(|name| name[1] != "quantile" && name[1] != "median");
    let names = json!(names.map(|name| name[0].clone()).skip(1).collect::<Vec<_>>());
    let Some(limit) = metric["limit"].as_f64() else {
        assert_eq!((dashed, names), (json!([]), json!([])), "{caption}");
        return;
    };
    assert_eq!((list(&dashed).len(), list(&names).len()), (1, 1), "{caption}: {dashed} {names}");
    says(list(&names)[0].as_str().unwrap(), std::slice::from_ref(&metric["limit"]));
    let places = said(browser, caption, "cx");
    let [low, high] = ["low", "high"].map(|end| metric["histogram"][end].as_f64().unwrap());
    // The last point is at the start of the last step.
    let step = (places.last().unwrap().1 - places[0].1) / (places.len() - 1) as f64;
    let expected = places[0].1 + step * places.len() as f64 * (limit - low) / (high - low);
    let ends = list(&dashed)[0].as_str().unwrap().trim_start_matches('M').split('L');
    let at: Vec<f64> = ends.map(|end| end.split_once(' ').unwrap().0.parse().unwrap()).collect();
    assert!(at.len() == 2 && at.iter().all(|at| (at - expected).abs() < 0.31), "{at:?}: {expected}");
}

fn draws_the_correlations(browser: &mut Browser, results: &Value) {
    let bars = said(browser, "Rank correlation of figures with keys", "height");
    let all = list(&results["sensitivities"]);
    assert_eq!(bars.len(), all.iter().filter(|found| !found["correlation"].is_null()).count());
    let mut pixels = Vec::new();
    for (said, height) in bars {
        let (of, said) = said.split_once(": ").unwrap();
        let (metric, key) = of.split_once(" with ").unwrap();
        let found = correlation(results, metric, key);
        rounded(&numbers(said), found);
        pixels.push((height, found["value"].as_f64().unwrap().abs()));
    }
    let (highest, greatest) =
        pixels.iter().copied().fold((0.0, 0.0), |most, bar| if bar.1 > most.1 { bar } else { most });
    assert!(pixels.iter().all(|(height, value)| (height - highest * value / greatest).abs() < 0.11), "{pixels:?}");
}
