//! Mechanisms of the textbook's chapter 12 (Jazar, robot dynamics) as files: every arm in `robots/chapter12`, every scene in `scenes/chapter12`.
#![allow(clippy::float_cmp, reason = "a joint that moves nothing takes exactly no torque")]

use crate::program::{at_the_top, told};
use crate::reference;
use crate::reference::relative;
use dynamics_core::JointSpec;
use indicatif::ProgressBar;
use nalgebra::{SVector, Vector3};
use robot_compiler::{Robot, SceneFile, with_dof};
use sim::plant::{Arm, Diverged};
use sim::run::closed_loop::End;
use sim::run::simulate::Run;
use sim::run::simulation;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::dynamics::{DynamicsRequest, DynamicsResult, answer};
use studies::options::GravityArgs;
use studies::statics;

const G: f64 = 9.81;

/// TOML files of a folder that describe serial arms or scenes of them: files without a `kind` before their first table.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder).join("chapter12");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "toml") && !has_kind(path));
    files.sort();
    files
}

fn has_kind(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap();
    let top = text.lines().take_while(|line| !line.trim_start().starts_with('['));
    top.into_iter().any(|line| line.split('=').next().is_some_and(|key| key.trim() == "kind"))
}

fn robot(name: &str) -> Robot {
    Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../robots/chapter12/{name}.toml"))).unwrap()
}

fn scene(name: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/chapter12/{name}.toml"))).unwrap()
}

