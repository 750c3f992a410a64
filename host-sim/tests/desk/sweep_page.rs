//! A study's page in a real browser: the numbers of its files.
#![allow(clippy::float_cmp, reason = "a page shows the very numbers")]

use crate::browser::{Browser, FLAT};
use crate::pages::{WINDOWS, open, rows};
use crate::sweep::{cells, folder};
use host_sim::study::parallel::Jobs;
use host_sim::study::sweep::Prepared;
use host_sim::study::sweep::results::Results;
use host_sim::study::sweep::store::{self, Progress, STUDY, Shard};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Title of the table of worst runs.
pub(crate) const WORST: &str = "The worst runs, and the command that repeats each in full";

pub(crate) fn fixture() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/study.toml")
}

/// Folder of a study after so many runs, with its results, and those as JSON.
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

/// Demands that a text has these numbers with three digits, and `never` for each that is missing.
fn says(text: &str, values: &[Value]) {
    let (found, expected) = (numbers(text), values.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
    let near = |(shown, exact): (&f64, &f64)| (shown - exact).abs() <= 0.005 * exact.abs();
    assert!(found.len() == expected.len() && found.iter().zip(&expected).all(near), "{text}: {values:?}");
    assert_eq!(text.matches("never").count(), values.len() - expected.len(), "{text}: {values:?}");
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
        shows_the_distributions(&mut browser, &results);
        shows_the_correlations(&mut browser, &results);
        shows_the_worst_runs(&mut browser, &results, &table, &out);
        draws_the_histograms(&mut browser, &results);
        draws_the_correlations(&mut browser, &results);
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

fn shows_the_distributions(browser: &mut Browser, results: &Value) {
    let metrics = list(&results["metrics"]);
    let shown = rows(browser, "Figures");
    assert_eq!((shown.len(), metrics.len()), (3, 3));
    for (row, metric) in shown.iter().zip(metrics) {
        assert_eq!(row[0].0, metric["metric"].as_str().unwrap());
        let limited = metric["limit"].is_number();
        says(&row[1].0, if limited { std::slice::from_ref(&metric["limit"]) } else { &[] });
        let failures = share(&metric["failures"]);
        says(&row[2].0, if limited { &failures } else { &[] });
        let at = |share: &str| metric["quantiles"][share].clone();
        says(&row[3].0, &[at("p50")]);
        says(&row[4].0, &[at("p05"), at("p95")]);
        says(&row[5].0, &[at("p99")]);
        let never = metric["infinite"].as_u64().unwrap() > 0;
        says(&row[6].0, &[if never { Value::Null } else { metric["max"].clone() }]);
        let worst: Vec<String> = list(&metric["worst"]).iter().map(|run| run["index"].to_string()).collect();
        assert_eq!(row[7].0, worst.join(", "));
    }
}

/// The correlation of a figure with a key.
fn correlation<'a>(results: &'a Value, metric: &str, key: &str) -> &'a Value {
    let list = list(&results["sensitivities"]);
    &list.iter().find(|found| found["metric"] == metric && found["key"] == key).unwrap()["correlation"]
}

/// Demands two digits behind the point.
fn rounded(shown: &[f64], found: &Value) {
    for (shown, key) in shown.iter().zip(["value", "low", "high"]) {
        assert!((shown - found[key].as_f64().unwrap()).abs() < 0.005_001, "{shown}: {found}");
    }
}

fn shows_the_correlations(browser: &mut Browser, results: &Value) {
    let title = "Rank correlation of figures with keys, and the share of a figure's variance that a key explains alone";
    let keys = ["plant.masses.2", "robot.joint.1.mass", "actuators.delay"];
    for row in rows(browser, title) {
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
        assert_eq!((row[0].0.as_str(), row[1].0.as_str()), (table[0][5 + metric].as_str(), index.to_string().as_str()));
        assert_eq!(row[2].1, worst["figure"].as_f64());
        assert_eq!(row[2].1, Some(of_table).filter(|x| x.is_finite()));
        says(&row[2].0, std::slice::from_ref(&worst["figure"]));
        let study = out.join(STUDY);
        let command = format!("host-sim sweep {} --replay {index} --out out/run_{index}", study.display());
        assert_eq!(row[3].0, command);
    }
}

/// What the points or bars of a figure say when they are reached, with numbers of the shape drawn for each.
fn reached(browser: &mut Browser, caption: &str, shape: &str) -> Vec<(String, f64)> {
    let found = browser.value(&format!(
        "[...[...document.querySelectorAll('figure')].find((figure) => figure.querySelector('figcaption').textContent === {}) \
         .querySelectorAll('.point')].map((point) => {{ point.focus(); const now = document.activeElement; \
         return [now.querySelector('title').textContent, Number(now.lastChild.getAttribute('{shape}'))]; }})",
        json!(caption)
    ));
    list(&found).iter().map(|point| (point[0].as_str().unwrap().to_owned(), point[1].as_f64().unwrap())).collect()
}

fn draws_the_histograms(browser: &mut Browser, results: &Value) {
    for metric in list(&results["metrics"]).iter().filter(|metric| metric["finite"].as_u64().unwrap() > 0) {
        let histogram = &metric["histogram"];
        let counts: Vec<f64> = list(&histogram["counts"]).iter().map(|count| count.as_f64().unwrap()).collect();
        assert_eq!(counts.iter().sum::<f64>(), metric["finite"].as_f64().unwrap());
        let [low, high] = ["low", "high"].map(|end| histogram[end].as_f64().unwrap());
        let points = reached(browser, &format!("Runs by {}", metric["metric"].as_str().unwrap()), "cy");
        assert_eq!(points.len(), counts.len());
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

fn draws_the_correlations(browser: &mut Browser, results: &Value) {
    let bars = reached(browser, "Rank correlation of figures with keys", "height");
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
