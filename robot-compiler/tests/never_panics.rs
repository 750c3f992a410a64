//! Whatever stands in a file, reading it ends in a robot, a linkage, a scene or an error: it never panics, and what was accepted works.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_core::linkage::{Branch, Linkage, LinkagePosture};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use miette::{GraphicalReportHandler, GraphicalTheme};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use robot_compiler::{FileError, LinkageFile, Robot, SceneFile, emit, with_dof};
use std::path::Path;
use std::sync::LazyLock;

mod common;

use common::{files, top};

/// What to do to the bytes of a file, one after the other.
#[derive(Clone, Debug)]
enum Damage {
    Flip(usize, u8),
    Truncate(usize),
    Delete(usize, usize),
    Repeat(usize, usize),
    Insert(usize, &'static str),
}

/// Words that are syntax somewhere, and numbers at the ends of their ranges.
const WORDS: [&str; 28] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "3.5e38",
    "nan",
    "inf",
    "-inf",
    "9223372036854775808",
    "0x7fffffffffffffff",
    "\"",
    "[",
    "]",
    "{",
    "}",
    "[[joint]]\n",
    "[tool]\n",
    "=",
    "\n",
    "#",
    "'''",
    "\u{10ffff}",
    "é",
    "<",
    ">",
    "/>",
    "<link name=\"x\"/>",
];

fn damage() -> impl Strategy<Value = Damage> {
    let at = || any::<prop::sample::Index>().prop_map(|index| index.index(1 << 16));
    prop_oneof![
        4 => (at(), any::<u8>()).prop_map(|(at, byte)| Damage::Flip(at, byte)),
        1 => at().prop_map(Damage::Truncate),
        2 => (at(), 1_usize..60).prop_map(|(at, count)| Damage::Delete(at, count)),
        2 => (at(), 1_usize..60).prop_map(|(at, count)| Damage::Repeat(at, count)),
        4 => (at(), prop::sample::select(WORDS.to_vec())).prop_map(|(at, word)| Damage::Insert(at, word)),
    ]
}

fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    let place = |at: usize| at % bytes.len().max(1);
    let range = |at: usize, count: usize| place(at)..(place(at) + count).min(bytes.len());
    match *damage {
        Damage::Flip(at, byte) => {
            let at = place(at);
            if let Some(old) = bytes.get_mut(at) {
                *old = byte;
            }
        }
        Damage::Truncate(at) => bytes.truncate(place(at)),
        Damage::Delete(at, count) => drop(bytes.drain(range(at, count))),
        Damage::Repeat(at, count) => {
            let range = range(at, count);
            let again = bytes[range.clone()].to_vec();
            bytes.splice(range.end..range.end, again);
        }
        Damage::Insert(at, word) => {
            let at = place(at).min(bytes.len());
            bytes.splice(at..at, word.bytes());
        }
    }
}

/// Text of every shipped robot, linkage and scene and of the URDF of the tests, each with its extension.
static GOOD: LazyLock<Vec<(String, String)>> = LazyLock::new(|| {
    let mut all = files(&top("robots"), &["toml"]);
    all.extend(files(&top("robots/chapter12"), &["toml"]));
    all.extend(files(&top("scenes"), &["toml"]));
    all.extend(files(&top("robot-compiler/tests/data"), &["urdf"]));
    all.iter().map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap())).collect()
});

fn check_error(error: &FileError) {
    let mut text = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).render_report(&mut text, error).unwrap();
    assert!(!error.problem().is_empty() && !error.expected().is_empty(), "{text}");
}

/// An accepted robot has a model in both precisions, and the model has torques.
fn check_robot(robot: &Robot) {
    assert!((1..=6).contains(&robot.dof()));
    with_dof!(robot.dof(), N => {
        let model = robot.model::<N>().unwrap();
        let dynamics = Dynamics::new(model.cast::<f32>(), Scene::free_space());
        let q = [0.0; N];
        let torque = dynamics.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &q, &q, &Live::zero());
        // Nothing moves and nothing pulls.
        assert!(torque.iter().all(|tau| *tau == 0.0), "{torque:?}");
    });
    check_scene(&SceneFile::default_for(robot.clone()));
}

