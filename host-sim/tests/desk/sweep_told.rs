//! Results of a study: units, confidence intervals, how runs ended, the study's definition, and how to repeat a run.

use crate::sweep::{cells, folder};
use dynamics_core::JointKind::{Prismatic, Revolute};
use robot_compiler::study::{Figure, Metric};
use std::fs;
use std::path::{Path, PathBuf};
use studies::sweep::Prepared;
use studies::sweep::results::Results;

pub(crate) fn prepared(study: &str, runs: u64) -> Prepared {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    Prepared::load(&top.join(study), Some(runs)).unwrap()
}

/// A folder with these rows as the runs of a study, and their results.
pub(crate) fn of_rows(name: &str, prepared: &Prepared, rows: &[String]) -> (PathBuf, Results) {
    let out = folder(name);
    fs::write(out.join("runs.csv"), format!("{}\n{}\n", prepared.columns().join(","), rows.join("\n"))).unwrap();
    let results = Results::of(prepared, &out).unwrap();
    results.write(&out, prepared).unwrap();
    (out, results)
}

/// Ten runs of two rods. Those with the law `pd` stop at a fault with almost no error.
pub(crate) fn rods() -> Vec<String> {
    let row = |index: u32| {
        let (law, error, end) =
            if index < 4 { ("pd", 1e-6, "fault 5") } else { ("feedforward", f64::from(index) * 1e-4, "complete") };
        let pass = u8::from(end == "complete" && error <= 0.0003);
        format!("{index},1.0,1.0,{law},0,{error:?},{index}.5,inf,{end},{pass}")
    };
    let pd = "10,1.0,1.0,pd,0,0.0002,3.5,inf,complete,1".to_owned();
    (0..10).map(row).chain([pd]).collect()
}

#[test]
fn a_median_is_of_complete_runs_and_those_in_a_fault_have_a_row_of_their_own() {
    let prepared = prepared("host-sim/tests/fixtures/study.toml", 11);
    let (out, results) = of_rows("told_faults", &prepared, &rods());
    let by_law = results.groups.iter().find(|group| group.keys == ["control.law"]).unwrap();
    let pd = by_law.cells.iter().find(|cell| cell.values == ["pd"]).unwrap();
    assert_eq!((pd.failures.count, pd.failures.of, pd.medians[0]), (4, 5, Some(0.0002)));
    assert_eq!((results.broken_off.share.count, results.broken_off.first.as_slice()), (4, [0, 1, 2, 3].as_slice()));
    let text = fs::read_to_string(out.join("results.md")).unwrap();
    assert!(text.contains("11 runs (complete: 7 runs, fault 5: 4 runs); failed: 10 of 11 ("), "{text}");
    assert!(text.contains("| end | in a fault, or diverged | 4 of 11 ("), "{text}");
    assert!(text.contains("Median tracking_max / rad of the complete runs:"), "{text}");
}

#[test]
fn every_figure_has_its_unit_and_every_interval_its_confidence() {
    let prepared = prepared("host-sim/tests/fixtures/study.toml", 11);
    let (out, results) = of_rows("told_units", &prepared, &rods());
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let terminal = results.text(&out.join("study.toml"));
    for text in [&page, &terminal, &results.markdown()] {
        for words in ["tracking_max / rad", "torque_peak.1 / (N m)", "settling_time / s", "%), with 95 % confidence."] {
            assert!(text.contains(words), "no {words} in {text}");
        }
        assert!(text.matches("95 % interval").count() >= 2, "{text}");
    }
    let head = &cells(&out.join("runs.csv"))[0];
    assert_eq!(head[5..8], ["tracking_max", "torque_peak.1", "settling_time"], "tables keep their titles");
    let unit = |figure, joint| {
        let metric = Metric { figure, joint, limit: None, least: None, title: String::new() };
        metric.unit(&[Prismatic, Revolute])
    };
    assert_eq!((unit(Figure::Drift, None), unit(Figure::Drift, Some(1))), ("rad or m".to_owned(), "m".to_owned()));
    assert_eq!((unit(Figure::TorqueRms, None), unit(Figure::SpeedMax, Some(2))), ("N m or N".into(), "rad/s".into()));
    assert_eq!((unit(Figure::SettlingTime, None), unit(Figure::Faults, None)), ("s".into(), String::new()));
}

#[test]
fn a_page_says_what_the_study_was_and_hands_over_commands_that_a_shell_takes() {
    let prepared = prepared("host-sim/tests/fixtures/study.toml", 11);
    let (out, _) = of_rows("told with blanks", &prepared, &rods());
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let version = format!("<dt>host-sim</dt><dd>{}</dd>", env!("CARGO_PKG_VERSION"));
    for fact in [
        "<dt>scene</dt><dd>planar2r_sine (",
        "<dt>set</dt><dd>duration = 0.01</dd>",
        "<dt>varied</dt><dd>plant.masses.2: 0.5 to 2</dd>",
        "within 0.5 to 1.5, times the file&#39;s own value</dd>",
        "<dt>design</dt><dd>random, seed 7</dd>",
        "<dt>runs</dt><dd>11</dd>",
        &version,
    ] {
        assert!(page.contains(fact), "no {fact}");
    }
    // Only the first figure has a limit, and the limit is within the range of the runs. The style sheet also contains dashes, for lines.
    let limits = |drawing: &str| drawing.split_once("</svg>").unwrap().0.matches("stroke-dasharray").count();
    let drawn: Vec<usize> = page.split("<svg").skip(1).map(limits).collect();
    assert_eq!(drawn, [1, 0, 0], "histograms of two figures, and correlations");
    assert_eq!(page.matches("stroke-dasharray=\"").count(), 1);
    assert_eq!(page.matches(">fails above 0.000300<").count(), 1, "in the legend");
    let stops = page.matches("tabindex=\"0\"").count() - page.matches("<div class=\"table\" tabindex=\"0\"").count();
    assert_eq!(stops, page.matches("data-command=\"").count(), "a stop of the keyboard without a command");
    let study = out.join("study.toml").display().to_string();
    let command = format!("data-command=\"newtau sweep &#39;{study}&#39; --replay 9 --out out/run_9\"");
    assert!(page.contains(&command), "no {command}");
    // Five worst runs of each figure, and ten that failed.
    assert_eq!(page.matches("data-command=\"").count(), 25);
}
