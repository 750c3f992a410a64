//! From a motion for identification to a better robot file, on a simulated YAM that differs from its file in masses, friction and drives.

use crate::program::{at_the_top, new, told};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use nalgebra::Vector3;
use robot_compiler::{Robot, SceneFile};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const SCENE: &str = "scenes/examples/yam_identify.toml";
const ROBOT: &str = "robots/yam.toml";

/// An empty folder of this test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("identify").join(test);
    std::fs::create_dir_all(new(&folder)).unwrap();
    folder
}

fn simulator(arguments: &[&str]) -> Command {
    let mut command = at_the_top();
    command.args(arguments);
    command
}

fn done(arguments: &[&str]) -> String {
    let (code, out, error) = told(simulator(arguments).output().unwrap());
    assert_eq!(code, 0, "{arguments:?}: {error}");
    out
}

/// Records a log of the simulated arm on a motion with this seed. Returns the file.
fn recorded(folder: &Path, seed: &str, periods: &str) -> String {
    let folder = folder.join(seed);
    let (motion, run) = (folder.with_extension("toml"), folder.to_str().unwrap().to_owned());
    let motion = motion.to_str().unwrap();
    done(&[
        "identify",
        "excite",
        SCENE,
        "--seed",
        seed,
        "--periods",
        periods,
        "--period",
        "8",
        "--tries",
        "150",
        "--out",
        motion,
    ]);
    let seconds = if periods == "1" { "10.4" } else { "18.4" };
    done(&["run", SCENE, "--motion", motion, "--duration", seconds, "--out", &run, "--quiet"]);
    format!("{run}/log.csv")
}

/// Largest gravity torque by which the model differs from the true arm, over random postures, N m of each joint.
fn missed(model: &Robot, truth: &Robot) -> [f64; 6] {
    let arm = |robot: &Robot| {
        let model = robot.model::<6>().unwrap();
        Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model))
    };
    let (model, truth) = (arm(model), arm(truth));
    let mut worst = [0.0_f64; 6];
    for step in 0..200 {
        let q: [f64; 6] = core::array::from_fn(|i| 1.2 + 1.2 * (0.7 * f64::from(step) * (1.0 + 0.3 * i as f64)).sin());
        let holding = |arm: &Dynamics<f64, 6>| {
            arm.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &[0.0; 6], &[0.0; 6], &Live::zero())
        };
        for (worst, (a, b)) in worst.iter_mut().zip(holding(&model).iter().zip(holding(&truth))) {
            *worst = worst.max((a - b).abs());
        }
    }
    worst
}

/// Starts from a URDF with geometry alone. The robot file that `import` writes lacks every mass.
fn a_file_without_masses_is_identified_too(folder: &Path, log: &str, other: &str) {
    let [urdf, arm, out] = ["bare.urdf", "bare.toml", "found.toml"].map(|name| folder.join(name).display().to_string());
    done(&["model", "export", ROBOT, "--urdf", "--out", &urdf, "--force"]);
    let text = std::fs::read_to_string(&urdf).unwrap();
    let bare: String = text
        .split("<inertial>")
        .enumerate()
        .map(|(part, text)| if part == 0 { text } else { text.split_once("</inertial>").unwrap().1 })
        .collect();
    assert!(text.contains("<inertial>") && !bare.contains("inertial"));
    std::fs::write(&urdf, bare).unwrap();
    done(&["import", &urdf, "--out", &arm, "--force"]);
    assert_eq!(std::fs::read_to_string(&arm).unwrap().matches("mass = 0.0 # ?").count(), 6);
    let found = done(&["identify", &arm, "--log", log, "--validate", other, "--json", "--out", &out, "--force"]);
    let found: Value = serde_json::from_str(&found).unwrap();
    for joint in found["joints"].as_array().unwrap() {
        let [left, file] = ["relative_rms", "robot_file"].map(|key| joint[key].as_f64().unwrap());
        assert!(left < 0.03 && file < 0.06, "{joint}");
    }
}

#[test]
fn a_simulated_yam_is_identified_from_the_log_of_an_excitation() {
    let folder = folder("yam");
    let (log, other) = (recorded(&folder, "1", "2"), recorded(&folder, "2", "1"));
    let out = folder.join("yam.toml");
    let (report, predicted) = (folder.join("report"), folder.join("predicted.csv"));
    let found = done(&[
        "identify",
        ROBOT,
        "--log",
        &log,
        "--validate",
        &other,
        "--json",
        "--out",
        out.to_str().unwrap(),
        "--report",
        report.to_str().unwrap(),
        "--predict",
        predicted.to_str().unwrap(),
    ]);
    let found: Value = serde_json::from_str(&found).unwrap();
    assert_eq!((found["rank"].as_u64(), found["joints"].as_array().unwrap().len()), (Some(40), 6));
    for joint in found["joints"].as_array().unwrap() {
        let (left, before) = (joint["relative_rms"].as_f64().unwrap(), joint["before"].as_f64().unwrap());
        // A reversal that is shorter than the window of the rest test stays in the fit.
        assert!(left < 0.03 && before > 3.0 * left, "{joint}");
    }
    // The links of this arm weigh 0.8 or 1.2 times the file's values; its rotors are the same.
    let audit = &found["mass_matrix"];
    let ratio: [f64; 2] = serde_json::from_value(audit["ratio"].clone()).unwrap();
    assert!(audit["smallest_eigenvalue"].as_f64().unwrap() > 0.0, "{audit}");
    assert!(ratio[0] > 0.6 && ratio[0] < 1.0 && ratio[1] > 1.0 && ratio[1] < 1.4, "{audit}");

    a_file_without_masses_is_identified_too(&folder, &log, &other);

    // In the new robot file, `check` finds nothing, and gravity is known to within friction.
    let new = Robot::load(&out).unwrap();
    done(&["check", out.to_str().unwrap()]);
    let scene = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(SCENE)).unwrap();
    let mut truth = scene.robot.clone();
    for (joint, factor) in truth.joints.iter_mut().zip([1.2, 0.8, 1.2, 0.8, 1.2, 1.2]) {
        joint.spec.body.mass *= factor;
        joint.spec.body.inertia *= factor;
    }
    let (before, after) = (missed(&scene.robot, &truth), missed(&new, &truth));
    for (joint, coulomb) in [0.4, 0.35, 0.25, 0.08, 0.05, 0.07].into_iter().enumerate() {
        assert!(after[joint] < 0.5 * coulomb, "{after:?}");
    }
    assert!(before[1] > 1.0 && before[2] > 0.5, "{before:?}");

    let page = std::fs::read_to_string(report.join("index.html")).unwrap();
    assert!(page.contains("wrist_roll") && page.matches("<svg").count() == 12, "{}", page.len());
    let table = std::fs::read_to_string(predicted).unwrap();
    assert!(table.starts_with("time,tau_1,tau_2,tau_3,tau_4,tau_5,tau_6,model_1,"), "{}", &table[..80]);
}