/// An accepted linkage says of every crank angle where its links are and what drives them, or why not.
fn check_linkage(linkage: &LinkageFile) {
    for step in 0..12 {
        let turn = Libm.sin_cos(f64::from(step) * 0.5);
        for branch in [Branch::Open, Branch::Crossed] {
            let motion = |posture: &LinkagePosture<f64>| Ok(posture.coefficients()?.map(|k| k.motion(1.0, 0.0)));
            let forces =
                linkage.mechanism.posture(&turn, branch).and_then(|p| p.forces(&motion(&p)?, &linkage.gravity));
            if let Ok(forces) = forces {
                assert!(forces.driving_moment.is_finite(), "{linkage:?}");
            }
        }
    }
    assert!(
        linkage.mechanism.crank_range().ends().iter().flatten().all(|end| end.sin.is_finite() && end.cos.is_finite())
    );
}

/// An accepted scene can be hashed and written out as source.
fn check_scene(scene: &SceneFile) {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().unwrap();
        assert_eq!(scene.hash(&model), scene.hash(&model));
        assert!(!emit::arm_module(scene, &model).contains("f32::NAN"));
    });
}

fn check(name: &str, bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let result = if name.ends_with(".urdf") {
        Robot::from_urdf_str(&text, name, None).map(|robot| check_robot(&robot))
    } else if name.contains("chapter12") {
        LinkageFile::from_toml_str(&text, name).map(|linkage| check_linkage(&linkage))
    } else if name.contains("scenes") {
        SceneFile::from_toml_str(&text, Path::new(name)).map(|scene| check_scene(&scene))
    } else {
        Robot::from_toml_str(&text, name).map(|robot| check_robot(&robot))
    };
    if let Err(error) = result {
        check_error(&error);
    }
}

fn settings(cases: u32) -> ProptestConfig {
    let failure_persistence = Some(Box::new(FileFailurePersistence::Off) as Box<_>);
    ProptestConfig { cases, failure_persistence, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(settings(3000))]

    #[test]
    fn damaged_files_are_read_or_refused(
        file in any::<prop::sample::Index>(),
        damages in prop::collection::vec(damage(), 1..5),
    ) {
        let (name, text) = file.get(&GOOD);
        let mut bytes = text.clone().into_bytes();
        for damage in &damages {
            apply(&mut bytes, damage);
        }
        check(name, &bytes);
    }

    #[test]
    fn one_number_may_be_anything(file in any::<prop::sample::Index>(), number in any::<prop::sample::Index>(), new in any::<f64>()) {
        let (name, text) = file.get(&GOOD);
        let digits = |c: char| c.is_ascii_digit() || c == '.' || c == '-' || c == 'e';
        let starts: Vec<usize> = text.match_indices(['=', '[', ',', '"']).map(|(at, _)| at + 1).collect();
        let at = *number.get(&starts);
        let at = at + text[at..].find(|c| c != ' ').unwrap_or(0);
        let length = text[at..].find(|c| !digits(c)).unwrap_or(0);
        check(name, format!("{}{new:?}{}", &text[..at], &text[at + length..]).as_bytes());
    }

    #[test]
    fn noise_is_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for name in ["noise.toml", "noise.urdf", "scenes/noise.toml", "chapter12/noise.toml"] {
            check(name, &bytes);
        }
    }
}

/// The readers behind ours are recursive: depth must be refused before they meet it.
#[test]
fn deep_nesting_is_refused() {
    for depth in [10, 31, 32, 33, 100, 10_000, 200_000] {
        check("deep.urdf", format!("<robot>{}{}</robot>", "<a>".repeat(depth), "</a>".repeat(depth)).as_bytes());
        check("deep.toml", format!("name = {}{}", "[".repeat(depth), "]".repeat(depth)).as_bytes());
        check("deep.toml", format!("name = {}{}", "{a=".repeat(depth), "}".repeat(depth)).as_bytes());
        check("deep.toml", format!("{} = 1", "a.".repeat(depth) + "a").as_bytes());
    }
}
