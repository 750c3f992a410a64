//! Two runs on one page, in a real browser.

use crate::browser::{Browser, WEBGL};
use crate::pages::WINDOWS;
use crate::program::{at_the_top, told};
use crate::report_page::{BYTES_MAX, READY, run, scene, write};
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use serde_json::json;
use sim::run::numbers::engineering;
use sim::run::report::page;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::compare::{self, Side};

/// A folder with the report of a run, changed by `change`.
fn folder(name: &str, scene: &str, change: fn(&mut SceneFile)) -> (PathBuf, Run) {
    let mut scene = self::scene(scene);
    change(&mut scene);
    let run = run(&scene);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("report.html"), page(&run, &scene).unwrap().html()).unwrap();
    (folder, run)
}

#[test]
fn two_runs_are_compared_from_their_reports_alone() {
    let (a, of_a) = folder("compare_a", "puma560_pick.toml", |_| {});
    let (b, of_b) = folder("compare_b", "puma560_pick.toml", |scene| {
        scene.control.law = dynamics_core::control::ControlLaw::PdGravity
    });
    let html = compare::page(&Side::load(&a).unwrap(), &Side::load(&b.join("report.html")).unwrap()).unwrap().html();
    assert!(html.len() < BYTES_MAX, "{}", html.len());
    let change = of_b.summary.tracking_max[1] / of_a.summary.tracking_max[1];
    assert!(change > 2.0 && html.contains(" times</td>"), "{change}");
    assert!(html.contains("Neither faulted.") && html.contains("1 to 6 choose a joint"));
    assert!(html.contains("<dt>period</dt><dd>1.00 ms</dd>") && html.contains("<dt>duration</dt><dd>2.10 s</dd>"));

    let Some(mut browser) = Browser::start("compare", WEBGL) else { return };
    for (width, height) in WINDOWS {
        browser.open(&write("compare", &html), width, height);
        browser.until(READY);
        assert!(browser.beyond() <= 0.0);
        browser.press("End");
        let apart = browser.value("Math.hypot(...tipOfRun(0).map((x, k) => x - tipOfRun(1)[k]))").as_f64().unwrap();
        assert!((1e-4..0.1).contains(&apart), "the arm with another law stands elsewhere: {apart} m");
        let names = browser.value("document.querySelector('.chart .values').textContent").to_string();
        assert!(names.contains("A actual") && names.contains("B actual"), "{names}");
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_run_that_faulted_or_ended_before_the_other_says_so_and_shows_nothing_from_then_on() {
    let (a, _) = folder("compare_long", "puma560_pick.toml", |_| {});
    let (b, of_b) = folder("compare_short", "puma560_collision.toml", |scene| scene.duration = Some(1.0));
    let page = compare::page(&Side::load(&a).unwrap(), &Side::load(&b).unwrap()).unwrap();
    let fault = &of_b.summary.faults[0];
    let at = engineering(fault.tick as f64 * of_b.summary.setting.period, "s");
    assert!(page.lead.contains(&format!("B faulted at {at}: {}. Its numbers are those before.", fault.message)));
    assert!(page.lead.iter().any(|line| line.starts_with("A lasts 2.10 s, B 1.00 s:")), "{:?}", page.lead);
    let html = page.html();
    for expected in
        [">A, ".to_owned(), format!(">B, {at}: {}", fault.message), "B given".to_owned(), "B settles in".to_owned()]
    {
        assert!(html.contains(&expected), "{expected}");
    }

    let Some(mut browser) = Browser::start("ends", WEBGL) else { return };
    browser.open(&write("ends", &html), 1280, 800);
    browser.until(READY);
    let mut shown = |key: &str| {
        browser.press(key);
        let said = "[...document.querySelectorAll('.chart .values')].slice(0, 2).map((one) => one.textContent).concat(\
                    [...document.querySelectorAll('.readout tr')].slice(1, 3).map((row) => row.textContent)).join('|')";
        let opacity = browser.value("[0, 1].map((index) => drawingOf(index).opacity)");
        (browser.value(said).to_string().matches('\u{2013}').count(), opacity)
    };
    assert_eq!(shown("Home"), (0, json!([1, 0.4])));
    // The position and the error of run B, and its row.
    assert_eq!(shown("End"), (6, json!([1, 0.1])));
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn what_is_no_report_of_a_run_is_not_compared() {
    let (a, _) = folder("compare_bad", "puma560_pick.toml", |scene| scene.duration = Some(0.01));
    let (run, planar) = {
        let scene = scene("planar2r_swing.toml");
        (simulation::run(&scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap(), scene)
    };
    let other = write("compare_planar", &page(&run, &planar).unwrap().html());
    let text = write("compare_text", "<!doctype html><p>a page");
    let missing = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compare_missing.html");
    for (b, expected) in
        [(&missing, "there is no such file"), (&text, "no data of one run in it"), (&other, "has 6 joints")]
    {
        let output = at_the_top().arg("report").args([&a, b]).output().unwrap();
        let (code, out, error) = told(output);
        assert_eq!((code, out.as_str()), (2, ""), "{error}");
        assert!(error.contains(expected) && error.contains("expected"), "{error}");
    }
}