/// A log with the numbers of one joint's column changed.
fn spoilt(log: &str, column: &str, change: impl Fn(f64) -> f64) -> String {
    let text = std::fs::read_to_string(log).unwrap();
    let place = text.lines().next().unwrap().split(',').position(|name| name == column).unwrap();
    let row = |(k, line): (usize, &str)| -> String {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let (true, Ok(x)) = (k > 0, fields[place].parse::<f64>()) {
            fields[place] = change(x).to_string();
        }
        fields.join(",") + "\n"
    };
    let path = format!("{log}.{column}.csv");
    std::fs::write(&path, text.lines().enumerate().map(row).collect::<String>()).unwrap();
    path
}

#[test]
fn a_log_with_a_fault_is_refused_and_mended_by_the_option_that_is_named() {
    let folder = folder("fault");
    let log = recorded(&folder, "3", "1");
    let out = folder.join("mended.toml");
    let identify = |log: &str, more: &[&str]| {
        let _ = std::fs::remove_file(&out);
        let common = ["identify", ROBOT, "--log", log, "--plain-friction", "--motion-cutoff", "8"];
        let all = [&common[..], &["--out", out.to_str().unwrap()], more].concat();
        told(simulator(&all).output().unwrap())
    };
    let negated = spoilt(&log, "tau2", |x| -x);
    let (code, text, error) = identify(&negated, &[]);
    assert_eq!(code, 3, "{text}{error}");
    assert!(text.starts_with("verdict             refused"), "{text}");
    assert!(error.contains("torque of joint 2 (shoulder) has the opposite sign [--negate-torque 2]"), "{error}");
    assert!(!out.exists());
    // The option that the message names gives a good model. Without a mistake, no option is named.
    for (log, more) in [(&negated, &["--negate-torque", "2"][..]), (&log, &[][..])] {
        let (code, text, error) = identify(log, more);
        assert!(code == 0 && out.exists() && text.starts_with("verdict             trusted"), "{code} {text}{error}");
    }
    // An invalid option is bad input.
    let (code, _, error) = identify(&log, &["--negate-torque", "7"]);
    assert!(code == 2 && error.contains("joints from 1 to 6, or all"), "{code} {error}");
    let (code, _, error) = identify(&log, &["--permute", "1,2,3,4,5,5"]);
    assert!(code == 2 && error.contains("each of 1 to 6 once"), "{code} {error}");
}

#[test]
fn slow_sweeps_and_rests_can_be_played() {
    let folder = folder("slow");
    for kind in ["--friction", "--static"] {
        let motion = folder.join(format!("{kind}.toml"));
        done(&["identify", "excite", SCENE, kind, "--out", motion.to_str().unwrap()]);
        let run = folder.join(kind);
        done(&["run", SCENE, "--motion", motion.to_str().unwrap(), "--out", run.to_str().unwrap(), "--quiet"]);
    }
}

#[test]
fn what_identify_cannot_use_is_refused_with_what_is_expected() {
    let bad = folder("bad").join("bad.csv");
    std::fs::write(&bad, "time,q_1\n0,0\n").unwrap();
    let bad = bad.to_str().unwrap();
    let cases: [(&[&str], &str); 6] = [
        (&["identify", ROBOT], "--log FILE"),
        (&["identify", ROBOT, "--log", "no/such.csv"], "no/such.csv"),
        (&["identify", ROBOT, "--log", bad], "q_2"),
        (&["identify", ROBOT, "--log", bad, "--torque-per-ampere", "1,2"], "6 numbers"),
        (&["identify", ROBOT, "--log", bad, "--cutoff", "0"], "above zero"),
        (&["identify", "excite", ROBOT, "--centre", "9,9,9,9,9,9"], "inside its limits"),
    ];
    for (arguments, expected) in cases {
        let (code, out, error) = told(simulator(arguments).output().unwrap());
        assert_eq!((code, out.as_str()), (2, ""), "{arguments:?}: {error}");
        assert!(error.contains(expected), "{arguments:?}: {error}");
    }
}
