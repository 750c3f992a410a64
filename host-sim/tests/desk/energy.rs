//! Energy balance of the command `energy`.
#![allow(clippy::float_cmp, reason = "what is not there is exactly zero")]

use crate::program::{at_its_fixtures, new, told};
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::Integrator;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::energy::{Account, account};

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn scene(path: &str) -> SceneFile {
    SceneFile::load(&here(path)).unwrap()
}

fn of(scene: &SceneFile) -> Account {
    account(scene, &AtomicBool::new(false)).unwrap().1
}

/// Energy account of the swing with friction and a push at the tip, at `steps` per tick.
fn rough(steps: f64) -> Account {
    let mut scene = scene("tests/fixtures/swing.toml");
    scene.plant.friction = true;
    let force = Vector3::new(3.0, -2.0, 0.0);
    scene.plant.tip_wrench = Some(dynamics_core::Wrench { force, moment: Vector3::new(0.0, 0.0, 0.5) });
    scene.plant.step = scene.period() / steps;
    of(&scene)
}

#[test]
fn every_joule_is_accounted_for_to_the_square_of_the_step() {
    let (coarse, fine) = (rough(1.0), rough(4.0));
    let measured = |found: &Account, before: f64| {
        assert!((found.residual_relative / before - 1.0).abs() < 0.05, "{:e}", found.residual_relative);
    };
    measured(&coarse, -3.05e-7);
    measured(&fine, -1.91e-8);
    let ratio = coarse.residual / fine.residual;
    assert!((12.0..20.0).contains(&ratio), "{:e} {:e}", coarse.residual_relative, fine.residual_relative);
    for account in [&coarse, &fine] {
        assert!(
            account.joints.iter().all(|joint| joint.friction < -0.1 && joint.positive > 0.0 && joint.negative < 0.0)
        );
        assert!(account.joints.iter().all(|joint| (joint.positive + joint.negative - joint.total).abs() < 1e-12));
        assert!(account.contact.abs() > 1e-6);
        let given: f64 = account.joints.iter().map(|joint| joint.total + joint.friction).sum::<f64>() + account.contact;
        let gained = account.kinetic.gain() + account.potential.gain();
        assert!((given - gained - account.residual).abs() < 1e-12);
    }
}

#[test]
fn the_account_closes_with_every_integrator_and_refuses_springs() {
    let mut scene = scene("tests/fixtures/swing.toml");
    let mut with = |integrator| {
        scene.plant.integrator = integrator;
        of(&scene).residual_relative
    };
    let euler = with(Integrator::SemiImplicitEuler);
    let adaptive = with(Integrator::Adaptive { tolerance: 1e-9 });
    scene.sensors.jitter = 2e-4;
    scene.actuators.jitter = 2e-4;
    let jitter = of(&scene).residual_relative;
    for (found, before) in [(euler, -6.16e-6), (adaptive, -1.00e-10), (jitter, -3.83e-9)] {
        assert!((found / before - 1.0).abs() < 0.05, "{found:e}, {before:e} before");
    }
    let elastic = SceneFile::load(&here("../scenes/puma560_elastic.toml")).unwrap();
    let Err(refused) = account(&elastic, &AtomicBool::new(false)) else { unreachable!("springs accounted for") };
    assert!(refused.report().to_string().contains("energy in the springs"));
}

#[test]
fn without_friction_a_swing_that_comes_back_takes_back_what_it_gave() {
    let account = of(&scene("tests/fixtures/swing.toml"));
    assert!(account.residual_relative.abs() < 1e-10, "{:e}", account.residual_relative);
    assert!(account.contact == 0.0 && account.joints.iter().all(|joint| joint.friction == 0.0));
    // 2 kg at 0.5 m and 1.5 kg at 1 m and 0.4 m are lifted by the sines of the angles: at least this work was done.
    let height = |q1: f64, q12: f64| 9.81 * ((2.0 * 0.5 + 1.5) * q1.sin() + 1.5 * 0.4 * q12.sin());
    let lift = height(0.8, 1.8) - height(0.0, 0.5);
    let given: f64 = account.joints.iter().map(|joint| joint.positive).sum();
    assert!(given > lift, "{given} {lift}");
    assert!((account.potential.start - height(0.0, 0.5)).abs() < 1e-12, "{account:?}");
    assert!(account.potential.gain().abs() < 1e-2 && account.kinetic.end < 1e-3);
}

