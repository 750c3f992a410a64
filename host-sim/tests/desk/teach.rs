//! A hand-guided arm: the YAM with simulated drives, pushed at its gripper and let go.

use indicatif::ProgressBar;
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::MotionSpec;
use sim::run::closed_loop::End;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::path::Path as FilePath;
use std::sync::atomic::AtomicBool;
use studies::taught::{Path, taught};

const DOF: usize = 6;

fn scene() -> SceneFile {
    let path = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/yam_teach.toml");
    SceneFile::load(&path).unwrap()
}

fn run(scene: &SceneFile) -> Run {
    let run = simulation::run(scene, &AtomicBool::new(false), &ProgressBar::hidden()).unwrap();
    assert_eq!((run.end, run.summary.faults.as_slice()), (End::Complete, [].as_slice()));
    run
}

/// Position of each joint at a time, rad.
fn at(run: &Run, time: f64) -> [f64; DOF] {
    let tick = (time * 1000.0) as usize;
    std::array::from_fn(|joint| run.record.joint(joint).nth(tick).unwrap().q)
}

/// Largest distance of any joint between two times, rad.
fn moved(run: &Run, from: f64, to: f64) -> f64 {
    let (from, to) = (at(run, from), at(run, to));
    (0..DOF).map(|i| (to[i] - from[i]).abs()).fold(0.0, f64::max)
}

/// A longer scene, so that the swing after the push has come to rest.
fn long(mut scene: SceneFile) -> SceneFile {
    scene.motion = MotionSpec::Hold { q: scene.motion.start().to_vec(), duration: 8.0 };
    scene
}

#[test]
fn pushed_by_five_newtons_it_moves_and_let_go_it_stays() {
    let scene = long(scene());
    let run = run(&scene);
    assert!(moved(&run, 0.0, 0.4) < 1e-3, "before the push: {} rad", moved(&run, 0.0, 0.4));
    assert!(moved(&run, 0.5, 1.5) > 0.2, "pushed: {} rad", moved(&run, 0.5, 1.5));
    // A joint that has come to rest in a wall is pushed out of it slowly.
    let walls = &scene.control.teach.as_ref().unwrap().wall;
    let (from, to) = (at(&run, 6.0), at(&run, 7.5));
    let outside = (0..DOF).filter(|i| {
        let (lo, hi) = scene.robot.joints[*i].spec.limits.position;
        (lo + walls[*i]..=hi - walls[*i]).contains(&from[*i])
    });
    let drifts: Vec<f64> = outside.map(|i| (to[i] - from[i]).abs() / 1.5).collect();
    assert!(drifts.len() >= 4 && drifts.iter().all(|drift| *drift < 1e-3), "let go: {drifts:?} rad/s");
    for (joint, robot) in scene.robot.joints.iter().enumerate() {
        let (lo, hi) = robot.spec.limits.position;
        assert!(run.record.joint(joint).all(|sample| (lo..=hi).contains(&sample.q)), "{}", robot.name);
    }
}

#[test]
fn a_fifth_too_heavy_it_sinks_no_faster_than_its_ceiling_and_held_harder_not_at_all() {
    let mut heavy = long(scene());
    (heavy.plant.push, heavy.plant.masses) = (None, vec![1.2; DOF]);
    let run_once = run(&heavy);
    let ceiling = heavy.control.teach.as_ref().unwrap().speed.clone();
    for (joint, ceiling) in ceiling.iter().enumerate() {
        let fastest = run_once.record.joint(joint).map(|sample| sample.qd.abs()).fold(0.0, f64::max);
        assert!(fastest < 1.3 * ceiling, "joint {joint}: {fastest} rad/s, ceiling {ceiling}");
    }
    assert!(moved(&run_once, 0.0, 7.0) > 0.1, "a fifth of the weight is more than what keeps it");
    heavy.control.teach.as_mut().unwrap().breakaway = vec![0.3, 3.0, 2.0, 0.5, 0.3, 0.1];
    let held = run(&heavy);
    let drift = moved(&held, 6.0, 7.5) / 1.5;
    assert!(moved(&held, 0.0, 7.0) < 0.05 && drift < 1e-3, "{} rad, {drift} rad/s", moved(&held, 0.0, 7.0));
}

