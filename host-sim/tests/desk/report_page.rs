//! Reports in a real browser: they load, play, follow the time slider, and show the numbers of the run.

use crate::browser::{Browser, FLAT, WEBGL};
use crate::pages::WINDOWS;
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use serde_json::{Value, json};
use sim::run::numbers::engineering;
use sim::run::report::{SUMMARY, page};
use sim::run::scene_world;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Largest page, bytes.
pub(crate) const BYTES_MAX: usize = 2_000_000;

/// True if the page's scripts have finished.
pub(crate) const READY: &str = "document.getElementById('viewer').dataset.ready === 'yes'";

pub(crate) fn scene(name: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)).unwrap()
}

pub(crate) fn run(scene: &SceneFile) -> Run {
    run_of::<6>(scene)
}

fn run_of<const N: usize>(scene: &SceneFile) -> Run {
    simulation::run(scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap()
}

pub(crate) fn write(name: &str, html: &str) -> PathBuf {
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
    for (width, height) in WINDOWS {
        browser.open(&file, width, height);
        browser.until(READY);
        assert_eq!(browser.value("document.getElementById('viewer').dataset.webgl"), "yes", "{width}");
        let wide = browser.beyond();
        assert!(wide <= 0.0, "{wide} pixels wider than {width}");
        opens_at_the_largest_error(&mut browser, &run);
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

fn opens_at_the_largest_error(browser: &mut Browser, run: &Run) {
    let ticks = (0..run.record.ticks()).flat_map(|tick| {
        run.record.tick(tick).into_iter().enumerate().map(move |(joint, sample)| (sample.error().abs(), tick, joint))
    });
    let (size, tick, joint) = ticks.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert!(
        (time(browser) - run.record.time()[tick]).abs() < 1e-9,
        "{} and {}",
        time(browser),
        run.record.time()[tick]
    );
    let pressed = "[...document.querySelectorAll('.chips button')].findIndex((chip) => chip.ariaPressed === 'true')";
    assert_eq!(browser.value(pressed), joint + 1);
    let text = browser.value("document.querySelector('.largest').textContent").to_string();
    assert!(text.contains(&run.record.joints()[joint].name) && text.contains(&engineering(size, "rad")), "{text}");
    let unnamed = "[...document.querySelectorAll('button, input, select, a, canvas, svg[role]')].filter((control) => \
         !(control.ariaLabel || control.getAttribute('aria-label') || control.title || control.textContent.trim() \
         || control.labels?.length \
         || control.closest('section[aria-label]') && control.tagName === 'CANVAS')).map((control) => control.outerHTML.slice(0, 80))";
    assert_eq!(browser.value(unnamed), json!([]), "every control has a name");
}

fn plays(browser: &mut Browser) {
    browser.press("Home");
    assert!(time(browser) == 0.0);
    // Slowly: on a busy machine, the run would be over before the second key, which would then play it again.
    for _ in 0..3 {
        browser.press("<");
    }
    browser.press(" ");
    browser.until("Number(document.getElementById('viewer').dataset.time) > 0.01");
    browser.press(" ");
    let stopped = time(browser);
    browser.value("new Promise((done) => setTimeout(done, 150))");
    assert!(stopped > 0.01 && (time(browser) - stopped).abs() < 1e-12, "it stands still when paused");
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

/// Compares the transforms of the page with those of the plant, which are independent of the controller's.
fn draws_the_arm_where_the_plant_has_it(browser: &mut Browser, scene: &SceneFile, run: &Run) {
    let samples = run.record.tick(1_234);
    let q: [f64; 6] = std::array::from_fn(|joint| samples[joint].q);
    let expected = scene_world::arm::<6>(scene).unwrap().tip_pose(&q).1;
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
            None => {
                let rested = engineering(summary.rest_time.unwrap(), "s");
                assert_eq!(row[4], json!([format!("not in {rested}"), null]));
            }
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
    browser.until(READY);
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

/// Text of the charts at the cursor.
const VALUES: &str = "[...document.querySelectorAll('.chart')].map((chart) => chart.querySelector('h3').textContent + ': ' + \
                      [...chart.querySelectorAll('.values span')].map((one) => one.textContent).join('; '))";

#[test]
fn all_joints_of_an_arm_with_a_slide_have_each_its_own_unit() {
    let Some(mut browser) = Browser::start("slide", FLAT) else { return };
    let mut scene = scene("scara_pick.toml");
    scene.duration = Some(0.1);
    let run = run_of::<4>(&scene);
    let html = page(&run, &scene).unwrap().html();
    assert!(html.contains("1 to 4 choose a joint"));
    browser.open(&write("slide", &html), 1280, 800);
    browser.until(READY);
    browser.press("Home");
    browser.press("a");
    let slide = run.record.joints().iter().position(|joint| joint.position_unit() == "m").unwrap();
    let (name, sample) = (&run.record.joints()[slide].name, run.record.tick(0)[slide]);
    let charts = browser.value(VALUES);
    let expect = |chart: usize, title: &str, value: f64, unit: &str| {
        let text = charts[chart].as_str().unwrap();
        let value = format!("{name} {}", engineering(value, unit));
        assert!(text.starts_with(title) && text.split("; ").any(|one| one.ends_with(&value)), "{text}: {value}");
    };
    expect(0, "Position: ", sample.q, "m");
    expect(1, "Position error: ", sample.error(), "m");
    expect(2, "Velocity: ", sample.qd, "m/s");
    expect(3, "Torque or force: ", sample.torque, "N");
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn keys_work_after_a_click_and_an_address_or_an_event_sets_the_time() {
    let Some(mut browser) = Browser::start("keys", FLAT) else { return };
    let scene = scene("puma560_collision.toml");
    browser.open(&write("keys", &page(&run(&scene), &scene).unwrap().html()), 1280, 800);
    browser.until(READY);
    let pressed = "[...document.querySelectorAll('.chips button')].findIndex((chip) => chip.ariaPressed === 'true')";
    browser
        .value("(() => { const chip = document.querySelectorAll('.chips button')[3]; chip.focus(); chip.click(); })()");
    assert_eq!(browser.value(pressed), 3);
    browser.press("Home");
    browser.press("ArrowRight");
    assert!((time(&mut browser) - 1e-3).abs() < 1e-12, "an arrow moves the time while a chip has the focus");
    browser.press("2");
    assert_eq!(browser.value(pressed), 2);
    browser.value("location.hash = '#t=0.4'");
    browser.until("Number(document.getElementById('viewer').dataset.time) === 0.4");
    assert_eq!(browser.value(pressed), 2, "an address without a joint keeps it");
    browser.value("location.hash = '#t=0.3&joint=5'");
    browser.until("Number(document.getElementById('viewer').dataset.time) === 0.3");
    assert_eq!(browser.value(pressed), 5);
    let marks = browser.value("document.querySelector('.marks:not(.largest)').textContent").to_string();
    assert!(marks.contains("band: push") && marks.contains("line: fault"), "{marks}");
    // The same event twice, with another time in between.
    for _ in 0..2 {
        browser.press("Home");
        browser.value("[...document.querySelectorAll('main li a')].find((link) => link.textContent.includes('a push of')).click()");
        assert_eq!(time(&mut browser).to_bits(), scene.plant.push.as_ref().unwrap().at.to_bits());
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn after_a_fault_nothing_that_nobody_computes_is_shown_as_if_it_were() {
    let Some(mut browser) = Browser::start("fault", WEBGL) else { return };
    let scene = scene("puma560_collision.toml");
    let run = run(&scene);
    let fault = run.summary.faults[0].tick;
    browser.open(&write("fault", &page(&run, &scene).unwrap().html()), 1280, 800);
    browser.until(READY);
    for (tick, there) in [(fault - 1, true), (fault + 1, false), (run.record.ticks() - 1, false)] {
        let at = run.record.time()[tick];
        browser.value(&format!("location.hash = '#t={at}'"));
        browser.until(&format!("Number(document.getElementById('viewer').dataset.time) === {at}"));
        let error = browser.value("document.querySelector('.readout tbody tr').cells[2].textContent");
        assert_eq!(error != "\u{2013}", there, "{tick}: {error}");
        let charts = browser.value(VALUES);
        let charts = charts.as_array().unwrap().iter().map(|text| text.as_str().unwrap());
        let outside: Vec<&str> = charts.filter(|text| text.contains("from outside")).collect();
        assert_eq!(outside.len(), 1);
        assert_eq!(!outside[0].contains("external \u{2013}"), there, "{tick}: {outside:?}");
        assert_eq!(browser.value("drawingOf(0).estimate"), there, "{tick}");
    }
    assert_eq!(browser.complaints(), [""; 0]);
}
