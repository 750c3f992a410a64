//! Reports in a real browser: they load, play and scrub, and show the numbers of the run.

use crate::browser::{Browser, FLAT, WEBGL};
use crate::program::{at_the_top, told};
use host_sim::run::report::{SUMMARY, page};
use host_sim::run::simulate::{self, Run};
use host_sim::run::summary::engineering;
use host_sim::study::compare::{self, Side};
use indicatif::ProgressBar;
use report::{Block, Figure, Page, Point, Scale, Series};
use robot_compiler::SceneFile;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Largest page, bytes.
const BYTES_MAX: usize = 2_000_000;

fn scene(name: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)).unwrap()
}

fn run(scene: &SceneFile) -> Run {
    simulate::on_desk::<6>(scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap()
}

fn write(name: &str, html: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.html"));
    std::fs::write(&path, html).unwrap();
    path
}

#[test]
#[allow(clippy::float_cmp, reason = "a page shows the very numbers")]
fn a_report_loads_plays_scrubs_and_shows_the_numbers_of_the_summary_on_a_desk_and_on_a_phone() {
    let Some(mut browser) = Browser::start("plays", WEBGL) else { return };
    let scene = scene("puma560_pick.toml");
    let run = run(&scene);
    let file = write("plays", &page(&run, &scene).unwrap().html());
    for (width, height) in [(1280, 800), (390, 844)] {
        browser.open(&file, width, height);
        browser.until("document.getElementById('viewer').dataset.ready === 'yes'");
        assert_eq!(browser.value("document.getElementById('viewer').dataset.webgl"), "yes", "{width}");
        let wide = browser.beyond();
        assert!(wide <= 0.0, "{wide} pixels wider than {width}");
        plays(&mut browser);
        scrubs(&mut browser, &run);
        draws_the_arm_where_the_plant_has_it(&mut browser, &scene, &run);
        shows_the_summary(&mut browser, &run);
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

fn time(browser: &mut Browser) -> f64 {
    browser.value("Number(document.getElementById('viewer').dataset.time)").as_f64().unwrap()
}

fn plays(browser: &mut Browser) {
    assert!(time(browser) == 0.0);
    browser.press(" ");
    browser.until("Number(document.getElementById('viewer').dataset.time) > 0.1");
    browser.press(" ");
    let stopped = time(browser);
    browser.value("new Promise((done) => setTimeout(done, 150))");
    assert!(stopped > 0.1 && (time(browser) - stopped).abs() < 1e-12, "it stands still when paused");
    browser.press("Home");
    browser.press("ArrowRight");
    assert!((time(browser) - 1e-3).abs() < 1e-12, "an arrow is a tick");
}

fn scrubs(browser: &mut Browser, run: &Run) {
    for tick in [700, 1_234] {
        let at = run.record.time()[tick];
        browser.value(&format!(
            "(() => {{ const track = document.querySelector('.track input'); track.value = {at}; \
             track.dispatchEvent(new Event('input')); }})()"
        ));
        assert!((time(browser) - at).abs() < 1e-9);
        let rows = browser.value("[...document.querySelectorAll('.readout tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))");
        for (joint, label) in run.record.joints().iter().enumerate() {
            let sample = run.record.tick(tick)[joint];
            let expected = json!([
                label.name,
                format!("{:.4} rad", sample.q),
                engineering(sample.error(), "rad"),
                engineering(sample.torque, "N m"),
            ]);
            assert_eq!(json!(rows[joint].as_array().unwrap()[..4]), expected, "tick {tick}");
        }
    }
}

/// The transforms of the page against those of the plant, which are independent of the controller's.
fn draws_the_arm_where_the_plant_has_it(browser: &mut Browser, scene: &SceneFile, run: &Run) {
    let samples = run.record.tick(1_234);
    let q: [f64; 6] = std::array::from_fn(|joint| samples[joint].q);
    let expected = simulate::arm::<6>(scene).unwrap().tip_pose(&q).1;
    let found = browser.value("tipOfRun(0)");
    for axis in 0..3 {
        let off = found[axis].as_f64().unwrap() - expected[axis];
        assert!(off.abs() < 1e-6, "{found} {expected}");
    }
    let colours = "(() => { const from = document.querySelector('.scene canvas'); const to = document.createElement('canvas'); \
                   [to.width, to.height] = [from.width, from.height]; const pen = to.getContext('2d'); pen.drawImage(from, 0, 0); \
                   return new Set(new Uint32Array(pen.getImageData(0, 0, to.width, to.height).data.buffer)).size; })()";
    browser.until(&format!("{colours} > 50"));
}

fn shows_the_summary(browser: &mut Browser, run: &Run) {
    let written = serde_json::to_string_pretty(&run.summary).unwrap() + "\n";
    assert_eq!(browser.value(&format!("document.getElementById('{SUMMARY}').textContent")), Value::String(written));
    let cells = |table: usize| {
        format!(
            "[...document.querySelectorAll('.table table')[{table}].tBodies[0].rows].map((row) => \
             [...row.cells].map((cell) => [cell.textContent, cell.dataset.exact === undefined ? null : Number(cell.dataset.exact)]))"
        )
    };
    let (quality, loads) = (browser.value(&cells(0)), browser.value(&cells(1)));
    let summary = &run.summary;
    let shown = |cell: &Value, value: f64, unit: &str| {
        assert_eq!((cell[0].as_str().unwrap(), cell[1].as_f64().unwrap()), (engineering(value, unit).as_str(), value));
    };
    for joint in 0..6 {
        let row = &quality[joint];
        shown(&row[1], summary.tracking_rms[joint], "rad");
        shown(&row[2], summary.tracking_max[joint], "rad");
        shown(&row[3], summary.rest_error[joint].unwrap(), "rad");
        match summary.settling_time[joint] {
            Some(time) => shown(&row[4], time, "s"),
            None => assert_eq!(row[4], json!(["never", null])),
        }
        let row = &loads[joint];
        shown(&row[1], summary.torque_rms[joint], "N m");
        shown(&row[2], summary.torque_peak[joint], "N m");
        shown(&row[4], summary.torque_chatter[joint], "N m");
        shown(&row[5], summary.work.given[joint], "J");
        shown(&row[6], summary.work.taken_back[joint], "J");
    }
}

#[test]
fn a_browser_without_webgl_shows_curves_and_says_that_the_arm_is_missing() {
    let Some(mut browser) = Browser::start("flat", FLAT) else { return };
    let scene = scene("puma560_collision.toml");
    let file = write("flat", &page(&run(&scene), &scene).unwrap().html());
    browser.open(&file, 1280, 800);
    browser.until("document.getElementById('viewer').dataset.ready === 'yes'");
    assert_eq!(browser.value("document.getElementById('viewer').dataset.webgl"), "no");
    assert_eq!(browser.value("document.querySelector('.scene').textContent.includes('no WebGL')"), true);
    assert_eq!(browser.value("document.querySelectorAll('.chart canvas').length"), 6);
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_minute_of_motion_fits_in_two_megabytes() {
    let mut scene = scene("puma560_collision.toml");
    scene.plant.push = None;
    scene.plant.integrator = robot_compiler::scene::Integrator::SemiImplicitEuler;
    scene.duration = Some(60.0);
    let run = run(&scene);
    assert_eq!(run.record.ticks(), 60_000);
    let html = page(&run, &scene).unwrap().html();
    assert!((1_000_000..BYTES_MAX).contains(&html.len()), "{}", html.len());
    assert!(html.contains("Every 3") && html.contains("is in this page, as it was"));
}

/// A folder with the report of a run, changed by `change`.
fn folder(name: &str, change: fn(&mut SceneFile)) -> (PathBuf, Run) {
    let mut scene = scene("puma560_pick.toml");
    change(&mut scene);
    let run = run(&scene);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("report.html"), page(&run, &scene).unwrap().html()).unwrap();
    (folder, run)
}

#[test]
fn two_runs_are_compared_from_their_reports_alone() {
    let (a, of_a) = folder("compare_a", |_| {});
    let (b, of_b) = folder("compare_b", |scene| scene.control.law = dynamics_core::control::Law::PdGravity);
    let html = compare::page(&Side::load(&a).unwrap(), &Side::load(&b.join("report.html")).unwrap()).unwrap().html();
    assert!(html.len() < BYTES_MAX, "{}", html.len());
    let change = 100.0 * (of_b.summary.tracking_max[1] / of_a.summary.tracking_max[1] - 1.0);
    assert!(change > 100.0 && html.contains(&format!("<td>{change:+.1} %</td>")), "{change}");

    let Some(mut browser) = Browser::start("compare", WEBGL) else { return };
    for width in [1280, 390] {
        browser.open(&write("compare", &html), width, 800);
        browser.until("document.getElementById('viewer').dataset.ready === 'yes'");
        assert!(browser.beyond() <= 0.0, "{width}");
        browser.press("End");
        let apart = browser.value("Math.hypot(...tipOfRun(0).map((x, k) => x - tipOfRun(1)[k]))").as_f64().unwrap();
        assert!((1e-4..0.1).contains(&apart), "the arm with another law stands elsewhere: {apart} m");
        let names = browser.value("document.querySelector('.chart .values').textContent").to_string();
        assert!(names.contains("A actual") && names.contains("B actual"), "{names}");
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn what_is_no_report_of_a_run_is_not_compared() {
    let (a, _) = folder("compare_bad", |scene| scene.duration = Some(0.01));
    let (run, planar) = {
        let scene = scene("planar2r_swing.toml");
        (simulate::on_desk::<2>(&scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap(), scene)
    };
    let other = write("compare_planar", &page(&run, &planar).unwrap().html());
    let text = write("compare_text", "<!doctype html><p>a page");
    let missing = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compare_missing.html");
    for (b, expected) in
        [(&missing, "there is no such file"), (&text, "no data of one run in it"), (&other, "has 6 joints")]
    {
        let output = at_the_top().arg("compare").args([&a, b]).output().unwrap();
        let (code, out, error) = told(output);
        assert_eq!((code, out.as_str()), (2, ""), "{error}");
        assert!(error.contains(expected) && error.contains("expected"), "{error}");
    }
}

#[test]
fn a_point_of_a_study_hands_over_the_command_that_repeats_it() {
    let Some(mut browser) = Browser::start("study", FLAT) else { return };
    let point = Point::at(100.0, 1e-3).named("best").told("host-sim trade a.toml --scalar f32");
    let figure = Figure::new("cost", "cycles", "error")
        .scaled(Scale::Log, Scale::Log)
        .with(Series::steps("front", vec![point, Point::at(1000.0, 1e-5)]));
    let page = Page { title: "study".to_owned(), lead: vec!["Fine.".to_owned()], blocks: vec![Block::Figure(figure)] };
    for width in [1280, 390] {
        browser.open(&write("study", &page.html()), width, 800);
        assert!(browser.beyond() <= 0.0, "{width}");
        browser.value("document.querySelector('[data-command]').focus()");
        browser.press("Enter");
        browser.until(
            "document.querySelector('.note')?.textContent.includes('host-sim trade a.toml --scalar f32') === true",
        );
    }
    assert_eq!(browser.complaints(), [""; 0]);
}