#[test]
fn robots_of_six_joints_are_accounted_for_too() {
    for (path, before) in [("../scenes/puma560_pick.toml", -4.17e-7), ("../scenes/ur5_wall_contact.toml", 3.56e-9)] {
        let found = of(&scene(path)).residual_relative;
        assert!((found / before - 1.0).abs() < 0.05, "{path}: {found:e}");
    }
}

fn command(arguments: &[&str], folder: &Path) -> (i32, String, String) {
    told(at_its_fixtures().args(["model", "energy"]).args(arguments).arg("--out").arg(folder).output().unwrap())
}

#[test]
fn the_command_writes_the_account_and_the_power() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("energy");
    new(&folder);
    let (code, table, error) = command(&["tests/fixtures/swing.toml"], &folder);
    assert_eq!((code, error.as_str()), (0, ""));
    for word in
        ["swing: planar, work of every joint", "taken back", "friction", "residual", "energy.json", "report.html"]
    {
        assert!(table.contains(word), "{word} in {table}");
    }
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.contains("power / W") && page.contains("<svg") && page.contains("elbow"), "{page}");

    let (_, json, _) = command(&["tests/fixtures/swing.toml", "--json"], &folder);
    assert_eq!(json, std::fs::read_to_string(folder.join("energy.json")).unwrap());
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json, serde_json::to_value(of(&scene("tests/fixtures/swing.toml"))).unwrap());
    assert_eq!(json["duration"], 1.0);
}

#[test]
fn a_fault_ends_the_account_and_exits_with_3() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("energy-fault");
    new(&folder);
    let (code, table, _) = command(&["tests/fixtures/stale.toml"], &folder);
    assert_eq!(code, 3);
    assert!(table.contains("fault 3: measurement is stale; the account ends there"), "{table}");
    assert!(table.contains("duration            3.00 ms"), "{table}");
}

#[test]
fn a_bad_scene_or_duration_is_an_error_of_input() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("energy-refused");
    new(&folder);
    for (arguments, problem) in [
        (&["tests/fixtures/nowhere.toml"][..], "cannot be read"),
        (&["tests/fixtures/swing.toml", "--duration", "0"], "expected a time in s above zero"),
        (&["tests/fixtures/planar.toml"], "unknown key"),
    ] {
        let (code, out, error) = command(arguments, &folder);
        assert_eq!((code, out.as_str()), (2, ""));
        assert!(error.contains(problem), "{problem} in {error}");
    }
}