fn run(scene: &SceneFile) -> Run {
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    simulation::run(scene, &stop, &bar).unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// A request with posture, velocity and acceleration at this fraction of every joint's range.
fn question(robot: &Robot, share: f64, gravity: Vector3<f64>) -> DynamicsRequest {
    let each = |f: &dyn Fn(usize) -> f64| (0..robot.dof()).map(f).collect::<Vec<f64>>();
    let q = each(&|i| {
        let (lo, hi) = robot.joints[i].spec.limits.position;
        // The joints are at different fractions of their ranges. Otherwise the arm would be straight.
        lo + (hi - lo) * (share + 0.07 * i as f64) % 1.0
    });
    DynamicsRequest {
        q,
        qd: Some(each(&|i| 0.9 - 0.4 * i as f64)),
        qdd: Some(each(&|i| -1.4 + 0.9 * i as f64)),
        tau: None,
        wrench_tip: Some(vec![4.0, -3.0, 2.0, 0.5, -0.25, 1.0]),
        gravity: Some(vec![gravity.x, gravity.y, gravity.z]),
    }
}

fn ask<const N: usize>(robot: &Robot, question: &DynamicsRequest) -> DynamicsResult {
    answer(&robot.model::<N>().unwrap(), &[0.0; 3], question).unwrap()
}

/// The same torques from the simulator's independent derivation: bodies about their mass centres, in base axes.
fn of_the_plant<const N: usize>(robot: &Robot, question: &DynamicsRequest) -> [f64; N] {
    let fixed = |list: &[f64]| <[f64; N]>::try_from(list).unwrap();
    let specs: Vec<JointSpec> = robot.joints.iter().map(|joint| joint.spec).collect();
    let [fx, fy, fz, mx, my, mz] = question.wrench_tip.as_deref().unwrap() else { unreachable!("six numbers") };
    let arm = Arm::<N> {
        joints: specs.try_into().unwrap(),
        tool: robot.tool,
        payload: None,
        gravity: Vector3::from_column_slice(question.gravity.as_deref().unwrap()),
        tip_wrench: Some(reference::wrench(&[*fx, *fy, *fz, *mx, *my, *mz])),
    };
    let terms = arm.terms(&fixed(&question.q), &fixed(question.qd.as_deref().unwrap()));
    let inertial = terms.mass_matrix * SVector::from(fixed(question.qdd.as_deref().unwrap()));
    std::array::from_fn(|i| inertial[i] + terms.coriolis[i] + terms.gravity[i] - terms.tip[i])
}

#[test]
fn every_arm_gives_the_torques_of_another_derivation_and_the_accelerations_back() {
    let paths = files("robots");
    assert!(paths.len() >= 21, "{paths:?}");
    let mut worst = [0.0_f64; 2];
    for path in paths {
        let robot = Robot::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(robot.source.len() > 20 && robot.allow_unphysical.is_none(), "{}", path.display());
        for (share, gravity) in [(0.31, Vector3::new(0.0, -G, 0.0)), (0.62, Vector3::new(-3.0, 2.0, -9.0))] {
            let asked = question(&robot, share, gravity);
            let off = with_dof!(robot.dof(), N => {
                let given = ask::<N>(&robot, &asked);
                let torques = relative(&given.tau, &of_the_plant::<N>(&robot, &asked));
                let back = ask::<N>(&robot, &DynamicsRequest { tau: Some(given.tau.clone()), ..asked.clone() });
                [torques, relative(&back.qdd.unwrap(), asked.qdd.as_deref().unwrap())]
            });
            worst = [worst[0].max(off[0]), worst[1].max(off[1])];
            // Measured: 6.9e-16 and 5.8e-14.
            assert!(off[0] < 1e-12 && off[1] < 1e-9, "{} at {share}: {:e}, {:e}", path.display(), off[0], off[1]);
        }
    }
    println!("torques {:.1e}, accelerations {:.1e}", worst[0], worst[1]);
}

/// Mass matrix and gravity torques of a general 2R arm in the chapter's notation (eq. 12.322-12.325, and 12.330-12.331
/// with the missing factor g).
struct Letters {
    l: [f64; 2],
    c: [f64; 2],
    m11: f64,
    m12: f64,
    m21: f64,
    m0: f64,
    iz: [f64; 2],
}

impl Letters {
    fn check(&self, file: &str) {
        let Self { l: [l1, l2], c: [c1, c2], m11, m12, m21, m0, iz: [iz1, iz2] } = *self;
        let q = [0.4, 0.9];
        let (cos1, cos2, cos12) = (f64::cos(q[0]), f64::cos(q[1]), f64::cos(q[0] + q[1]));
        let beside = l1 * (m21 * c2 + m0 * l2) * cos2;
        let d22 = iz2 + m0 * l2 * l2 + m21 * c2 * c2;
        let d11 = 2.0 * beside + iz1 + d22 + m11 * c1 * c1 + (m12 + m21 + m0) * l1 * l1;
        let g2 = (m21 * c2 + m0 * l2) * G * cos12;
        let g1 = ((m21 + m12 + m0) * l1 + m11 * c1) * G * cos1 + g2;
        let gravity = Some(vec![0.0, -G, 0.0]);
        let asked = DynamicsRequest { q: q.to_vec(), qd: None, qdd: None, tau: None, wrench_tip: None, gravity };
        let given = ask::<2>(&robot(file), &asked);
        let d = [d11, beside + d22, beside + d22, d22];
        assert!(relative(&given.mass_matrix.concat(), &d) < 1e-14, "{file}: {:?}, wanted {d:?}", given.mass_matrix);
        assert!(relative(&given.gravity, &[g1, g2]) < 1e-14, "{file}: {:?}, wanted {g1} {g2}", given.gravity);
    }
}

#[test]
fn files_of_2r_arms_hold_the_numbers_that_their_comments_state() {
    let links = Letters { l: [1.0, 0.8], c: [0.45, 0.3], m11: 4.0, m12: 0.0, m21: 2.5, m0: 0.0, iz: [0.4, 0.16] };
    links.check("planar2r_general");
    links.check("planar2r_massless_joints");
    Letters { m12: 3.0, ..links }.check("planar2r_massive_joints");
    Letters { m11: 0.0, m12: 3.0, m21: 0.0, m0: 2.0, iz: [0.01, 0.004], ..links }.check("planar2r_massless_arms");
    let iz = [3.0 / 12.0, 2.0 / 12.0];
    Letters { l: [1.0, 1.0], c: [0.5, 0.5], m11: 3.0, m12: 0.0, m21: 2.0, m0: 0.0, iz }.check("planar2r_uniform");
}

#[test]
fn the_shuttles_arm_is_made_of_the_exercises_cylinders() {
    let robot = robot("srms");
    let mut length = 0.0;
    for (i, joint) in robot.joints.iter().enumerate() {
        let body = joint.spec.body;
        let own = 2.0 * body.com.amax();
        length += own;
        let (across, along) = (body.mass * (0.25 * 0.25 / 4.0 + own * own / 12.0), body.mass * 0.25 * 0.25 / 2.0);
        let moments = body.inertia.diagonal();
        let axis = body.com.iamax();
        assert!((body.mass - 12.0 * own).abs() < 1e-9, "joint {i}");
        for k in 0..3 {
            let wanted = if k == axis { along } else { across };
            assert!((moments[k] - wanted).abs() < 1e-8, "joint {i}: {moments}");
        }
    }
    // 603 inches from the shoulder pitch to the tip, and 12 inches below it.
    assert!((length - 615.0 * 0.0254).abs() < 1e-9, "{length} m");
}

#[test]
fn every_scene_runs_to_its_end_without_a_fault() {
    let paths = files("scenes");
    assert!(paths.len() >= 27, "{paths:?}");
    let worst = std::thread::scope(|scope| {
        let runs: Vec<_> = paths
            .iter()
            .map(|path| {
                scope.spawn(move || {
                    let scene = SceneFile::load(path).unwrap_or_else(|error| panic!("{error}"));
                    let done = run(&scene);
                    assert_eq!((done.end, done.summary.faults), (End::Complete, vec![]), "{}", path.display());
                    assert!((1.0..=2.0).contains(&done.summary.duration), "{}", path.display());
                    let limits = done.summary.limits.iter();
                    assert!(limits.map(|l| l.torque + l.velocity + l.position).sum::<u64>() == 0, "{}", path.display());
                    let error = largest(&done.summary.tracking_max);
                    println!("{}: {error:.1e}", scene.name);
                    error
                })
            })
            .collect();
        runs.into_iter().map(|run| run.join().unwrap()).fold(0.0, f64::max)
    });
    // Measured: 3.2e-4 rad, on the wall.
    assert!((1e-4..5e-4).contains(&worst), "{worst:e}");
}

/// Exercise 32: an arm on a ceiling, with angles from the plumb line and a load of 14 g newtons at its end.
#[test]
fn statics_under_a_ceiling_are_the_closed_form() {
    let done = run(&scene("planar2r_ceiling_uniform"));
    let (first, both) = (30_f64.to_radians().sin(), 75_f64.to_radians().sin());
    let q2 = (18.0 / 2.0 + 14.0) * G * both;
    let q1 = (24.0 / 2.0 + 18.0 + 14.0) * G * first + q2;
    // The controller computes in single precision.
    assert!(relative(&done.summary.torque_peak, &[q1, q2]) < 1e-6, "{:?}", done.summary.torque_peak);
}

#[test]
fn gravity_and_what_it_holds_are_felt_by_the_shuttles_arm() {
    let peak = |name: &str| run(&scene(name)).summary.torque_peak[1];
    let [orbit, orbit_held, earth, earth_held] =
        ["srms_orbit", "srms_orbit_payload", "srms_earth", "srms_earth_payload"].map(peak);
    // Measured: 1194, 1401, 11151 and 14253 N m at the shoulder's pitch joint. On Earth, most of the torque is gravity.
    assert!((1190.0..1200.0).contains(&orbit) && (1395.0..1405.0).contains(&orbit_held), "{orbit} {orbit_held} N m");
    assert!((11.1e3..11.2e3).contains(&earth) && (14.2e3..14.3e3).contains(&earth_held), "{earth} {earth_held} N m");
}

/// Exercises 38 and 19 (d): the greatest load on the base with 24 kg held on Earth. The force is the weight in every posture. The moment is greatest
/// if the arm is horizontal.
#[test]
fn the_greatest_base_load_of_the_shuttles_arm_is_that_of_the_level_arm() {
    let robot = robot("srms");
    let load = |q: &[f64]| {
        let question = statics::StaticsRequest {
            q: Some(q.to_vec()),
            gravity: GravityArgs { gravity: Some(vec![0.0, 0.0, -G]) },
            load: Some(vec![24.0]),
            ..statics::StaticsRequest::default()
        };
        let first = statics::answer(&robot, &question, statics::WrenchFrame::Base).unwrap().joints[0].clone();
        let size = |v: [f64; 3]| Vector3::from(v).norm();
        [size(first.force), size(first.moment)]
    };
    let [force, moment] = load(&[0.0; 6]);
    assert!((force - 2074.3).abs() < 0.05 && (moment - 17_413.8).abs() < 0.05, "{force} N, {moment} N m");
    let limits: Vec<(f64, f64)> = robot.joints.iter().map(|joint| joint.spec.limits.position).collect();
    let at = |share: &dyn Fn(usize) -> f64| -> Vec<f64> {
        limits.iter().enumerate().map(|(i, (low, high))| low + (high - low) * share(i)).collect()
    };
    // Points spread evenly over all six joints, and a fine grid of the joints that bend the arm in its plane.
    let spread = (1..5000).map(|n| at(&|i| (n as f64 * [0.5_f64, 0.333, 0.2, 0.143, 0.091, 0.077][i].sqrt()) % 1.0));
    let bent = (0..8000).map(|n| {
        let mut q = vec![0.0; 6];
        for (k, i) in [1, 2, 3].into_iter().enumerate() {
            let (low, high) = limits[i];
            q[i] = low + (high - low) * ((n / 20_usize.pow(k as u32)) % 20) as f64 / 19.0;
        }
        q
    });
    for q in spread.chain(bent) {
        let [here, turning] = load(&q);
        assert!((here / force - 1.0).abs() < 1e-12 && turning <= moment * (1.0 + 1e-12), "{q:?}: {turning} N m");
    }
}

/// Exercise 33: `Q_1` and `Q_2` drawn over `theta_1`, and the angles at which they, their sum and the energy are least, compared with closed forms in
/// angles from the plumb line.
#[test]
fn statics_draws_both_moments_over_the_first_angle() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("exercise_33");
    std::fs::remove_dir_all(&folder).ok();
    let file = "robots/chapter12/planar2r_ceiling_uniform.toml";
    let bend = std::f64::consts::FRAC_PI_4;
    let (q, load) = (format!("0,{bend}"), "14");
    let command = || {
        let mut command = at_the_top();
        command.args([
            "model",
            "statics",
            file,
            "--gravity",
            "0,-9.81,0",
            "--q",
            &q,
            "--load",
            load,
            "--sweep",
            "shoulder",
        ]);
        command.arg("--out").arg(&folder);
        command
    };
    let (code, json, error) = told(command().arg("--json").output().unwrap());
    assert_eq!((code, error.as_str()), (0, ""));
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    let (first, second) = (24.0 / 2.0 + 18.0 + 14.0, 18.0 / 2.0 + 14.0);
    let rows = found["positions"].as_array().unwrap().iter().zip(found["tau"].as_array().unwrap());
    for (theta, tau) in rows {
        let theta = theta.as_f64().unwrap();
        let q2 = second * G * (theta + bend).sin();
        let wanted = [first * G * theta.sin() + q2, q2];
        for i in 0..2 {
            assert!((tau[i].as_f64().unwrap() - wanted[i]).abs() < 1e-9, "{theta}: {tau} {wanted:?}");
        }
    }
    // Amplitude and lead of `r sin(theta + lead)`, from the weights that each joint carries.
    let wave = |own: f64, bent: f64| {
        let (sine, cosine) = (bent * bend.sin(), own + bent * bend.cos());
        ((sine * sine + cosine * cosine).sqrt() * G, sine.atan2(cosine))
    };
    let least = |i: usize, key: &str| found["least"][i][key].as_f64().unwrap();
    for (i, (size, lead), quarter) in [
        (0, wave(first, second), -0.5),
        (1, (second * G, bend), -0.5),
        (2, wave(first, 2.0 * second), -0.5),
        (3, wave(first, second), 0.0),
    ] {
        // The positions are half a degree apart.
        let off = (least(i, "at") - (quarter * std::f64::consts::PI - lead)).rem_euclid(std::f64::consts::TAU);
        assert!(off.min(std::f64::consts::TAU - off) < 0.0045, "{i}: {}", least(i, "at"));
        assert!((least(i, "value") / -size - 1.0).abs() < 1e-4, "{i}: {} {size}", least(i, "value"));
    }
    let picture = std::fs::read_to_string(folder.join("report.html")).unwrap();
    for word in ["shoulder", "elbow", "potential energy", "position of shoulder / rad"] {
        assert!(picture.contains(word), "{word}");
    }
    let (_, table, _) = told(command().output().unwrap());
    assert!(table.contains("report.html") && table.contains("sum"), "{table}");
    let (code, _, error) =
        told(at_the_top().args(["model", "statics", file, "--q", "0,0", "--sweep", "wrist"]).output().unwrap());
    assert!(code == 2 && error.contains("--sweep wrist: expected a joint"), "{error}");
}