#[test]
fn a_wall_stops_it_before_the_limit() {
    let mut scene = long(scene());
    let push = scene.plant.push.as_mut().unwrap();
    push.duration = 3.0;
    push.wrench.force = Vector3::new(0.0, 12.0, 0.0);
    let run = run(&scene);
    for (joint, robot) in scene.robot.joints.iter().enumerate() {
        let (lo, hi) = robot.spec.limits.position;
        assert!(run.record.joint(joint).all(|sample| (lo..=hi).contains(&sample.q)), "{}", robot.name);
    }
}

fn bad(scene: &SceneFile, text: &str) -> String {
    let file = std::env::temp_dir().join(format!("newtau-path-{}.csv", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let error = Path::load::<DOF>(&file, scene).and_then(|path| taught::<DOF>(scene, &path, 0.01)).unwrap_err();
    std::fs::remove_file(&file).unwrap();
    error.report().to_string()
}

#[test]
fn the_path_that_it_was_led_along_becomes_a_motion_that_runs() {
    let scene = scene();
    let led = run(&scene);
    let file = std::env::temp_dir().join(format!("newtau-led-{}.csv", std::process::id()));
    led.record.write_csv(std::fs::File::create(&file).unwrap()).unwrap();
    let path = Path::load::<DOF>(&file, &scene).unwrap();
    assert_eq!(path.samples.len(), led.record.ticks());
    let tolerance = 0.02;
    let motion = taught::<DOF>(&scene, &path, tolerance).unwrap();
    // The swing after a push has more detail than 16 points can follow within the tolerance.
    assert!(motion.error < 0.15 && (3..=16).contains(&motion.points.len()), "{} rad: {motion:?}", motion.error);
    // The motion starts and ends where the guided path does, without the rests.
    for (i, (from, to)) in at(&led, 0.0).into_iter().zip(at(&led, 3.9)).enumerate() {
        assert!((motion.points[0][i] - from).abs() <= tolerance, "joint {i} starts elsewhere");
        assert!((motion.points.last().unwrap()[i] - to).abs() <= tolerance, "joint {i} ends elsewhere");
    }
    // Another scene of the same arm runs it.
    let text = motion.toml();
    std::fs::write(&file, &text).unwrap();
    let plays = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/yam_move.toml");
    let mut plays = SceneFile::load(&plays).unwrap();
    plays.take_motion(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    let played = run(&plays);
    let worst = played.summary.tracking_max.iter().copied().fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst} rad");
}

#[test]
fn a_path_that_cannot_be_one_is_told_with_its_line() {
    let scene = scene();
    let head = "t,q1,q2,q3,q4,q5,q6\n";
    let row = |t: f64, q: f64| format!("{t},{q},1,1,0,0,0\n");
    let (a, b, c) = (row(0.0, 0.0), row(0.1, 0.2), row(0.2, 0.4));
    let tables = [
        (format!("t,q1,q2,q3,q4,q5\n{a}{b}{c}"), "line 1: no column q6 or q_6 or sensed_6"),
        (format!("s,q1,q2,q3,q4,q5,q6\n{a}{b}{c}"), "line 1: no column t, time or tick"),
        (format!("{head}{a}{b}0.2,x,1,1,0,0,0\n"), "line 4, q1: found \"x\", expected a number"),
        (format!("{head}{a}{b}0.2,NaN,1,1,0,0,0\n"), "line 4, q1: found \"NaN\", expected a number"),
        (format!("{head}{a}{c}{b}"), "sample 3: time 0.1 after 0.2, expected time that rises"),
        (format!("{head}{a}{b}"), "2 samples of the joints, expected 3 or more"),
        (
            format!("{head}{a}{b}{}", row(0.2, 4.0)),
            "sample 3 at 0.200 s: base is at 4.0000, expected a path inside its limits",
        ),
        (format!("{head}{a}{}{}", row(0.1, 0.0), row(0.2, 0.0)), "no joint moves by more than 0.01"),
    ];
    for (text, expected) in tables {
        let found = bad(&scene, &text);
        assert!(found.contains(expected), "{found:?}, expected {expected:?}");
    }
}