/// Exercise 31: 12 kg at 1 m/s, above along the first and below along the second semicircle, with massless links of 1 m.
#[test]
fn energy_on_the_path_of_exercise_31_is_the_closed_forms() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("exercise_31");
    std::fs::create_dir_all(&folder).unwrap();
    let joint = |name: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\ntype = \"revolute\"\ndh = {{ a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }}\n\
             mass = 0.0\nlimits = {{ velocity = 50.0 }}\n"
        )
    };
    let robot = format!("name = \"two massless links\"\n{}{}", joint("shoulder"), joint("elbow"));
    std::fs::write(folder.join("arm.toml"), robot).unwrap();
    let scene = folder.join("scene.toml");
    let text = "name = \"exercise_31\"\nrobot = \"arm.toml\"\n[model]\ngravity = [0.0, -9.81, 0.0]\n\
                payload = { mass = 12.0, com = [0.0, 0.0, 0.0] }\n[motion]\nkind = \"hold\"\nq = [0.3, 0.5]\nduration = 0.1\n";
    std::fs::write(&scene, text).unwrap();
    let radius = 0.75;
    let mut lines = String::new();
    for (second, centre, side) in [(0.0, 0.75, 1.0), (1.0, -0.75, -1.0)] {
        for k in 0..=1000 {
            let angle = std::f64::consts::PI * f64::from(k) / 1000.0;
            let (s, c) = angle.sin_cos();
            let (x, y, vx, vy) = (centre + radius * c, 0.5 + side * radius * s, -s, side * c);
            let (ax, ay) = (-c / radius, -side * s / radius);
            let elbow = ((x * x + y * y - 2.0) / 2.0).acos();
            let shoulder = y.atan2(x) - elbow / 2.0;
            let ((s1, c1), (s12, c12)) = (shoulder.sin_cos(), (shoulder + elbow).sin_cos());
            let across = |vx: f64, vy: f64| [(c12 * vx + s12 * vy) / elbow.sin(), -(c1 * vx + s1 * vy) / elbow.sin()];
            let [w1, w12] = across(vx, vy);
            let [a1, a12] = across(ax + w1 * w1 * c1 + w12 * w12 * c12, ay + w1 * w1 * s1 + w12 * w12 * s12);
            let t = radius * (angle + second * std::f64::consts::PI);
            let (q, qd, qdd) = ([shoulder, elbow], [w1, w12 - w1], [a1, a12 - a1]);
            lines += &format!("{{\"t\": {t}, \"q\": {q:?}, \"qd\": {qd:?}, \"qdd\": {qdd:?}}}\n");
        }
    }
    let path = folder.join("path.jsonl");
    std::fs::write(&path, &lines).unwrap();
    let along = |path: &Path, more: &[&str]| {
        let mut command = at_its_fixtures();
        told(command.args(["model", "energy"]).arg(&scene).arg("--path").arg(path).args(more).output().unwrap())
    };
    let (code, json, error) = along(&path, &["--json"]);
    assert_eq!((code, error.as_str()), (0, ""));
    let found: Value = serde_json::from_str(&json).unwrap();
    // `dynamics-core/tests/work.rs` has the same numbers from the recursion.
    for (joint, given, taken) in [(0, 125.4, 46.61), (1, 69.63, 148.5)] {
        let work = |key: &str| found["joints"][joint][key].as_f64().unwrap();
        assert!((work("positive") / given - 1.0).abs() < 1e-3, "{found}");
        assert!((work("negative") / -taken - 1.0).abs() < 1e-3, "{found}");
    }
    assert!(found["total"].as_f64().unwrap().abs() < 1e-3, "ends as high and as fast as it began: {found}");
    assert_eq!(found["samples"], 2002);
    let (_, table, _) = along(&path, &[]);
    assert!(table.contains("work along a path") && table.contains("2002 states"), "{table}");

    let bad = folder.join("bad.jsonl");
    for (text, words) in [
        ("{\"t\": 0, \"q\": [0, 1], \"qd\": [0, 0], \"qdd\": [0]}", "line 1: `qdd` has 1 number; expected 2 numbers"),
        (
            "{\"t\": 1, \"q\": [0, 1], \"qd\": [0, 0], \"qdd\": [0, 0]}\n{\"t\": 0, \"q\": [0, 1], \"qd\": [0, 0], \"qdd\": [0, 0]}",
            "line 2: `t` is 0; expected a finite time not before 1",
        ),
        ("", "0 states found; expected at least two lines"),
    ] {
        std::fs::write(&bad, text).unwrap();
        let (code, _, error) = along(&bad, &[]);
        assert!(code == 2 && error.contains(words), "{words} in {error}");
    }
}

#[test]
fn the_work_in_a_run_s_summary_is_the_ledger_s() {
    let scene = scene("../scenes/puma560_pick.toml");
    let (run, account) = account(&scene, &AtomicBool::new(false)).unwrap();
    for (joint, ledger) in account.joints.iter().enumerate() {
        let (given, back) = (run.summary.work.given[joint], run.summary.work.taken_back[joint]);
        // The summary includes neither the motion in the last tick nor a change of direction inside a tick.
        let off = (given + back - ledger.total).abs();
        assert!(off < 1e-3 * (ledger.positive - ledger.negative), "{}: {off} J", ledger.name);
        assert!((given / ledger.positive - 1.0).abs() < 0.01 && back <= 0.0, "{given} {}", ledger.positive);
    }
}