/// Two links; the second has the given mass, tensor and rotor.
fn two_links(second: &str) -> Robot {
    let joint = |name: &str, body: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\ntype = \"revolute\"\ndh = {{ a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }}\n{body}\n"
        )
    };
    let text = format!(
        "name = \"two links\"\n{}{}",
        joint("first", "mass = 1.0\ncom = [-0.5, 0.0, 0.0]\nlimits = { velocity = 5.0 }"),
        joint("second", second)
    );
    Robot::from_toml_str(&text, "two_links.toml").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_last_link_without_mass_is_refused_where_accelerations_are_asked_for_unless_it_has_a_rotor() {
    let asked = DynamicsRequest {
        q: vec![0.3, 0.4],
        qd: None,
        qdd: None,
        tau: Some(vec![1.0, 0.5]),
        wrench_tip: None,
        gravity: Some(vec![0.0, -G, 0.0]),
    };
    let bare = two_links("mass = 0.0\nlimits = { velocity = 5.0 }");
    let refused = answer(&bare.model::<2>().unwrap(), &[0.0; 3], &asked).unwrap_err();
    assert_eq!(
        refused,
        "no accelerations follow from `tau`: joint 2 moves neither mass nor rotor: the inertia matrix is singular"
    );
    // The torques are defined: zero at the second joint.
    assert_eq!(ask::<2>(&bare, &DynamicsRequest { tau: None, ..asked.clone() }).tau[1], 0.0);
    assert_eq!(run(&SceneFile::default_for(bare)).end, End::Diverged(Diverged::SingularInertia));

    let driven = two_links("mass = 0.0\nrotor = { inertia = 1e-4, gear = 30.0 }\nlimits = { velocity = 5.0 }");
    let found = ask::<2>(&driven, &asked).qdd.unwrap();
    assert!((found[1] - 0.5 / (1e-4 * 900.0)).abs() < 1e-12 * found[1].abs(), "{found:?}");
    let done = run(&SceneFile::default_for(driven));
    assert_eq!((done.end, done.summary.faults), (End::Complete, vec![]));
}
